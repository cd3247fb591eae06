// `sandglass sample MESH surface|volume|lattice --distance L -o FILE.ply`: points on a mesh's surface or in its
// volume, as a PLY file and a picture.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <functional>

#include "models/drawing/render.h"
#include "models/files/failure.h"
#include "models/mesh/generated.h"
#include "models/mesh/ply.h"
#include "models/program/commands.h"
#include "models/work/progress.h"
#include "sandglass/sandglass.hpp"

namespace sandglass::host {
namespace {

struct SampleOptions {
  std::string mesh;     // a file, or the name of a generated mesh
  std::string where;    // "surface", "volume" or "lattice"
  double distance = 0;  // metres
  uint64_t seed = 1;
  std::string picture, output;
  MeshOptions as_mesh;
};

Options options_of(SampleOptions& o) {
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

constexpr double k_poisson_per_cube = 0.6;  // expected points per distance^3 in a volume, to estimate the time left

using Points = std::vector<float>;

void expect(const cpp::Status& status, const SampleOptions& options) {
  if (!status) throw cannot("sample", options.mesh, status.reason);
}

// The volume about the first corner: 0 for any flat sheet, closed or not, wherever it lies.
bool has_volume(const Mesh& mesh) {
  constexpr double k_none = 1e-9;  // of the cube that the mesh fits into
  Mesh moved = mesh;
  for (size_t i = 0; i < moved.vertices.size(); ++i) moved.vertices[i] -= mesh.vertices[i % 3];
  const double longest = box_of(mesh).longest_side();
  return std::fabs(signed_volume(moved)) > k_none * longest * longest * longest;
}

sandglass_sample_desc how_to_sample(const SampleOptions& options, Progress* progress) {
  sandglass_sample_desc how = sandglass::sample_desc();
  how.seed = options.seed;
  how.progress = [](void* user, uint64_t done, uint64_t total) {
    auto* shown = static_cast<Progress*>(user);
    if (total > 0) shown->total(total);
    shown->done(done);
  };
  how.progress_user = progress;
  return how;
}

Points sample_surface(const Mesh& mesh, const SampleOptions& options) {
  Progress progress("sampling the surface", 1);
  Points points;
  expect(cpp::sample_surface(mesh.view(), static_cast<float>(options.distance), &points,
                             how_to_sample(options, &progress)),
         options);
  return points;
}

Points sample_inside(const Mesh& mesh, const MeshReport& report, const SampleOptions& options) {
  const sandglass_mesh surface = mesh.view();
  const float distance = static_cast<float>(options.distance);
  const sandglass_inside_rule rule = inside_rule(report);
  cpp::Box box;
  expect(cpp::call(sandglass_mesh_bounds, &surface, box.min, box.max), options);
  if (!has_volume(mesh))
    throw cannot("sample", options.mesh, "it encloses no volume", "Take \"surface\", or a mesh that is a solid");
  if (!report.watertight())
    std::fprintf(stderr, "sandglass: note: \"%s\" is not watertight (%s): the winding number decides what is inside\n",
                 options.mesh.c_str(), describe_faults(report).c_str());
  cpp::MeshInside inside;
  expect(inside.create(surface, rule), options);
  Points points;
  if (options.where == "lattice") {
    expect(cpp::sample_lattice(box, distance, std::ref(inside), &points), options);
    return points;
  }
  const double volume = std::fabs(signed_volume(mesh)), cube = options.distance * options.distance * options.distance;
  const double expected = k_poisson_per_cube * volume / cube + 1;
  Progress progress("sampling the volume", static_cast<uint64_t>(std::min(expected, 1e18)));
  expect(cpp::sample_volume(box, distance, std::ref(inside), &points, how_to_sample(options, &progress)), options);
  return points;
}

// Draws the points as balls. Those of a volume touch; those of a surface have a little room.
void write_picture(const SampleOptions& options, const Points& points) {
  RenderOptions drawing;
  drawing.width = drawing.height = 960;
  SceneView view;
  view.spheres = points;
  view.radius = static_cast<float>(options.distance) * (options.where == "surface" ? 0.45f : 0.5f);
  for (size_t i = 0; i < points.size(); i += 3) view.bounds.add(from_floats(&points[i]));
  view.camera = automatic_camera({&view.bounds, 1}, 1.0);
  write_png(options.picture, render(view, drawing));
}

}  // namespace

static int run(const SampleOptions& options) {
  try {
    const MeshResult loaded = named_mesh({options.mesh, options.as_mesh.units()});
    const Points points = options.where == "surface" ? sample_surface(loaded.mesh, options)
                                                     : sample_inside(loaded.mesh, loaded.report, options);
    if (points.empty())
      throw cannot("sample", options.mesh, "no point lies in it", "Make --distance smaller, or close the mesh");
    write_points_ply(options.output, points);
    if (!options.picture.empty()) write_picture(options, points);
    const char* where = options.where == "surface"  ? "on the surface of"
                        : options.where == "volume" ? "in the volume of"
                                                    : "of a lattice in the volume of";
    std::printf("%zu points %s %s, distance %g m, written to %s\n", points.size() / 3, where, options.mesh.c_str(),
                options.distance, options.output.c_str());
  } catch (const std::bad_alloc&) {
    throw cannot("sample", options.mesh, "this machine has too little memory for so many points", "Enlarge --distance");
  }
  return k_exit_done;
}

Command sample_command() {
  return command<SampleOptions>("sample", "Fill or cover a mesh with points", options_of, run);
}

}  // namespace sandglass::host
