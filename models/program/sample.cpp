// `sandglass sample MESH --surface|--volume|--lattice --distance L -o FILE.ply`, or --disk|--sphere|--ring N without a
// mesh: points on a mesh's surface, in its volume, or of a disk, sphere or ring. It writes a PLY file, a picture and a
// spectrum. It allocates memory once, with the size that the library names, as an app would.
#include <chrono>
#include <cmath>
#include <cstdio>
#include <optional>

#include "models/drawing/point_picture.h"
#include "models/files/failure.h"
#include "models/files/image.h"
#include "models/mesh/generated.h"
#include "models/mesh/mesh.h"
#include "models/mesh/ply.h"
#include "models/program/commands.h"
#include "models/program/nearest_name.h"
#include "models/work/block.h"
#include "models/work/progress.h"
#include "sandglass/sandglass.h"

namespace sandglass::host {
namespace {

constexpr int k_picture_width = 960, k_picture_height = 960;
constexpr double k_poisson_per_cube = 0.6;  // expected points per distance^3 in a volume, to estimate the time left

using Points = std::vector<float>;

Block sampler_block(uint64_t bytes) { return new_block(bytes, "the sampler", "enlarge --distance"); }

// What is sampled, as messages call it.
std::string subject(const SampleOptions& options) {
  switch (options.what) {
    case SampleWhat::disk:
      return "disk";
    case SampleWhat::sphere:
      return "sphere";
    case SampleWhat::ring:
      return "ring";
    default:
      return options.mesh;
  }
}

// `reason` is a reference, because the call that gives the status also sets the reason.
void expect(sandglass_status status, const SampleOptions& options, const char* const& reason) {
  if (status != SANDGLASS_OK) throw cannot("sample", subject(options), reason);
}

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

Points sample_surface(const Mesh& mesh, const SampleOptions& options) {
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
  expect(sandglass_sample_surface_capacity(&surface, distance, &how, &capacity, &reason), options, reason);
  expect(sandglass_sample_surface_bytes(&surface, distance, &how, capacity, &bytes, &reason), options, reason);
  const Block scratch = sampler_block(bytes);
  Points points(3ull * capacity);
  expect(sandglass_sample_surface(&surface, distance, &how, scratch.get(), bytes, points.data(), capacity, &count,
                                  &reason),
         options, reason);
  points.resize(3ull * count);
  return points;
}

Points sample_inside(const Mesh& mesh, const MeshReport& report, const SampleOptions& options) {
  const sandglass_mesh surface = view(mesh);
  const float distance = static_cast<float>(options.distance);
  const char* reason = nullptr;
  const sandglass_inside_rule rule = report.watertight() ? SANDGLASS_INSIDE_PARITY : SANDGLASS_INSIDE_WINDING;
  if (!report.watertight())
    std::fprintf(stderr, "sandglass: note: \"%s\" is not watertight (%s): the winding number decides what is inside\n",
                 options.mesh.c_str(), describe_faults(report).c_str());
  float low[3], high[3];
  uint64_t inside_bytes = 0;
  expect(sandglass_mesh_bounds(&surface, low, high, &reason), options, reason);
  expect(sandglass_mesh_inside_bytes(&surface, rule, &inside_bytes, &reason), options, reason);
  const Block inside_block = sampler_block(inside_bytes);
  sandglass_mesh_inside* inside = nullptr;
  expect(sandglass_mesh_inside_create(&surface, rule, inside_block.get(), inside_bytes, &inside, &reason), options,
         reason);

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
  expect(sized, options, reason);
  const sandglass_status measured = lattice
                                        ? sandglass_sample_lattice_bytes(low, high, distance, &bytes, &reason)
                                        : sandglass_sample_volume_bytes(low, high, distance, capacity, &bytes, &reason);
  expect(measured, options, reason);
  const Block scratch = sampler_block(bytes);
  Points points(3ull * capacity);
  const auto sample = lattice ? sandglass_sample_lattice : sandglass_sample_volume;
  expect(sample(low, high, distance, sandglass_mesh_inside_test, inside, &how, scratch.get(), bytes, points.data(),
                capacity, &count, &reason),
         options, reason);
  points.resize(3ull * count);
  return points;
}

bool of_a_mesh(SampleWhat what) { return what <= SampleWhat::lattice; }

Points sample_shape(SampleOptions* options) {
  constexpr double k_radians = M_PI / 180.0;
  const char* reason = nullptr;
  Points points(3ull * options->count);
  sandglass_status status = SANDGLASS_OK;
  double area = 4.0 * M_PI;
  if (options->what == SampleWhat::disk) {
    status = sandglass_sample_disk(1.0f, options->count, points.data(), &reason);
    area = M_PI;
  } else if (options->what == SampleWhat::sphere) {
    status = sandglass_sample_sphere(1.0f, options->count, points.data(), &reason);
  } else {
    const double a = options->polar_deg[0] * k_radians, b = options->polar_deg[1] * k_radians;
    status = sandglass_sample_ring(1.0f, static_cast<float>(a), static_cast<float>(b), options->count, points.data(),
                                   &reason);
    area = 2.0 * M_PI * (std::cos(a) - std::cos(b));
  }
  expect(status, *options, reason);
  options->distance = std::sqrt(area / options->count);
  return points;
}

// Draws the radial mean of the power spectrum as bars. The white line is 1, the level of independent random points.
void write_spectrum(const std::string& path, const std::vector<float>& points, double distance, bool planar) {
  constexpr uint32_t k_bins = 96, k_directions = 64;
  constexpr int k_bar = 9, k_height = 480, k_margin = 40;
  constexpr double k_highest = 3.0, k_frequencies = 3.0;  // the ends of the axes: power, and frequency in 1/distance
  const char* reason = nullptr;
  std::vector<double> power(k_bins);
  if (sandglass_sample_spectrum(points.data(), static_cast<uint32_t>(points.size() / 3),
                                static_cast<float>(k_frequencies / distance), k_bins, k_directions, planar ? 1 : 0,
                                power.data(), &reason) != SANDGLASS_OK)
    throw cannot("measure the spectrum for", path, reason);
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
  write_png(path, picture);
}

const char* name_of(SampleWhat what) {
  constexpr const char* k_names[] = {
      "on the surface of", "in the volume of", "of a lattice in the volume of", "of a", "of a", "of a"};
  return k_names[static_cast<size_t>(what)];
}

void check(const SampleOptions& options) {
  if (options.kinds != 1)
    throw Failure("\"sample\" needs one of --surface, --volume, --lattice, --disk, --sphere and --ring, and " +
                  std::to_string(options.kinds) + " are given. See: sandglass sample --help.");
  const bool mesh = of_a_mesh(options.what);
  if (mesh && options.mesh.empty())
    throw Failure("\"sample\" needs MESH: a mesh file, or " + list_of(mesh_names(), "or") +
                  ". See: sandglass sample --help.");
  if (mesh && options.distance <= 0)
    throw Failure(
        "\"sample\" needs \"--distance METRES\": the least distance between two points of a mesh. "
        "See: sandglass sample --help.");
  if (!mesh && !options.mesh.empty())
    throw cannot("sample", options.mesh, "a disk, a sphere and a ring have radius 1 and no mesh", "Leave MESH out");
  if (options.what == SampleWhat::ring && options.polar_deg[0] >= options.polar_deg[1])
    throw Failure("cannot use \"--polar\" of \"sample\": the first angle is not below the second. Swap them.");
  if (options.geodesic && options.what != SampleWhat::surface)
    throw Failure(
        "cannot use \"--geodesic\" of \"sample\" without \"--surface\": it measures along a surface. Add it.");
}

void write_points(const SampleOptions& options, const Points& points) {
  const auto written = [](const std::string& error) {
    if (!error.empty()) throw Failure(error);
  };
  const bool solid = options.what == SampleWhat::volume || options.what == SampleWhat::lattice;
  written(write_points_ply(options.output, points));
  if (!options.picture.empty()) {
    const float radius = static_cast<float>(options.distance) * (solid ? 0.5f : 0.45f);
    written(write_point_picture(options.picture, points, radius, k_picture_width, k_picture_height));
  }
  if (!options.spectrum.empty())
    write_spectrum(options.spectrum, points, options.distance, options.what == SampleWhat::disk);
}

}  // namespace

int sample_command(const SampleOptions& given) {
  SampleOptions options = given;
  check(options);
  try {
    Points points;
    if (of_a_mesh(options.what)) {
      const MeshResult loaded = named_mesh(options.mesh);
      points = options.what == SampleWhat::surface ? sample_surface(loaded.mesh, options)
                                                   : sample_inside(loaded.mesh, loaded.report, options);
    } else {
      points = sample_shape(&options);
    }
    write_points(options, points);
    std::printf("%zu points %s %s, distance %g m, written to %s\n", points.size() / 3, name_of(options.what),
                subject(options).c_str(), options.distance, options.output.c_str());
  } catch (const std::bad_alloc&) {
    throw cannot("sample", subject(options), "this machine has too little memory for so many points",
                 "Enlarge --distance");
  }
  return k_exit_done;
}

}  // namespace sandglass::host
