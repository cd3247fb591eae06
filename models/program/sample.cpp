// `sandglass sample MESH --surface|--volume|--lattice --distance L -o FILE.ply`, or --disk|--sphere|--ring N without a
// mesh: points on a mesh's surface, in its volume, or of a disk, sphere or ring. It writes a PLY file, a picture and a
// spectrum.
#include <cmath>
#include <cstdio>
#include <functional>
#include <optional>

#include "models/drawing/plot.h"
#include "models/drawing/render.h"
#include "models/files/failure.h"
#include "models/mesh/generated.h"
#include "models/mesh/ply.h"
#include "models/program/commands.h"
#include "models/program/nearest_name.h"
#include "models/work/progress.h"
#include "sandglass/sandglass.hpp"

namespace sandglass::host {
namespace {

constexpr double k_poisson_per_cube = 0.6;  // expected points per distance^3 in a volume, to estimate the time left

using Points = std::vector<float>;

bool of_a_mesh(const SampleOptions& o) { return o.surface || o.volume || o.lattice; }

// What is sampled, as messages call it.
std::string subject(const SampleOptions& o) {
  return of_a_mesh(o) ? o.mesh : o.disk > 0 ? "disk" : o.sphere > 0 ? "sphere" : "ring";
}

void expect(const cpp::Status& status, const SampleOptions& options) {
  if (!status) throw cannot("sample", subject(options), status.reason);
}

struct ProgressRelay {
  std::string what;
  uint64_t expected;  // used where the library does not know the total
  std::optional<Progress> progress = {};

  static void report(void* user, uint64_t done, uint64_t total) {
    auto* relay = static_cast<ProgressRelay*>(user);
    if (!relay->progress) relay->progress.emplace(relay->what, total > 0 ? total : relay->expected);
    relay->progress->done(done);
  }
};

sandglass_mesh view(const Mesh& mesh) {
  return {mesh.vertices.data(), mesh.vertex_count(), mesh.indices.data(), mesh.triangle_count()};
}

sandglass_sample_options how_to_sample(const SampleOptions& options, ProgressRelay* relay) {
  sandglass_sample_options how;
  sandglass_sample_options_default(&how);
  how.seed = options.seed;
  how.metric = options.geodesic ? SANDGLASS_METRIC_GEODESIC : SANDGLASS_METRIC_EUCLIDEAN;
  how.progress = ProgressRelay::report, how.user = relay;
  return how;
}

Points sample_surface(const Mesh& mesh, const SampleOptions& options) {
  ProgressRelay relay = {"sampling the surface", 0};
  const sandglass_sample_options how = how_to_sample(options, &relay);
  Points points;
  expect(cpp::sample_surface(view(mesh), static_cast<float>(options.distance), &points, &how), options);
  return points;
}

Points sample_inside(const Mesh& mesh, const MeshReport& report, const SampleOptions& options) {
  const sandglass_mesh surface = view(mesh);
  const float distance = static_cast<float>(options.distance);
  const sandglass_inside_rule rule = report.watertight() ? SANDGLASS_INSIDE_PARITY : SANDGLASS_INSIDE_WINDING;
  if (!report.watertight())
    std::fprintf(stderr, "sandglass: note: \"%s\" is not watertight (%s): the winding number decides what is inside\n",
                 options.mesh.c_str(), describe_faults(report).c_str());
  cpp::Box box;
  cpp::Status bounded;
  bounded.code = sandglass_mesh_bounds(&surface, box.min, box.max, &bounded.reason);
  expect(bounded, options);
  cpp::MeshInside inside;
  expect(inside.create(surface, rule), options);
  Points points;
  if (options.lattice) {
    expect(cpp::sample_lattice(box, distance, std::ref(inside), &points), options);
    return points;
  }
  const double volume = std::fabs(signed_volume(mesh)), cube = options.distance * options.distance * options.distance;
  const double expected = k_poisson_per_cube * volume / cube + 1;
  ProgressRelay relay = {"sampling the volume", static_cast<uint64_t>(expected < 1e18 ? expected : 1e18)};
  const sandglass_sample_options how = how_to_sample(options, &relay);
  expect(cpp::sample_volume(box, distance, std::ref(inside), &points, &how), options);
  return points;
}

// Points of the disk, sphere or ring of radius 1. Sets the distance to their mean spacing.
Points sample_shape(SampleOptions* options) {
  constexpr double k_radians = M_PI / 180.0;
  const uint32_t count = options->disk + options->sphere + options->ring;  // one of them is above 0
  Points points(3ull * count);
  cpp::Status status;
  double area = 4.0 * M_PI;
  if (options->disk > 0) {
    status.code = sandglass_sample_disk(1.0f, count, points.data(), &status.reason);
    area = M_PI;
  } else if (options->sphere > 0) {
    status.code = sandglass_sample_sphere(1.0f, count, points.data(), &status.reason);
  } else {
    const double a = options->polar_deg[0] * k_radians, b = options->polar_deg[1] * k_radians;
    status.code =
        sandglass_sample_ring(1.0f, static_cast<float>(a), static_cast<float>(b), count, points.data(), &status.reason);
    area = 2.0 * M_PI * (std::cos(a) - std::cos(b));
  }
  expect(status, *options);
  options->distance = std::sqrt(area / count);
  return points;
}

// Plots the radial mean of the power spectrum beside 1, the level of independent random points.
void write_spectrum(const SampleOptions& options, const Points& points) {
  constexpr uint32_t k_bins = 96, k_directions = 64;
  constexpr double k_highest = 3.0, k_frequencies = 3.0;  // the ends of the axes
  const char* reason = nullptr;
  std::vector<double> power(k_bins);
  if (sandglass_sample_spectrum(points.data(), static_cast<uint32_t>(points.size() / 3),
                                static_cast<float>(k_frequencies / options.distance), k_bins, k_directions,
                                options.disk > 0 ? 1 : 0, power.data(), &reason) != SANDGLASS_OK)
    throw cannot("measure the spectrum for", options.spectrum, reason);
  Plot plot;
  plot.title = "Spectrum of the points";
  plot.x = {"frequency, 1/distance", 0.0, k_frequencies, false}, plot.y = {"power", 0.0, k_highest, false};
  PlotSeries measured = {"measured", {}, power, {194, 146, 82}, PlotSeries::Mark::none, true, false};
  for (uint32_t bin = 0; bin < k_bins; ++bin) measured.x.push_back((bin + 0.5) * k_frequencies / k_bins);
  plot.series = {measured,
                 {"random points", {0.0, k_frequencies}, {1.0, 1.0}, {40, 40, 40}, PlotSeries::Mark::none, true, true}};
  write_png(options.spectrum, draw_plot(plot));
}

// Draws the points as balls. Those of a volume touch; those of a surface have a little room.
void write_picture(const SampleOptions& options, const Points& points) {
  if (points.empty()) throw cannot("draw", options.picture, "there are no points", "Sample at a smaller distance");
  RenderOptions drawing;
  drawing.width = drawing.height = 960, drawing.scale = false;
  SceneView view;
  view.spheres = points;
  view.radius = static_cast<float>(options.distance) * (options.volume || options.lattice ? 0.5f : 0.45f);
  for (size_t i = 0; i < points.size(); i += 3) view.bounds.add(from_floats(&points[i]));
  view.camera = automatic_camera({&view.bounds, 1}, 1.0);
  write_png(options.picture, render(view, drawing));
}

void check(const SampleOptions& options) {
  const int kinds = options.surface + options.volume + options.lattice + (options.disk > 0) + (options.sphere > 0) +
                    (options.ring > 0);
  const bool mesh = of_a_mesh(options);
  if (kinds != 1)
    throw Failure("\"sample\" needs one of --surface, --volume, --lattice, --disk, --sphere and --ring, and " +
                  std::to_string(kinds) + " are given. See: sandglass sample --help.");
  if (mesh && options.mesh.empty())
    throw Failure("\"sample\" needs MESH: a mesh file, or " + list_of(mesh_names(), "or") +
                  ". See: sandglass sample --help.");
  if (mesh && options.distance <= 0)
    throw Failure(
        "\"sample\" needs \"--distance METRES\": the least distance between two points of a mesh. "
        "See: sandglass sample --help.");
  if (!mesh && !options.mesh.empty())
    throw cannot("sample", options.mesh, "a disk, a sphere and a ring have radius 1 and no mesh", "Leave MESH out");
  if (options.ring > 0 && options.polar_deg[0] >= options.polar_deg[1])
    throw Failure("cannot use \"--polar\" of \"sample\": the first angle is not below the second. Swap them.");
  if (options.geodesic && !options.surface)
    throw Failure(
        "cannot use \"--geodesic\" of \"sample\" without \"--surface\": it measures along a surface. Add it.");
}

}  // namespace

int sample_command(const SampleOptions& given) {
  SampleOptions options = given;
  check(options);
  try {
    Points points;
    if (of_a_mesh(options)) {
      const MeshResult loaded = named_mesh(options.mesh);
      points =
          options.surface ? sample_surface(loaded.mesh, options) : sample_inside(loaded.mesh, loaded.report, options);
    } else {
      points = sample_shape(&options);
    }
    if (const std::string error = write_points_ply(options.output, points); !error.empty()) throw Failure(error);
    if (!options.picture.empty()) write_picture(options, points);
    if (!options.spectrum.empty()) write_spectrum(options, points);
    const char* where = options.surface   ? "on the surface of"
                        : options.volume  ? "in the volume of"
                        : options.lattice ? "of a lattice in the volume of"
                                          : "of a";
    std::printf("%zu points %s %s, distance %g m, written to %s\n", points.size() / 3, where, subject(options).c_str(),
                options.distance, options.output.c_str());
  } catch (const std::bad_alloc&) {
    throw cannot("sample", subject(options), "this machine has too little memory for so many points",
                 "Enlarge --distance");
  }
  return k_exit_done;
}

}  // namespace sandglass::host
