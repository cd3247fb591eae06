#include "tests/laboratory/shadow/cast_world.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <string>

#include "models/files/failure.h"
#include "models/mesh/generated.h"
#include "models/simulation/scene_meshes.h"
#include "models/tracing/directions.h"
#include "models/tracing/embree_scene.h"
#include "models/work/random.h"
#include "sandglass/sandglass.hpp"
#include "tests/laboratory/shadow/app_cast.h"

namespace sandglass::host {

Mesh standing(const char* name, double height, Vec3 at) {
  MeshResult made = make_named(name);
  stand_mesh(&made.mesh, height, name);
  for (size_t i = 0; i < made.mesh.vertices.size(); i += 3)
    to_floats(from_floats(made.mesh.vertices.data() + i) + at, made.mesh.vertices.data() + i);
  return made.mesh;
}

namespace {

constexpr double k_degree = std::numbers::pi / 180, k_lift = 1e-5, k_far = 100;

// What a seed draws.
struct Draw {
  Random random;
  double between(double low, double high) { return low + (high - low) * random.uniform(); }
};

Mesh box(Vec3 low, Vec3 high) {
  Mesh mesh;
  for (int i = 0; i < 8; ++i)
    for (const double x : {(i & 1) != 0 ? high.x : low.x, (i & 2) != 0 ? high.y : low.y, (i & 4) != 0 ? high.z : low.z})
      mesh.vertices.push_back(static_cast<float>(x));
  mesh.indices = {0, 4, 6, 0, 6, 2, 1, 3, 7, 1, 7, 5, 0, 1, 5, 0, 5, 4,
                  2, 6, 7, 2, 7, 3, 0, 2, 3, 0, 3, 1, 4, 5, 7, 4, 7, 6};
  return mesh;
}

struct World {
  Vec3 light;          // towards it
  double half, share;  // radians; of the main light: cells hold the rest, evenly. 0: it is not told
  float bias, reach;
  sandglass_cast_plane plane;
  World(double elevation, double azimuth, double half_degrees)
      : light{std::cos(elevation * k_degree) * std::cos(azimuth * k_degree), std::sin(elevation * k_degree),
              std::cos(elevation * k_degree) * std::sin(azimuth * k_degree)},
        half(half_degrees * k_degree),
        share(0),
        bias(cast_plane().bias),
        reach(cast_desc().reach),
        plane(cast_plane()) {}
};

Cast drawn(const World& world, const std::vector<sandglass_cast_mesh>& meshes) {
  sandglass_cast_desc desc = cast_desc();
  desc.triangle_capacity = 0;
  for (const sandglass_cast_mesh& mesh : meshes) desc.triangle_capacity += 2 * mesh.triangle_count;
  desc.reach = world.reach;
  sandglass_cast_plane plane = world.plane;
  plane.bias = world.bias;
  std::array<float, SANDGLASS_LIGHT_CELLS> cells;
  cells.fill(static_cast<float>((1 - world.share) / SANDGLASS_LIGHT_CELLS));
  std::array<float, 3> light;
  to_floats(world.light, light.data());
  Cast cast;
  if (const Status made = cast.create(desc); !made) throw Failure(made.reason);
  for (const Status& done :
       {cast.set_plane(plane), cast.set_meshes(meshes.data(), static_cast<uint32_t>(meshes.size())),
        cast.set_light(light, static_cast<float>(2 * world.half)), cast.set_cells(cells)})
    if (!done) throw Failure(done.reason);
  cast.run();
  return cast;
}

// The shares of the main light and of an even sky that both leave, and that the real one alone does, by rays.
struct Left {
  double light = 0, sky = 0, light_without = 0, sky_without = 0;
};
Left traced(const World& world, const EmbreeScene& object, const EmbreeScene* real, Vec3 place) {
  constexpr int k_light_rays = 128, k_sky_rays = 384;
  Left left;
  double lights = 0;
  for (int i = 0; i < k_light_rays + k_sky_rays; ++i) {
    const double a = lattice_point(0.5, i, k_plane_steps[0]), b = lattice_point(0.5, i, k_plane_steps[1]);
    const bool sky = i >= k_light_rays;
    const Vec3 d = sky ? cosine_direction({0, 1, 0}, a, b) : cap_direction(world.light, std::cos(world.half), a, b);
    const double weight = sky ? 1.0 / k_sky_rays : d.y;
    if (!sky) lights += weight;
    if (real != nullptr && real->occluded(place, d, k_far)) continue;
    const bool free = !object.occluded(place, d, k_far);
    (sky ? left.sky_without : left.light_without) += weight;
    if (free) (sky ? left.sky : left.light) += weight;
  }
  left.light /= lights;
  left.light_without /= lights;
  return left;
}

EmbreeScene scene_of(const Mesh& mesh) { return EmbreeScene::triangles(mesh.vertices, mesh.indices); }

// A value of each of two ways to draw: the library's, and a control's.
struct Pair {
  double value = 0, control = 0;
  void worst(double a, double b) {
    value = std::max(value, a);
    control = std::max(control, b);
  }
};

// The mesh of a scan, with the floor in it some millimetres too high and noisy: what it takes of a chair's shadows.
Pair beside_scan(Draw* draw) {
  World world(draw->between(30, 70), draw->between(0, 360), 10);
  const Mesh chair = standing("chair", draw->between(0.1, 0.5), {});
  const double offset = draw->between(0.002, 0.02), noise = draw->between(0.001, 0.0099),
               side = draw->between(0.04, 0.1);
  constexpr uint32_t k_side = 40;
  Mesh scan;
  for (uint32_t i = 0; i < k_side * k_side; ++i) {
    for (const double x : {(i % k_side - 0.5 * k_side) * side, offset + draw->between(-noise, noise),
                           (i / k_side - 0.5 * k_side) * side})
      scan.vertices.push_back(static_cast<float>(x));
    const uint32_t b = i + k_side;
    if (i % k_side + 1 < k_side && b < k_side * k_side)
      scan.indices.insert(scan.indices.end(), {i, b, i + 1, i + 1, b, b + 1});
  }
  const auto dark = [&](bool with_scan, float bias) {
    world.bias = bias;
    std::vector<sandglass_cast_mesh> meshes = {cast_mesh_of(chair, false, false)};
    if (with_scan) meshes.push_back(cast_mesh_of(scan, false, true));
    const Cast cast = drawn(world, meshes);
    std::array<double, 2> sums = {};
    for (int i = 0; i < 10000; ++i) {
      const double x = 0.02 * (i % 100 - 50), z = 0.02 * (i / 100 - 50);
      sums[0] += sampled(cast.texture(), {x, 0, z}, 0);
      sums[1] += 1 - sampled(cast.ambient(), {x, 0, z}, 1);
    }
    return sums;
  };
  const auto alone = dark(false, world.bias), with = dark(true, world.bias), control = dark(true, 0);
  Pair lost;
  for (size_t i = 0; i < 2; ++i) lost.worst(1 - with[i] / alone[i], 1 - control[i] / alone[i]);
  return lost;
}

// A chair where something real shades the floor: how far the darkening is from the truth, as a share of it. The control
// does not tell the main light's share, so each texture is divided by what is left of its own light alone.
Pair in_shade(Draw* draw, bool below_table, ThreadPool& pool) {
  const double height = draw->between(0.1, 0.3), elevation = draw->between(35, 60);
  World world(elevation, 90, draw->between(2, 10));  // from +z
  const Mesh chair = standing("chair", height, {});
  const double wall_at = height * draw->between(1.2, 2), wall = draw->between(1, 1.5);
  const Mesh real =
      below_table ? box({-0.6, 0.5, -0.5}, {0.6, 0.53, 1.0}) : box({-1.5, 0, wall_at}, {1.5, wall, wall_at + 0.05});
  const EmbreeScene of_chair = scene_of(chair), of_real = scene_of(real);
  const std::vector<sandglass_cast_mesh> meshes = {cast_mesh_of(chair, false, false), cast_mesh_of(real, false, true)};
  const Cast plain = drawn(world, meshes);
  constexpr int k_side = 24;
  std::vector<Left> truth(k_side * k_side);
  const auto place = [&](int i) {
    return Vec3{(i % k_side - 11.5) / k_side * 2.2 * height, k_lift, (i / k_side - 11.5) / k_side * 2.2 * height};
  };
  pool.run(k_side * k_side,
           [&](uint32_t i) { truth[i] = traced(world, of_chair, &of_real, place(static_cast<int>(i))); });
  Pair worst;
  for (const double share : {0.3, 0.5, 0.7, 0.85, 0.95}) {
    world.share = share;
    const Cast cast = drawn(world, meshes);
    double wanted = 0, known = 0, control = 0;
    for (int i = 0; i < k_side * k_side; ++i) {
      const Vec3 p = place(i);
      const Left& left = truth[static_cast<size_t>(i)];
      const double before = share * left.light_without + (1 - share) * left.sky_without;
      if (before < 0.01) continue;
      wanted += 1 - (share * left.light + (1 - share) * left.sky) / before;
      known += 1 - (share * (1 - sampled(cast.texture(), {p.x, 0, p.z}, 0)) +
                    std::max(sampled(cast.ambient(), {p.x, 0, p.z}, 1) - share, 0.0));
      control += share * sampled(plain.texture(), {p.x, 0, p.z}, 0) +
                 (1 - share) * (1 - sampled(plain.ambient(), {p.x, 0, p.z}, 1));
    }
    worst.worst(std::fabs(known / wanted - 1), std::fabs(control / wanted - 1));
  }
  return worst;
}

// RMSE beside a bucket of a mug's size, with something far in the same cast. The control draws all.
Pair among_far(Draw* draw, int kind, ThreadPool& pool) {
  World world(draw->between(40, 65), draw->between(0, 360), 10);
  const Mesh mug = standing("bucket", 0.1, {});
  const double turn = draw->between(0, 2 * std::numbers::pi), away = draw->between(2, 10);
  const Vec3 there = {away * std::cos(turn), 0, away * std::sin(turn)};
  Mesh other = standing("bucket", 0.1, there);
  std::vector<sandglass_cast_mesh> meshes;
  if (kind == 1) other = standing("chair", 0.3, there * 3.0 + Vec3{0, 8, 0});
  if (kind == 2) {  // a corner of the mug's own mesh is wrong
    other = mug;
    to_floats({draw->between(-3, 3), 40, 1}, other.vertices.data());
    to_floats({draw->between(-3, 3), 35, 1}, other.vertices.data());
    other.vertices.insert(other.vertices.end(), mug.vertices.begin(), mug.vertices.begin() + 3);
    const uint32_t again = other.vertex_count() - 1;
    uint32_t kept = 0;  // one triangle of it keeps the wrong one
    for (uint32_t& i : other.indices)
      if (i == 0 && kept++ > 0) i = again;
    meshes = {cast_mesh_of(other, false, false)};
  } else {
    meshes = {cast_mesh_of(mug, false, false), cast_mesh_of(other, false, false)};
  }
  const EmbreeScene of_mug = scene_of(mug);
  const Cast cast = drawn(world, meshes);
  world.reach = 0;
  const Cast all = drawn(world, meshes);
  constexpr int k_side = 50;
  std::vector<double> off(2 * k_side * k_side);
  pool.run(k_side, [&](uint32_t row) {
    for (int column = 0; column < k_side; ++column) {
      const Vec3 p = {0.01 * column - 0.245, k_lift, 0.01 * row - 0.245};
      if (std::hypot(p.x, p.z) < 0.07) continue;
      const double dark = 1 - traced(world, of_mug, nullptr, p).light;
      double* to = off.data() + 2 * (row * k_side + static_cast<uint32_t>(column));
      to[0] = sampled(cast.texture(), {p.x, 0, p.z}, 0) - dark;
      to[1] = sampled(all.texture(), {p.x, 0, p.z}, 0) - dark;
    }
  });
  Pair sum;
  for (size_t i = 0; i < off.size(); i += 2) {
    sum.value += off[i] * off[i];
    sum.control += off[i + 1] * off[i + 1];
  }
  return {std::sqrt(2 * sum.value / static_cast<double>(off.size())),
          std::sqrt(2 * sum.control / static_cast<double>(off.size()))};
}

// The darkest that a shadow is in the air beyond a table's end. The control ends with the texel in which the table
// does.
Pair at_end(Draw* draw) {
  World world(draw->between(30, 50), 180, 5);  // the shadow falls towards +x
  const double height = draw->between(0.1, 2), end = height * draw->between(0.4, 0.8);
  const Mesh chair = standing("chair", height, {});
  World ends = world;
  ends.plane.high[0] = static_cast<float>(end);
  const Cast cast = drawn(ends, {cast_mesh_of(chair, false, false)}),
             whole = drawn(world, {cast_mesh_of(chair, false, false)});
  Pair dark;
  for (int i = 0; i < 4000; ++i) {
    const double x = end + 1e-5 + height * 0.01 * (i % 40), z = height * 0.01 * (i / 40 - 50);
    const auto of = [&](const Cast& c) {
      return std::max(sampled(c.texture(), {x, 0, z}, 0), 1 - sampled(c.ambient(), {x, 0, z}, 1));
    };
    const double texel = static_cast<double>(whole.texture().along[0]) / whole.texture().side;
    dark.worst(of(cast), x < end + texel ? of(whole) : 0);
  }
  return dark;
}

}  // namespace

std::vector<Verdict> verify_cast_worlds(uint64_t seed, bool quick, ThreadPool& pool,
                                        const std::function<bool()>& go_on) {
  std::vector<Verdict> rows;
  const auto row = [&](const std::string& name, const char* unit, const Pair& pair, double limit) {
    rows.push_back({"world", name, unit, 0, pair.value, limit, pair.value <= limit, false});
    rows.push_back({"world", name + ", as before", unit, 0, pair.control, limit, !(pair.control <= limit), true});
  };
  Draw draw = {random_stream(seed, 57)};
  const int rounds = quick ? 2 : 6;
  std::array<Pair, 7> worst;
  const auto take = [&](size_t i, const Pair& pair) { worst[i].worst(pair.value, pair.control); };
  for (int i = 0; i < rounds; ++i) take(0, beside_scan(&draw));
  row("a scan with its floor, share of the shadows lost", "share", worst[0], 0.01);
  if (!go_on()) return rows;
  for (int i = 0; i < rounds; ++i) {
    take(1, in_shade(&draw, false, pool));
    take(2, in_shade(&draw, true, pool));
  }
  row("in a wall's shade, darkening off by", "share", worst[1], 0.15);
  row("in a table's shade, darkening off by", "share", worst[2], 0.15);
  if (!go_on()) return rows;
  for (int i = 0; i < rounds; ++i)
    for (int kind = 0; kind < 3; ++kind) take(3 + static_cast<size_t>(kind), among_far(&draw, kind, pool));
  row("beside a mug, another one away", "rmse", worst[3], 0.005);
  row("beside a mug, a bird", "rmse", worst[4], 0.005);
  row("beside a mug, a stray corner", "rmse", worst[5], 0.005);
  if (!go_on()) return rows;
  for (int i = 0; i < rounds; ++i) take(6, at_end(&draw));
  row("beyond a table's end, darkest", "share", worst[6], 0.004);
  (void)go_on();
  return rows;
}

}  // namespace sandglass::host
