// The program `sandglass`, and every command on its command line: the options with their units, ranges and defaults.
#include <thread>

#include "models/files/failure.h"
#include "models/mesh/generated.h"
#include "models/phones/phone.h"
#include "models/program/command_line.h"
#include "models/program/commands.h"

namespace sandglass::host {

namespace {

using Options = std::vector<CommandOption>;

constexpr const char* k_panoramas = "Files that end in .hdr or .exr, or folders of them";
constexpr const char* k_shipped = "the shipped one";
constexpr const char* k_scene = "the scene's";
constexpr const char* k_scene_argument = "Scene file, or the name of a shipped scene";
constexpr const char* k_body_mesh = "Mesh of the scene's bodies of shape \"mesh\"";
constexpr const char* k_collider_mesh = "Mesh of the scene's colliders of shape \"mesh\"";

CommandOption output(std::string& file, const char* type, const char* help) {
  return required({"-o,--output", &file, type, help});
}
CommandOption output_file(std::string& file, const char* help) { return writes(output(file, "FILE", help)); }

CommandOption scale_option(MeshOptions& o) {
  return {"--scale", &o.scale, "METRES", "Metres of a mesh file's unit, such as 0.001 for millimetres",
          number(1e-9, 1e9)};
}
CommandOption up_option(MeshOptions& o) {
  return {"--up", &o.up, "AXIS", "Which axis of a mesh file points up", one_of({"y", "z"})};
}

Options run_options(RunOptions& o) {
  return {
      required({"SCENE", &o.scene, "", k_scene_argument}),
      {"--mesh", &o.mesh, "FILE", k_body_mesh},
      {"--object,--collider-mesh", &o.collider_mesh, "FILE", k_collider_mesh},
      scale_option(o.as_mesh),
      up_option(o.as_mesh),
      standard(k_scene, {"--asset", &o.asset, "FILE", "Baked shadow of that object"}),
      standard(k_scene, {"--frames", &o.frames, "N", "Frames to run", whole_number(1, 100'000'000)}),
      standard(k_scene, {"--budget-ms", &o.budget_ms, "MS", "Budget of a frame, ms", number(0, 1e6)}),
      {"--panorama", &o.panorama, "FILE", "For a shot: the room, .hdr or .exr"},
      needs("--panorama",
            {"--later", &o.later, "FILE", "That room from the middle of the run on: a lamp is switched off"}),
      needs("--fov", excludes("--panorama",
                              {"--photo", &o.photo, "FILE", "For a shot: a photograph behind the scene, PNG or JPEG"})),
      needs("--photo", standard("", {"--fov", &o.fov_deg, "DEGREES",
                                     "Field of view of --photo across the diagonal, degrees", number(5, 150)})),
      {"--light", &o.light, "KIND",
       "For a shot: the room as a session sees it, the truth, one light by the network, or nothing known",
       one_of({"room", "truth", "estimate", "nothing"})},
      threads_option(o.threads),
      isa_option(o.isa),
      {"--clock", &o.clock, "KIND",
       "Clock of the budget; virtual adds 5 microseconds a reading: equal plans everywhere",
       one_of({"real", "virtual"})},
      excludes("--clock",
               standard("", {"--as", &o.as, "CORE", "Estimate the times of a phone's core from counted instructions",
                             one_of(phone_core_names())})),
      fills_partly({"--out", &o.out, "FOLDER", "Write reports, contact sheet, frames and film into this new folder"}),
      writes({"--record", &o.record, "FILE", "Write what every frame was given and did to this file"}),
      excludes("--record", {"--replay", &o.replay, "FILE", "Repeat the run of such a file, to the bit"}),
  };
}

Options budget_options(BudgetOptions& o) {
  return {
      required({"SCENE", &o.scene, "", k_scene_argument}),
      {"--mesh", &o.mesh, "FILE", k_body_mesh},
      standard(k_scene, {"--frames", &o.frames, "N", "Frames to run", whole_number(1, 100'000'000)}),
  };
}

Options light_options(LightOptions& o) {
  return {
      required({"IMAGES", &o.images, "", "PNG or JPEG files"}),
      fills(output(o.folder, "FOLDER", "Write a JSON file and a picture for each image into this new folder")),
      {"--fov", &o.fov_deg, "DEGREES", "Field of view across the diagonal, degrees", number(10, 170)},
      standard(k_shipped, {"--network", &o.network, "FILE", "The lighting network"}),
  };
}

Options inspect_options(InspectOptions& o) {
  return {
      required({"FILE", &o.file, "", "The file, or the name of a shipped scene"}),
      scale_option(o.as_mesh),
      up_option(o.as_mesh),
  };
}

#ifdef SANDGLASS_HAVE_BAKE
Options bake_options(BakeOptions& o) {
  BakeSettings& s = o.settings;
  s.threads = std::max(1u, std::thread::hardware_concurrency());
  return {
      required({"MESH", &o.mesh, "", "A mesh file, or the name of a generated mesh"}),
      scale_option(o.as_mesh),
      up_option(o.as_mesh),
      output_file(o.output, "Write the shadow to this file, and beside it FILE.png: truth, result and difference"),
      {"--size", &s.shape.width, "N", "Neurons in each layer of the network", whole_number(8, 256)},
      {"--angle", &s.angular_diameter, "DEGREES", "Angular diameter of the light, degrees", number(1, 60)},
      {"--max-polar", &s.polar_max, "DEGREES", "Largest angle of the light from the zenith, degrees", number(1, 84)},
      seed_option(s.seed, "Equal seeds give equal files on CPUs of one instruction set"),
      standard("all of this machine", threads_option(s.threads)),
      {"--quick", &o.quick, "", "A rough shadow in seconds, to see whether mesh and light are what was meant"},
      json_option(o.json),
      {"--keep-float", &s.keep_float, "", "Keep the float network in the file, for `bench shadow`"},
  };
}
#endif

Options sample_options(SampleOptions& o) {
  return {
      required({"MESH", &o.mesh, "", "A mesh file, or " + list_of(mesh_names(), "or")}),
      required(
          {"WHERE", &o.where, "",
           "Poisson disk samples on its surface, or in its volume, or a lattice in its volume: the densest packing",
           one_of({"surface", "volume", "lattice"})}),
      required(standard(
          "", {"--distance", &o.distance, "METRES", "Least distance between two points, metres", number(1e-9, 1e9)})),
      scale_option(o.as_mesh),
      up_option(o.as_mesh),
      seed_option(o.seed, "Equal seeds give equal points"),
      writes({"--picture", &o.picture, "FILE", "Also draw the points, .png"}),
      output_file(o.output, "Write the points to this file, .ply"),
  };
}

Options room_options(RoomOptions& o) {
  return {
      seed_option(o.seed, "Equal seeds give equal rooms"),
      output_file(o.output, "Write the panorama to this file, .hdr, with its depth beside it; or .jpg, to ship"),
      writes({"--picture", &o.picture, "FILE", "Also write a tone-mapped picture, .png"}),
      {"--width", &o.width, "N", "Width in pixels, even; the height is half of it", whole_number(16, 8192)},
      {"--samples", &o.samples, "N", "Paths a pixel", whole_number(1, 65536)},
      {"--lamps-off", &o.lamps_off, "", "By daylight alone, as the camera sees it that was exposed with lamps on"},
      threads_option(o.threads),
  };
}

Options dataset_options(DatasetOptions& o) {
  return {
      required({"PANORAMAS", &o.panoramas, "", k_panoramas}),
      fills(output(o.folder, "FOLDER", "Write images and manifest.csv into this new folder")),
      {"--manifest", &o.manifest, "FILE",
       "CSV with the columns file, group and fold: which panoramas show the same place"},
      seed_option(o.seed, "Equal seeds give equal views"),
      threads_option(o.threads),
  };
}

Options light_features_options(LightFeaturesOptions& o) {
  return {
      required({"NETWORK", &o.network, "", "File of the lighting network"}),
      required({"DATASET", &o.folder, "", "Folder that `sandglass dataset` made"}),
      output_file(o.output, "Write one row an image to this file, .npy"),
      {"--mirror", &o.mirror, "", "Add the rows of the mirrored images behind them"},
  };
}

Command bake() {
  const char *name = "bake", *help = "Train the soft shadow of a mesh";
#ifdef SANDGLASS_HAVE_BAKE
  return command<BakeOptions>(name, help, bake_options, bake_command);
#else
  return {name, help, {}, {}, {}, k_no_ray_tracer};
#endif
}

std::vector<CommandGroup> commands() {
  return {
      {"Run and look",
       {command<RunOptions>("run", "Run a scene under its budget, report on it and draw it", run_options, run_command),
        command<BudgetOptions>("budget", "Estimate the budget that a scene needs on a phone, at each quality level",
                               budget_options, budget_command),
        command<LightOptions>("light", "Estimate the light of photographs", light_options, light_command),
        command<InspectOptions>(
            "inspect", "Say what a file is: a recording, a shadow, a lighting network, a scene, a picture or a mesh",
            inspect_options, inspect_command)}},
      {"Make what an app loads",
       {bake(), command<SampleOptions>("sample", "Fill or cover a mesh with points", sample_options, sample_command)}},
      {"Train the lighting network",
       {command<RoomOptions>("room", "Make up an indoor room and trace its HDR panorama", room_options, room_command),
        command<DatasetOptions>("dataset", "Cut camera images and light labels out of HDR panoramas", dataset_options,
                                dataset_command),
        command<LightFeaturesOptions>("light-features", "Write what the lighting network's heads see",
                                      light_features_options, light_features_command)}}};
}

}  // namespace

}  // namespace sandglass::host

int main(int argc, char** argv) {
  using namespace sandglass::host;
  return run_program({"sandglass", "Sandglass: sand, light and shadow inside a fixed slice of every frame",
                      "run demo --out out", commands()},
                     argc, argv);
}
