// Every command on the command line: its options with their units, ranges and defaults.
#include <cmath>
#include <thread>

#include "models/mesh/generated.h"
#include "models/program/commands.h"
#include "models/program/nearest_name.h"
#include "models/program/option_values.h"

namespace sandglass::host {

namespace {

constexpr const char* k_panoramas = "Files that end in .hdr or .exr, or folders of them";
constexpr const char* k_shipped = "the shipped one";
constexpr const char* k_scene = "the scene's";

CLI::Option* add_output(CLI::App* command, std::string& file, const char* type, const char* help) {
  return add_option(command, "-o,--output", file, type, help)->required();
}

void add_run_shot(CLI::App* command, RunOptions& o) {
  CLI::Option* panorama = add_option(command, "--panorama", o.panorama, "FILE", "For a shot: the room, .hdr or .exr");
  CLI::Option* photo =
      add_option(command, "--photo", o.photo, "FILE", "For a shot: a photograph behind the scene, PNG or JPEG");
  CLI::Option* fov = command->add_option("--fov", o.fov_deg, "Field of view of --photo across the diagonal, degrees");
  fov->type_name("DEGREES")->check(number(5, 150))->default_str("")->needs(photo);
  photo->excludes(panorama)->needs(fov);
  add_option(command, "--light", o.light, "KIND",
             "For a shot: light of the panorama's labels, of the network, or any other")
      ->check(one_of({"labels", "estimate", "arbitrary"}));
  add_option(command, "--network", o.network, "FILE", "For a shot: the lighting network")->default_str(k_shipped);
}

void add_run_results(CLI::App* command, RunOptions& o) {
  add_option(command, "--out", o.out, "FOLDER", "Write reports, contact sheet, frames and film into this folder");
  command->add_flag("--plain", o.plain, "Draw without label, ruler and checker, in warmer colours");
  add_option(command, "--dump", o.dump, "FOLDER",
             "Write positions, velocities and radii of every frame into this folder, .npy");
  CLI::Option* record =
      add_option(command, "--record", o.record, "FILE", "Write what every frame was given and did to this file");
  add_option(command, "--replay", o.replay, "FILE", "Repeat the run of such a file, to the bit")->excludes(record);
}

void add_run(CLI::App* command, int* exit_code) {
  RunOptions& o = options_of(command, exit_code, run_command);
  command->add_option("SCENE", o.scene, "Scene file, or the name of a shipped scene")->required();
  add_option(command, "--mesh", o.mesh, "FILE", "Mesh of the scene's bodies of shape \"mesh\"");
  add_option(command, "--object,--collider-mesh", o.collider_mesh, "FILE",
             "Mesh of the scene's colliders of shape \"mesh\"");
  add_option(command, "--asset", o.asset, "FILE", "Baked shadow of that object")->default_str(k_scene);
  add_option(command, "--frames", o.frames, "N", "Frames to run")
      ->check(whole_number(1, 100'000'000))
      ->default_str(k_scene);
  add_option(command, "--budget-ms", o.budget_ms, "MS", "Budget of a frame, ms")
      ->check(number(0, 1e6))
      ->default_str(k_scene);
  add_run_shot(command, o);
  add_threads(command, o.threads);
  add_isa(command, o.isa);
  add_option(command, "--clock", o.clock, "KIND",
             "Clock of the budget; virtual adds 5 microseconds a reading: equal plans everywhere")
      ->check(one_of({"real", "virtual"}));
  add_run_results(command, o);
}

void add_view(CLI::App* command, int* exit_code) {
#ifdef SANDGLASS_HAVE_VIEW
  ViewOptions& o = options_of(command, exit_code, view_command);
  LiveOptions& live = o.live;
  command->add_option("SCENE", live.scene, "Scene file, or the name of a shipped scene")->required();
  add_option(command, "--mesh", live.mesh, "FILE", "Mesh of the scene's bodies of shape \"mesh\"");
  add_option(command, "--collider-mesh", live.collider_mesh, "FILE", "Mesh of the scene's colliders of shape \"mesh\"");
  add_option(command, "--budget-ms", live.budget_ms, "MS", "Budget of a frame, ms")
      ->check(number(0.1, 1000))
      ->default_str(k_scene);
  add_threads(command, live.threads);
  add_isa(command, live.isa);
  add_option(command, "--width", o.width, "N", "Width of the window, pixels")->check(whole_number(320, 8192));
  add_option(command, "--height", o.height, "N", "Height of the window, pixels")->check(whole_number(240, 8192));
  CLI::Option* frames =
      add_option(command, "--frames", o.frames, "N", "End after this many frames, each 1/60 s of the scene")
          ->check(whole_number(1, 1'000'000))
          ->default_str("until the window is closed");
  add_option(command, "--screenshot", o.screenshot, "FILE", "Write the last frame to this file, .png")->needs(frames);
  add_option(command, "--script", o.script, "EVENTS",
             "Mouse and keys by frame: \"10 down P; 60 up P; 61 cursor 400 300; 61 press right\"")
      ->needs(frames);
#else
  static_cast<void>(exit_code);
  leave_out(command, "this build has no viewer",
            "Install libglfw3-dev and libepoxy-dev (Debian's names), configure and build again.");
#endif
}

void add_light(CLI::App* command, int* exit_code) {
  LightOptions& o = options_of(command, exit_code, light_command);
  command->add_option("IMAGES", o.images, "PNG or JPEG files")->required();
  add_output(command, o.folder, "FOLDER", "Write a JSON file and a picture for each image into this folder");
  add_option(command, "--fov", o.fov_deg, "DEGREES", "Field of view across the diagonal, degrees")
      ->check(number(10, 170));
  add_option(command, "--turn", o.turn_deg, "DEGREES", "Clockwise turn that makes the images upright, degrees")
      ->check(one_of({"0", "90", "180", "270"}));
  add_option(command, "--network", o.network, "FILE", "The lighting network")->default_str(k_shipped);
}

void add_inspect(CLI::App* command, int* exit_code) {
  InspectOptions& o = options_of(command, exit_code, inspect_command);
  command->add_option("FILE", o.file, "The file, or the name of a shipped scene")->required();
  add_option(command, "--mesh", o.mesh, "FILE", "For a scene: mesh of its bodies of shape \"mesh\"");
}

#ifdef SANDGLASS_HAVE_BAKE
CLI::Validator angle(int low, int high) {
  const std::string range = std::to_string(low) + " to " + std::to_string(high) + " degrees";
  const auto holds = [=](const std::string& text) {
    double value = 0;
    return read_degrees(text, &value) && value >= low && value <= high;
  };
  return value_that(holds, range, "an angle from " + range + ", such as 20deg");
}

CLI::Validator shape_of_network() {
  const auto holds = [](const std::string& text) {
    NetworkShape shape;
    return read_shape(text, &shape);
  };
  return value_that(holds, "8x1 to 256x8", "WIDTHxLAYERS with 8 to 256 neurons and 1 to 8 layers, such as 128x2");
}

CLI::Validator texels_of_ambient() {
  const auto holds = [](const std::string& text) {
    const CLI::Validator number = whole_number(0, 256);
    std::string copy = text;
    return number(copy).empty() && std::stoi(text) % 16 == 0;
  };
  return value_that(holds, "0 to 256", "a multiple of 16 from 0 to 256");
}
#endif

void add_bake(CLI::App* command, int* exit_code) {
#ifdef SANDGLASS_HAVE_BAKE
  BakeOptions& o = options_of(command, exit_code, bake_command);
  BakeSettings& settings = o.settings;
  settings.threads = std::max(1u, std::thread::hardware_concurrency());
  constexpr uint64_t k_most_steps = 100'000'000;
  command->add_option("MESH", o.mesh, "A mesh file (y up, metres), or the name of a generated mesh")->required();
  add_output(command, o.output, "FILE", "Write the shadow to this file");
  add_option(command, "--size", o.size, "WxL", "Size of the network: neurons a layer, and layers after the first")
      ->check(shape_of_network());
  add_option(command, "--angle", o.angle, "ANGLE", "Angular diameter of the light")->check(angle(1, 60));
  add_option(command, "--max-polar", o.polar, "ANGLE", "Largest angle of the light from the zenith")
      ->check(angle(1, 84));
  add_option(command, "--plane", o.plane, "KIND", "Square of the plane: fitted to each light, or one fixed for all")
      ->check(one_of({"fitted", "fixed"}));
  add_seed(command, settings.seed, "Equal seeds give equal files on CPUs of one instruction set");
  add_threads(command, settings.threads)->default_str("all of this machine");
  add_option(command, "--steps", settings.steps, "N", "Steps of training")->check(whole_number(1, k_most_steps));
  add_option(command, "--quantised-steps", settings.quantised_steps, "N", "Further steps with rounded weights")
      ->check(whole_number(0, k_most_steps));
  add_option(command, "--rate", settings.rate, "X", "Learning rate at the start")->check(number(1e-5, 1));
  add_option(command, "--textures", settings.textures, "N", "Rays, as many as for this many whole textures")
      ->check(whole_number(1, 3000));
  add_option(command, "--validation-lights", settings.validation_lights, "N",
             "Unseen lights that the error is measured on")
      ->check(whole_number(1, 100'000));
  add_option(command, "--ambient-texels", settings.ambient.texels, "N",
             "Texels a side of the ambient shadow, in steps of 16; 0: leave it and the surface out")
      ->check(texels_of_ambient());
  command->add_flag("--ambient-only", o.ambient_only,
                    "Train nothing: make the ambient shadow and the surface of the file that -o names anew");
  add_option(command, "--picture", o.picture, "FILE",
             "Draw truth, result and difference for four lights and two rooms to this file, .png")
      ->default_str("OUTPUT.png");
  command->add_flag("--no-picture", o.no_picture, "Draw no picture");
  add_json(command, o.json);
  command->add_flag("--keep-float", settings.keep_float, "Keep the float network in the file, for `bench shadow`");
  command->add_flag("--resume", o.resume, "Go on where an interrupted bake of the same command stopped");
#else
  static_cast<void>(exit_code);
  leave_out(command, "this build has no ray tracer", "Install Embree and Eigen, configure and build again.");
#endif
}

void add_sample(CLI::App* command, int* exit_code) {
  constexpr uint64_t k_most_points = 1u << 26;
  SampleOptions& o = options_of(command, exit_code, sample_command);
  command->add_option("MESH", o.mesh, "A mesh file, or " + list_of(mesh_names(), "or"));
  const auto of_mesh = [&](const char* name, SampleWhat what, const char* help) {
    command->add_flag_callback(
        name, [&o, what] { o.what = what, ++o.kinds; }, help);
  };
  of_mesh("--surface", SampleWhat::surface, "Poisson disk samples on the surface of MESH");
  of_mesh("--volume", SampleWhat::volume, "Poisson disk samples in the volume of MESH");
  of_mesh("--lattice", SampleWhat::lattice, "Hexagonal close packing in the volume of MESH");
  const auto of_shape = [&](const char* name, SampleWhat what, const char* help) {
    const auto take = [&o, what](uint32_t count) { o.what = what, o.count = count, ++o.kinds; };
    command->add_option_function<uint32_t>(name, take, help)->type_name("N")->check(whole_number(1, k_most_points));
  };
  of_shape("--disk", SampleWhat::disk, "This many points of the unit disk");
  of_shape("--sphere", SampleWhat::sphere, "This many points of the unit sphere");
  of_shape("--ring", SampleWhat::ring, "This many points of a ring of the unit sphere");
  add_option(command, "--polar", o.polar_deg, "DEGREES", "Two polar angles that bound the ring, degrees")
      ->expected(2)
      ->check(number(0, 180));
  const auto above_zero = [](const std::string& text) {
    double value = 0.0;
    return CLI::detail::lexical_cast(text, value) && value > 0.0 && std::isfinite(value);
  };
  add_option(command, "--distance", o.distance, "METRES", "Least distance between two points on or in MESH, metres")
      ->check(value_that(above_zero, "above 0", "a number above 0"))
      ->default_str("");
  add_seed(command, o.seed, "Equal seeds give equal points");
  command->add_flag("--geodesic", o.geodesic, "Measure the distance along the surface");
  add_option(command, "--picture", o.picture, "FILE", "Also draw the points, .png");
  add_option(command, "--spectrum", o.spectrum, "FILE", "Also plot the power spectrum of the points, .png");
  add_output(command, o.output, "FILE", "Write the points to this file, .ply");
}

void add_room(CLI::App* command, int* exit_code) {
  RoomOptions& o = options_of(command, exit_code, room_command);
  add_seed(command, o.seed, "Equal seeds give equal rooms");
  add_output(command, o.output, "FILE", "Write the panorama to this file, .hdr; its depth goes beside it");
  add_option(command, "--picture", o.picture, "FILE", "Also write a tone-mapped picture, .png");
  add_option(command, "--width", o.width, "N", "Width in pixels, even; the height is half of it")
      ->check(whole_number(16, 8192));
  add_option(command, "--samples", o.samples, "N", "Paths a pixel")->check(whole_number(1, 65536));
  add_threads(command, o.threads);
}

void add_dataset(CLI::App* command, int* exit_code) {
  DatasetOptions& o = options_of(command, exit_code, dataset_command);
  command->add_option("PANORAMAS", o.panoramas, k_panoramas)->required();
  add_output(command, o.folder, "FOLDER", "Write images, manifest.csv and sheet.png into this folder");
  add_option(command, "--manifest", o.manifest, "FILE",
             "CSV with the columns file, group and fold: which panoramas show the same place");
  add_seed(command, o.seed, "Equal seeds give equal views");
  add_option(command, "--tiles", o.tiles, "N", "Images on the contact sheet")->check(whole_number(0, UINT64_MAX));
  add_threads(command, o.threads);
}

void add_light_features(CLI::App* command, int* exit_code) {
  LightFeaturesOptions& o = options_of(command, exit_code, light_features_command);
  command->add_option("NETWORK", o.network, "File of the lighting network")->required();
  command->add_option("DATASET", o.folder, "Folder that `sandglass dataset` made")->required();
  add_output(command, o.output, "FILE", "Write one row an image to this file, .npy");
  command->add_flag("--mirror", o.mirror, "Add the rows of the mirrored images behind them");
}

void add_quantise_light(CLI::App* command, int* exit_code) {
  QuantiseLightOptions& o = options_of(command, exit_code, quantise_light_command);
  command->add_option("WEIGHTS", o.weights, "The trained network, as train.py exports it, .npz")->required();
  add_option(command, "--calibrate", o.folders, "FOLDERS",
             "Folders that `sandglass dataset` made; without --measure half of their images measure the error")
      ->required();
  add_option(command, "--measure", o.measured, "FOLDERS", "Folders of other places, whose images measure the error");
  add_output(command, o.output, "FILE", "Write the network to this file");
  add_option(command, "--name", o.name, "NAME", "Name of the network, kept in the file");
  add_option(command, "--images", o.images, "N", "Images that calibrate, and as many that measure")
      ->check(whole_number(2, 10000));
  command->add_flag("--keep-float", o.keep_float,
                    "Keep the float network in the file, 30 MB more, for XNNPACK in float");
}

void add_ceiling(CLI::App* command, int* exit_code) {
  CeilingCommandOptions& o = options_of(command, exit_code, ceiling_command);
  command->add_option("PANORAMAS", o.ceiling.panoramas, k_panoramas)->required();
  add_option(command, "--object", o.object, "MESH", "Object that is lit: a mesh file, or the name of a generated mesh");
  add_option(command, "--views", o.ceiling.views, "N", "Views of each panorama")->check(whole_number(1, 8));
  add_option(command, "--samples", o.ceiling.samples, "N", "Paths a pixel")->check(whole_number(1, 4096));
  add_option(command, "--rows", o.rows, "N", "Rows of the table, best first")->check(whole_number(0, UINT64_MAX));
  add_threads(command, o.ceiling.threads);
}

struct CommandRow {
  const char *name, *help;
  void (*add)(CLI::App* command, int* exit_code);
};
struct CommandGroup {
  const char* name;
  std::vector<CommandRow> commands;
};

}  // namespace

void add_commands(CLI::App& program, int* exit_code) {
  const CommandGroup groups[] = {
      {"Run and look",
       {{"run", "Run a scene under its budget, report on it and draw it", add_run},
        {"view", "Show a running scene in a window", add_view},
        {"light", "Estimate the light of photographs", add_light},
        {"inspect", "Say what a file is: a recording, a shadow, a lighting network, a scene or a mesh", add_inspect}}},
      {"Make what an app loads",
       {{"bake", "Train the soft shadow of a mesh", add_bake},
        {"sample", "Fill or cover a mesh, a disk, a sphere or a ring with points", add_sample}}},
      {"Train the lighting network",
       {{"room", "Make up an indoor room and trace its HDR panorama", add_room},
        {"dataset", "Cut camera images and light labels out of HDR panoramas", add_dataset},
        {"light-features", "Write what the lighting network's heads see", add_light_features},
        {"quantise-light", "Turn the trained lighting network into bytes", add_quantise_light},
        {"ceiling", "Measure how well the true light labels light an object", add_ceiling}}},
      {"Measure and check",
       {{"bench", "Measure the speed of this machine, with the errors of the same run", add_bench},
        {"verify", "Check every claim of accuracy; exit code 1 if one fails", add_verify}}}};
  for (const CommandGroup& group : groups)
    for (const CommandRow& row : group.commands)
      row.add(program.add_subcommand(row.name, row.help)->group(group.name), exit_code);
}

}  // namespace sandglass::host
