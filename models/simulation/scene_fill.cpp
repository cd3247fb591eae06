// Every body but a lattice block is sampled in its unit frame: height 1, base at y = 0, middle of the base at the
// origin. To get a wanted number of points, one search finds the distance in units of the height. Scale, rotation and
// position come last.
#include "models/simulation/scene_fill.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <string>

#include "models/files/failure.h"
#include "models/work/random.h"
#include "sandglass/sandglass.hpp"

namespace sandglass::host {

namespace {

constexpr int k_search_steps = 24;
constexpr double k_count_tolerance = 0.01;  // of the wanted number; a scene file is promised this
constexpr double k_search_enough = 0.002;   // the lattice search is cheap, so it goes on to this
constexpr double k_poisson_density = 0.7;   // points per distance^3, as the sampler's documentation says
constexpr double k_root2 = 1.4142135623730951, k_root3 = 1.7320508075688772, k_layer = 0.816496580927726;  // sqrt(2/3)

// Newton's iteration, because libm's cbrt differs between machines in the last bit.
double cube_root(double value) {
  double root = value > 1.0 ? value : 1.0;
  for (int i = 0; i < 200; ++i) {
    const double next = (2.0 * root + value / (root * root)) / 3.0;
    if (next >= root) break;
    root = next;
  }
  return root;
}

using Points = std::vector<float>;

struct UnitBody {
  cpp::Box box;
  std::function<bool(const float*)> inside;
  std::string label;            // "body 0 of x.json"
  Profile profile;              // of a revolved body, in the unit frame
  std::vector<float> vertices;  // of a mesh body
  cpp::MeshInside mesh;

  void require(const cpp::Status& status) const {
    if (!status) throw cannot("fill", label, status.reason != nullptr ? status.reason : status.name());
  }
};

void make_revolved_body(const Body& source, UnitBody* body) {
  const auto [reach, bottom, top] = extent_of(source.profile);
  const double scale = 1.0 / source.size.y;
  for (const auto& point : source.profile) body->profile.push_back({point[0] * scale, (point[1] - bottom) * scale});
  const float wide = static_cast<float>(reach * scale);
  body->box = {{-wide, 0.0f, -wide}, {wide, 1.0f, wide}};
  body->inside = [profile = body->profile](const float* p) { return revolved_distance(profile, from_floats(p)) < 0.0; };
}

cpp::Box bounds_of(const UnitBody& body, const sandglass_mesh& mesh) {
  cpp::Box box;
  body.require(cpp::call(sandglass_mesh_bounds, &mesh, box.min, box.max));
  return box;
}

void make_mesh_body(const BodyMesh& source, UnitBody* body) {
  const auto [low, high] = bounds_of(*body, source.mesh);
  const double height = static_cast<double>(high[1]) - low[1];
  if (!(height > 0.0)) throw cannot("fill", body->label, "its mesh has no height", "Turn it: y is up");
  const double middle[3] = {0.5 * (static_cast<double>(low[0]) + high[0]), low[1],
                            0.5 * (static_cast<double>(low[2]) + high[2])};
  body->vertices.resize(3 * static_cast<size_t>(source.mesh.vertex_count));
  for (size_t i = 0; i < body->vertices.size(); ++i)
    body->vertices[i] = static_cast<float>((source.mesh.vertices[i] - middle[i % 3]) / height);
  sandglass_mesh unit = source.mesh;
  unit.vertices = body->vertices.data();
  body->box = bounds_of(*body, unit);
  body->require(body->mesh.create(unit, source.rule));
  body->inside = [mesh = body->mesh.get()](const float* p) { return sandglass_mesh_inside_test(mesh, p) != 0; };
}

UnitBody make_unit_body(const Body& body, const BodyMeshes& meshes, const std::string& label) {
  UnitBody unit;
  unit.label = label;
  if (body.shape == BodyShape::trefoil || body.shape == BodyShape::mesh) {
    const std::optional<BodyMesh>& mesh = body.shape == BodyShape::mesh ? meshes.argument : meshes.trefoil;
    if (!mesh) throw cannot("fill", label, "it is a mesh without a file", "Name it with --mesh FILE");
    make_mesh_body(*mesh, &unit);
    return unit;
  }
  if (body.shape == BodyShape::revolved) {
    make_revolved_body(body, &unit);
    return unit;
  }
  const bool sized = body.shape == BodyShape::box && body.size.y > 0.0;
  const double wide = sized ? body.size.x / body.size.y : 1.0, deep = sized ? body.size.z / body.size.y : 1.0;
  to_floats({-0.5 * wide, 0.0, -0.5 * deep}, unit.box.min);
  to_floats({0.5 * wide, 1.0, 0.5 * deep}, unit.box.max);
  if (body.shape == BodyShape::box) unit.inside = [](const float*) { return true; };  // samplers stay within the bounds
  else
    unit.inside = [](const float* p) {
      const float x = p[0], y = p[1] - 0.5f, z = p[2];
      return x * x + y * y + z * z <= 0.25f;
    };
  return unit;
}

// Refuses what a size and a distance ask for, before it is computed. A hexagonal close packing is the densest.
void expect_possible(const UnitBody& body, double distance, uint32_t limit, const char* what) {
  double cells = k_root2;
  for (int axis = 0; axis < 3; ++axis)
    cells *= (static_cast<double>(body.box.max[axis]) - body.box.min[axis]) / distance + 1.0;
  if (!(cells <= 4.0 * limit))  // of the box; the body may fill a part of it
    throw cannot("fill", body.label, std::string("it asks for far more ") + what + " than " + std::to_string(limit),
                 "Make it smaller, or the distance larger");
}

Points lattice_points(const UnitBody& body, double distance) {
  expect_possible(body, distance, SANDGLASS_PARTICLE_LIMIT, "particles");
  Points points;
  body.require(cpp::sample_lattice(body.box, static_cast<float>(distance), std::ref(body.inside), &points));
  return points;
}

Points poisson_points(const UnitBody& body, double distance, uint64_t seed) {
  expect_possible(body, distance, SANDGLASS_GRAIN_LIMIT, "grains");
  Points points;
  sandglass_sample_desc desc = sample_desc();
  desc.seed = seed;
  body.require(cpp::sample_volume(body.box, static_cast<float>(distance), std::ref(body.inside), &points, desc));
  return points;
}

// One random point in each cubic cell of edge `distance`. Points outside the body are left out.
Points grid_points(const UnitBody& body, double distance, uint64_t seed) {
  expect_possible(body, distance, SANDGLASS_GRAIN_LIMIT, "grains");
  Random random = {seed};
  int64_t cells[3];
  for (int axis = 0; axis < 3; ++axis)
    cells[axis] = static_cast<int64_t>((static_cast<double>(body.box.max[axis]) - body.box.min[axis]) / distance) + 1;
  Points points;
  for (int64_t k = 0; k < cells[1]; ++k)
    for (int64_t j = 0; j < cells[2]; ++j)
      for (int64_t i = 0; i < cells[0]; ++i) {
        const int64_t at[3] = {i, k, j};
        float p[3];
        bool within = true;
        for (int axis = 0; axis < 3; ++axis) {
          p[axis] =
              static_cast<float>(body.box.min[axis] + (static_cast<double>(at[axis]) + random.uniform()) * distance);
          within = within && p[axis] <= body.box.max[axis];
        }
        if (within && body.inside(p)) points.insert(points.end(), p, p + 3);
      }
  return points;
}

// Searches for the distance at which `sample` gives the wanted number of points, within k_count_tolerance. Returns
// those points. The search ends early when the relative error is at most `enough`.
Points sample_wanted(const UnitBody& body, uint32_t wanted, double enough, double* distance, const char* what,
                     const std::function<Points(double)>& sample) {
  Points best;
  double best_error = 1e30, best_distance = *distance, tried = *distance;
  for (int step = 0; step < k_search_steps && best_error > enough; ++step) {
    Points points = sample(tried);
    const double count = static_cast<double>(points.size() / 3);
    const double error = std::fabs(count - wanted) / wanted;
    if (error < best_error) {
      best_error = error;
      best_distance = tried;
      best = std::move(points);
    }
    tried *= count == 0.0 ? 0.5 : cube_root(std::clamp(count / wanted, 0.05, 20.0));
  }
  if (best_error > k_count_tolerance)
    throw cannot("fill", body.label,
                 "it cannot hold " + std::to_string(wanted) + " " + what + " to 1 %; the nearest number is " +
                     std::to_string(best.size() / 3),
                 "Ask for that, or give its size instead");
  *distance = best_distance;
  return best;
}

double box_volume(const UnitBody& body) {
  double volume = 1.0;
  for (int axis = 0; axis < 3; ++axis) volume *= static_cast<double>(body.box.max[axis]) - body.box.min[axis];
  return volume;
}

Points unit_grains(const Body& body, const UnitBody& unit, double volume, double scale, uint64_t seed) {
  const auto sample = [&](double distance) {
    return body.grain_grid ? grid_points(unit, distance, seed) : poisson_points(unit, distance, seed);
  };
  if (body.grain_distance > 0.0) return sample(body.grain_distance / scale);
  if (body.grains == 0) return {};
  double distance = cube_root(volume * (body.grain_grid ? 1.0 : k_poisson_density) / body.grains);
  return sample_wanted(unit, body.grains, k_count_tolerance, &distance, "grains", sample);
}

// ------------------------------------------------------------------------------------------------ lattice blocks

// Hexagonal close packing, (3.33) of the dissertation: counts[1] layers of counts[0] x counts[2] sites. The middle of
// the lowest layer's box is at the origin. The lowest centres are at y = 0.
std::vector<Vec3> block_sites(const Body& body, double distance) {
  std::vector<Vec3> sites;
  const Vec3 middle = {0.5 * distance * (body.counts[0] - 0.5), 0.0,
                       0.25 * k_root3 * distance * (body.counts[2] - 2.0 / 3.0)};
  for (uint32_t k = 0; k < body.counts[1]; ++k)
    for (uint32_t j = 0; j < body.counts[2]; ++j)
      for (uint32_t i = 0; i < body.counts[0]; ++i)
        sites.push_back(Vec3{0.5 * distance * (2 * i + (j + k) % 2), k * k_layer * distance,
                             0.5 * k_root3 * distance * (j + (k % 2) / 3.0)} -
                        middle);
  return sites;
}

// Splits a box into nearly cubic cells. Their number is `wanted`, or slightly above when that does not split well. Sets
// the number of cells along each axis.
void split_box(uint32_t wanted, const double extent[3], uint64_t cells[3]) {
  constexpr double k_good_ratio = 1.5;  // longest to shortest edge of a cell
  double best_score = 1e30;
  const uint32_t slack = static_cast<uint32_t>(wanted * k_count_tolerance);
  for (uint32_t off = 0; off <= slack && best_score > k_good_ratio; ++off) {
    const uint64_t total = wanted + off;
    for (uint64_t a = 1; a <= total; ++a) {
      if (a > 100000) break;
      if (total % a != 0) continue;
      const uint64_t rest = total / a;
      for (uint64_t b = 1; b * b <= rest; ++b) {
        if (rest % b != 0) continue;
        for (const uint64_t second : {b, rest / b}) {
          const uint64_t split[3] = {a, second, rest / second};
          double shortest = 1e30, longest = 0.0;
          for (int axis = 0; axis < 3; ++axis) {
            const double edge = extent[axis] / static_cast<double>(split[axis]);
            shortest = std::min(shortest, edge);
            longest = std::max(longest, edge);
          }
          if (longest / shortest < best_score) {
            best_score = longest / shortest;
            std::copy_n(split, 3, cells);
          }
        }
      }
    }
  }
}

std::vector<Vec3> block_grains(const Body& body, const std::vector<Vec3>& sites, double distance, Random* random) {
  if (body.grains == 0) return {};
  Vec3 low = sites[0], high = sites[0];
  for (const Vec3& site : sites) {
    low = {std::min(low.x, site.x), std::min(low.y, site.y), std::min(low.z, site.z)};
    high = {std::max(high.x, site.x), std::max(high.y, site.y), std::max(high.z, site.z)};
  }
  const Vec3 half = {0.5 * distance, 0.5 * distance, 0.5 * distance};
  low = low - half;
  high = high + half;
  const double extent[3] = {high.x - low.x, high.y - low.y, high.z - low.z};
  uint64_t cells[3] = {1, 1, 1};
  split_box(body.grains, extent, cells);
  std::vector<Vec3> grains;
  for (uint64_t k = 0; k < cells[1]; ++k)
    for (uint64_t j = 0; j < cells[2]; ++j)
      for (uint64_t i = 0; i < cells[0]; ++i) {
        const double u = (static_cast<double>(i) + random->uniform()) / static_cast<double>(cells[0]);
        const double v = (static_cast<double>(k) + random->uniform()) / static_cast<double>(cells[1]);
        const double w = (static_cast<double>(j) + random->uniform()) / static_cast<double>(cells[2]);
        grains.push_back({low.x + u * extent[0], low.y + v * extent[1], low.z + w * extent[2]});
      }
  return grains;
}

// ------------------------------------------------------------------------------------------------ placing

std::vector<Vec3> scaled(const Points& unit, double scale) {
  std::vector<Vec3> points;
  points.reserve(unit.size() / 3);
  for (size_t i = 0; i < unit.size(); i += 3) points.push_back(Vec3{unit[i], unit[i + 1], unit[i + 2]} * scale);
  return points;
}

void append(const std::vector<Vec3>& points, Vec3 velocity, std::vector<float>* positions,
            std::vector<float>* velocities) {
  for (const Vec3& p : points) {
    for (const double value : {p.x, p.y, p.z}) positions->push_back(static_cast<float>(value));
    for (const double value : {velocity.x, velocity.y, velocity.z}) velocities->push_back(static_cast<float>(value));
  }
}

struct Filled {
  std::vector<Vec3> particles, grains;  // before rotation and position
  double lowest = 0.0;                  // of the rotated body; it moves to the height of the body's position
};

// The lowest point of the body after rotation. (A lattice block does not come here: it turns about the middle of its
// lowest layer, and this point goes to the body's position.)
double lowest_after(const Body& body, const UnitBody& unit, double scale) {
  double lowest = 1e30;
  const auto take = [&](Vec3 p) { lowest = std::min(lowest, rotate(body.rotation, p * scale).y); };
  for (size_t i = 0; i < unit.vertices.size(); i += 3)
    take({unit.vertices[i], unit.vertices[i + 1], unit.vertices[i + 2]});
  for (const auto& point : unit.profile)
    for (const Vec3 corner :
         {Vec3{point[0], point[1], 0}, {-point[0], point[1], 0}, {0, point[1], point[0]}, {0, point[1], -point[0]}})
      take(corner);
  if (body.shape == BodyShape::sphere) lowest = rotate(body.rotation, Vec3{0.0, 0.5 * scale, 0.0}).y - 0.5 * scale;
  if (body.shape == BodyShape::box)
    for (int corner = 0; corner < 8; ++corner)
      take({corner & 1 ? unit.box.max[0] : unit.box.min[0], corner & 2 ? unit.box.max[1] : unit.box.min[1],
            corner & 4 ? unit.box.max[2] : unit.box.min[2]});
  return lowest;
}

Filled fill_body(const Body& body, const UnitBody& unit, double* particle_radius, uint64_t seed) {
  Filled filled;
  double unit_distance = 0.0, scale = body.size.y;
  Points sites;
  if (body.particles > 0) {
    unit_distance = cube_root(k_root2 * 0.5 * box_volume(unit) / body.particles);
    sites = sample_wanted(unit, body.particles, k_search_enough, &unit_distance, "particles",
                          [&](double distance) { return lattice_points(unit, distance); });
    if (scale > 0.0) *particle_radius = unit_distance * scale / body.spacing;
    else scale = body.spacing * *particle_radius / unit_distance;
  } else {
    unit_distance = body.spacing * *particle_radius / scale;
    sites = lattice_points(unit, unit_distance);
  }
  if (sites.empty())
    throw cannot("fill", unit.label, "it is too small for a single particle",
                 "Make it larger or the particles smaller");
  const double volume = static_cast<double>(sites.size() / 3) * unit_distance * unit_distance * unit_distance / k_root2;
  filled.particles = scaled(sites, scale);
  filled.grains = scaled(unit_grains(body, unit, volume, scale, seed), scale);
  filled.lowest = lowest_after(body, unit, scale);
  return filled;
}

}  // namespace

Material fill_scene(SceneFile* scene, const BodyMeshes& meshes) {
  Material material;
  // A body that fixes the particle radius is filled first. The order in the scene stays that of the file.
  std::vector<Filled> filled(scene->bodies.size());
  for (const bool fixes_radius : {true, false})
    for (size_t i = 0; i < scene->bodies.size(); ++i) {
      const Body& body = scene->bodies[i];
      if ((body.size.y > 0.0 && body.particles > 0) != fixes_radius) continue;
      const std::string label = "body " + std::to_string(i) + " of " + scene->source;
      if (fixes_radius && scene->particle_radius > 0.0)
        throw cannot("fill", label, "another body fixes the particle radius already",
                     "Leave out its \"size\" or its \"particles\"");
      const uint64_t seed = scene->seed + (i << 32);
      if (body.shape == BodyShape::lattice) {
        const double distance = body.spacing * scene->particle_radius;
        Random random = {~seed};
        filled[i].particles = block_sites(body, distance);
        filled[i].grains = block_grains(body, filled[i].particles, distance, &random);
      } else {
        filled[i] = fill_body(body, make_unit_body(body, meshes, label), &scene->particle_radius, seed);
      }
      Random random = {seed};
      const double jitter = body.jitter * scene->particle_radius;
      if (jitter > 0.0)
        for (Vec3& p : filled[i].particles)
          for (double* coordinate : {&p.x, &p.y, &p.z}) *coordinate += jitter * (2.0 * random.uniform() - 1.0);
      const Vec3 offset = body.position - Vec3{0.0, filled[i].lowest, 0.0};
      for (std::vector<Vec3>* points : {&filled[i].particles, &filled[i].grains})
        for (Vec3& p : *points) p = rotate(body.rotation, p) + offset;
    }
  uint64_t particles = 0, grains = 0;
  for (const Filled& body : filled) {
    particles += body.particles.size();
    grains += body.grains.size();
  }
  if (particles > SANDGLASS_PARTICLE_LIMIT || grains > SANDGLASS_GRAIN_LIMIT)
    throw cannot(
        "fill", scene->source,
        "its bodies hold " + std::to_string(particles) + " particles and " + std::to_string(grains) + " grains",
        "At most " + std::to_string(SANDGLASS_PARTICLE_LIMIT) + " and " + std::to_string(SANDGLASS_GRAIN_LIMIT) +
            " are taken");
  for (size_t i = 0; i < filled.size(); ++i) {
    if (scene->bodies[i].rigid > 0.0) {
      RigidSample rigid;
      rigid.density = scene->bodies[i].rigid;
      rigid.velocity = scene->bodies[i].velocity;
      rigid.spin = scene->bodies[i].spin;
      std::vector<float> unused;
      append(filled[i].particles, {}, &rigid.positions, &unused);
      material.rigid.push_back(std::move(rigid));
      continue;
    }
    append(filled[i].particles, scene->bodies[i].velocity, &material.particle_positions, &material.particle_velocities);
    append(filled[i].grains, scene->bodies[i].velocity, &material.grain_positions, &material.grain_velocities);
  }
  return material;
}

}  // namespace sandglass::host
