// `sandglass sample MESH --surface|--volume|--lattice --distance L -o FILE.ply`, or without a mesh
// --disk|--sphere|--ring N: the samplers of the runtime at work. Memory is asked for once, with the size that the
// library names, as an app would.
#include "models/cli/sample.h"

#include <chrono>
#include <cmath>
#include <cstdio>
#include <optional>

#include "models/cli/options.h"
#include "models/host/block.h"
#include "models/host/image.h"
#include "models/host/mesh/generated.h"
#include "models/host/mesh/mesh.h"
#include "models/host/mesh/ply.h"
#include "models/host/mesh/point_picture.h"
#include "models/host/progress.h"
#include "sandglass/sandglass.h"

namespace sandglass::host {
namespace {

constexpr int k_exit_bad_input = 2;
constexpr int k_picture_width = 960, k_picture_height = 960;
constexpr double k_poisson_per_cube = 0.6;  // points per distance^3 in a volume, for the time left

struct Sampling {
  std::vector<float> points;
  std::string error;
};

Block sampler_block(uint64_t bytes) { return new_block(bytes, "the sampler", "enlarge --distance"); }

struct ProgressRelay {
  std::string what;
  uint64_t expected;  // used where the library does not know the total
  std::optional<Progress> progress;

  static void report(void* user, uint64_t done, uint64_t total) {
    auto* relay = static_cast<ProgressRelay*>(user);
    if (!relay->progress) relay->progress.emplace(relay->what, total > 0 ? total : relay->expected);
    relay->progress->done(done);
  }
};

sandglass_mesh view(const Mesh& mesh) {
  return {mesh.vertices.data(), mesh.vertex_count(), mesh.indices.data(), mesh.triangle_count()};
}

Sampling failed(const char* reason) { return {{}, reason}; }

Sampling sample_surface(const Mesh& mesh, const SampleOptions& options) {
  const sandglass_mesh surface = view(mesh);
  const float distance = static_cast<float>(options.distance);
  const char* reason = nullptr;
  ProgressRelay relay = {"sampling the surface", 0, {}};
  sandglass_sample_options how;
  sandglass_sample_options_default(&how);
  how.seed = options.seed;
  how.metric = options.geodesic ? SANDGLASS_METRIC_GEODESIC : SANDGLASS_METRIC_EUCLIDEAN;
  how.progress = ProgressRelay::report;
  how.user = &relay;
  uint32_t capacity = 0, count = 0;
  uint64_t bytes = 0;
  if (sandglass_sample_surface_capacity(&surface, distance, &how, &capacity, &reason) != SANDGLASS_OK)
    return failed(reason);
  if (sandglass_sample_surface_bytes(&surface, distance, &how, capacity, &bytes, &reason) != SANDGLASS_OK)
    return failed(reason);
  const Block scratch = sampler_block(bytes);
  Sampling result = {std::vector<float>(3ull * capacity), ""};
  if (sandglass_sample_surface(&surface, distance, &how, scratch.get(), bytes, result.points.data(), capacity, &count,
                               &reason) != SANDGLASS_OK)
    return failed(reason);
  result.points.resize(3ull * count);
  return result;
}

Sampling sample_inside(const Mesh& mesh, const MeshReport& report, const SampleOptions& options) {
  const sandglass_mesh surface = view(mesh);
  const float distance = static_cast<float>(options.distance);
  const char* reason = nullptr;
  const sandglass_inside_rule rule = report.watertight() ? SANDGLASS_INSIDE_PARITY : SANDGLASS_INSIDE_WINDING;
  if (!report.watertight())
    std::fprintf(stderr, "sandglass: mesh '%s' is not watertight (%s): inside is decided by the winding number\n",
                 options.mesh.c_str(), describe_faults(report).c_str());
  float low[3], high[3];
  uint64_t inside_bytes = 0;
  if (sandglass_mesh_bounds(&surface, low, high, &reason) != SANDGLASS_OK) return failed(reason);
  if (sandglass_mesh_inside_bytes(&surface, rule, &inside_bytes, &reason) != SANDGLASS_OK) return failed(reason);
  const Block inside_block = sampler_block(inside_bytes);
  sandglass_mesh_inside* inside = nullptr;
  if (sandglass_mesh_inside_create(&surface, rule, inside_block.get(), inside_bytes, &inside, &reason) != SANDGLASS_OK)
    return failed(reason);

  const double volume = std::fabs(signed_volume(mesh)), cube = options.distance * options.distance * options.distance;
  const double expected = k_poisson_per_cube * volume / cube + 1;
  ProgressRelay relay = {"sampling the volume", static_cast<uint64_t>(expected < 1e18 ? expected : 1e18), {}};
  sandglass_sample_options how;
  sandglass_sample_options_default(&how);
  how.seed = options.seed;
  how.progress = ProgressRelay::report;
  how.user = &relay;

  const bool lattice = options.what == SampleWhat::lattice;
  uint32_t capacity = 0, count = 0;
  uint64_t bytes = 0;
  const sandglass_status sized = lattice ? sandglass_sample_lattice_capacity(low, high, distance, &capacity, &reason)
                                         : sandglass_sample_volume_capacity(low, high, distance, &capacity, &reason);
  if (sized != SANDGLASS_OK) return failed(reason);
  const sandglass_status measured = lattice
                                        ? sandglass_sample_lattice_bytes(low, high, distance, &bytes, &reason)
                                        : sandglass_sample_volume_bytes(low, high, distance, capacity, &bytes, &reason);
  if (measured != SANDGLASS_OK) return failed(reason);
  const Block scratch = sampler_block(bytes);
  Sampling result = {std::vector<float>(3ull * capacity), ""};
  const auto sample = lattice ? sandglass_sample_lattice : sandglass_sample_volume;
  if (sample(low, high, distance, sandglass_mesh_inside_test, inside, &how, scratch.get(), bytes, result.points.data(),
             capacity, &count, &reason) != SANDGLASS_OK)
    return failed(reason);
  result.points.resize(3ull * count);
  return result;
}

bool of_a_mesh(SampleWhat what) { return what <= SampleWhat::lattice; }

Sampling sample_shape(SampleOptions* options) {
  constexpr double k_radians = M_PI / 180.0;
  const char* reason = nullptr;
  Sampling result = {std::vector<float>(3ull * options->count), ""};
  float* points = result.points.data();
  sandglass_status status = SANDGLASS_OK;
  double area = 4.0 * M_PI;
  if (options->what == SampleWhat::disk) {
    status = sandglass_sample_disk(1.0f, options->count, points, &reason);
    area = M_PI;
  } else if (options->what == SampleWhat::sphere) {
    status = sandglass_sample_sphere(1.0f, options->count, points, &reason);
  } else {
    const double a = options->polar_deg[0] * k_radians, b = options->polar_deg[1] * k_radians;
    status = sandglass_sample_ring(1.0f, static_cast<float>(a), static_cast<float>(b), options->count, points, &reason);
    area = 2.0 * M_PI * (std::cos(a) - std::cos(b));
  }
  if (status != SANDGLASS_OK) return failed(reason);
  options->distance = std::sqrt(area / options->count);
  return result;
}

// Radial mean of the power spectrum as bars; the white line is 1, the level of points that know nothing of each other.
std::string write_spectrum(const std::string& path, const std::vector<float>& points, double distance, bool planar) {
  constexpr uint32_t k_bins = 96, k_directions = 64;
  constexpr int k_bar = 9, k_height = 480, k_margin = 40;
  constexpr double k_highest = 3.0, k_frequencies = 3.0;  // of the axes: power, and frequency in 1/distance
  const char* reason = nullptr;
  std::vector<double> power(k_bins);
  if (sandglass_sample_spectrum(points.data(), static_cast<uint32_t>(points.size() / 3),
                                static_cast<float>(k_frequencies / distance), k_bins, k_directions, planar ? 1 : 0,
                                power.data(), &reason) != SANDGLASS_OK)
    return reason;
  const Colour ink = {40, 40, 40}, bar = {194, 146, 82};
  Picture picture(2 * k_margin + static_cast<int>(k_bins) * k_bar, 2 * k_margin + k_height, {236, 240, 243});
  const auto height = [](double p) { return static_cast<int>(std::fmin(p, k_highest) / k_highest * k_height); };
  for (uint32_t b = 0; b < k_bins; ++b) {
    const int h = height(power[b]);
    fill_rectangle(&picture, k_margin + static_cast<int>(b) * k_bar, k_margin + k_height - h, k_bar - 1, h, bar);
  }
  fill_rectangle(&picture, k_margin, k_margin + k_height - height(1.0), static_cast<int>(k_bins) * k_bar, 2,
                 {255, 255, 255});
  for (int f = 0; f <= static_cast<int>(k_frequencies); ++f) {
    const int x = k_margin + static_cast<int>(f / k_frequencies * k_bins) * k_bar;
    fill_rectangle(&picture, x, k_margin + k_height, 1, 8, ink);
    draw_text(&picture, x - 4, k_margin + k_height + 14, 2, std::to_string(f), ink);
  }
  draw_text(&picture, k_margin, 10, 2, "POWER (WHITE LINE: 1) AGAINST FREQUENCY IN 1/DISTANCE", ink);
  try {
    write_png(path, picture);
  } catch (const std::exception& error) {
    return error.what();
  }
  return "";
}

int complain(const std::string& sentence) {
  std::fprintf(stderr, "sandglass: %s\n", sentence.c_str());
  return k_exit_bad_input;
}

const char* name_of(SampleWhat what) {
  constexpr const char* k_names[] = {
      "on the surface of", "in the volume of", "of a lattice in the volume of", "of a", "of a", "of a"};
  return k_names[static_cast<size_t>(what)];
}

}  // namespace

int sample_command(const SampleOptions& asked) {
  SampleOptions options = asked;
  const bool mesh = of_a_mesh(options.what);
  if (mesh && (!(options.distance > 0) || !std::isfinite(options.distance)))
    return complain("the distance is not a number above 0: give it in metres with --distance");
  if (mesh == options.mesh.empty())
    return complain(mesh ? "no mesh is named: give a file, or trefoil, torus, box, sphere, hourglass, bucket, silo"
                         : "a disk, sphere or ring has radius 1 and needs no mesh: leave it out");
  if (options.geodesic && options.what != SampleWhat::surface)
    return complain("--geodesic measures along a surface: use it with --surface");
  const std::string of = mesh                                 ? "'" + options.mesh + "'"
                         : options.what == SampleWhat::disk   ? "disk"
                         : options.what == SampleWhat::sphere ? "sphere"
                                                              : "ring";
  try {
    Sampling sampling;
    if (!mesh) {
      sampling = sample_shape(&options);
    } else {
      MeshResult loaded = make_named(options.mesh);
      if (!loaded) loaded = load_mesh(options.mesh);
      if (!loaded) return complain(loaded.error);
      sampling = options.what == SampleWhat::surface ? sample_surface(loaded.mesh, options)
                                                     : sample_inside(loaded.mesh, loaded.report, options);
    }
    if (!sampling.error.empty()) return complain((mesh ? "mesh " : "") + of + ": " + sampling.error);
    if (const std::string error = write_points_ply(options.output, sampling.points); !error.empty())
      return complain(error);
    const bool solid = options.what == SampleWhat::volume || options.what == SampleWhat::lattice;
    if (!options.picture.empty()) {
      const float radius = static_cast<float>(options.distance) * (solid ? 0.5f : 0.45f);
      const std::string error =
          write_point_picture(options.picture, sampling.points, radius, k_picture_width, k_picture_height);
      if (!error.empty()) return complain(error);
    }
    if (!options.spectrum.empty()) {
      const std::string error =
          write_spectrum(options.spectrum, sampling.points, options.distance, options.what == SampleWhat::disk);
      if (!error.empty()) return complain(error);
    }
    std::printf("%zu points %s %s, distance %g m, written to %s\n", sampling.points.size() / 3, name_of(options.what),
                of.c_str(), options.distance, options.output.c_str());
  } catch (const std::bad_alloc&) {
    return complain("this machine has too little memory for that many points: enlarge --distance");
  }
  return 0;
}

void add_sample_command(Command& program, int* exit_code) {
  Command command =
      program.add_subcommand("sample", "Sample a mesh's surface or volume, a disk, a sphere or a ring with points");
  const auto options = std::make_shared<SampleOptions>();
  command->add_option("mesh", options->mesh,
                      "A mesh file, or trefoil, torus, box, sphere, hourglass, bucket, silo, chair");
  Command what = command->add_option_group("what");
  what->add_flag_callback(
      "--surface", [options] { options->what = SampleWhat::surface; }, "Poisson disk on the surface");
  what->add_flag_callback(
      "--volume", [options] { options->what = SampleWhat::volume; }, "Poisson disk in the volume");
  what->add_flag_callback(
      "--lattice", [options] { options->what = SampleWhat::lattice; }, "Hexagonal close packing in the volume");
  const auto shape = [&](const char* flag, SampleWhat which, const char* description) {
    what->add_option_function(
            flag, [options, which](uint32_t count) { options->what = which, options->count = count; }, description)
        ->check(range(1u, 1u << 26));
  };
  shape("--disk", SampleWhat::disk, "So many points of the unit disk");
  shape("--sphere", SampleWhat::sphere, "So many points of the unit sphere");
  shape("--ring", SampleWhat::ring, "So many points of a ring of the unit sphere");
  what->require_option(1);
  command->add_option("--polar", options->polar_deg, "Polar angles of the ring, degrees (0 45)")
      ->expected(2)
      ->check(range(0.0, 180.0));
  command->add_option("--distance", options->distance, "Least distance between two points on or in a mesh, metres");
  command->add_option("--seed", options->seed, "Equal seeds give equal points")->capture_default_str();
  command->add_flag("--geodesic", options->geodesic, "Measure the distance along the surface");
  command->add_option("--picture", options->picture, "Also draw the points, as a PNG");
  command->add_option("--spectrum", options->spectrum, "Also plot the power spectrum of the points, as a PNG");
  command->add_option("-o,--output", options->output, "PLY file to write")->required();
  command->callback([options, exit_code] { *exit_code = sample_command(*options); });
}

}  // namespace sandglass::host
