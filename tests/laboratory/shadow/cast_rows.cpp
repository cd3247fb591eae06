#include "tests/laboratory/shadow/cast_rows.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <numbers>

#include "models/baking/ambient_errors.h"
#include "models/baking/light_cells.h"
#include "models/baking/truth.h"
#include "models/files/failure.h"
#include "models/work/random.h"
#include "sandglass/sandglass.hpp"
#include "tests/laboratory/room/known_room.h"
#include "tests/laboratory/shadow/cast_drawing.h"

namespace sandglass::host {

namespace {

constexpr double k_reported = std::numeric_limits<double>::infinity();

// Twelve lights, 2 to 20 degrees wide to each side and 20 to 70 high.
std::vector<Light> wide_lights(const CastRowsOptions& options) {
  std::vector<Light> lights;
  for (const double half : {2.0, 5.0, 10.0, 20.0})
    for (const double elevation : {20.0, 45.0, 70.0})
      lights.push_back({direction_at(elevation * k_degree, 0.7 + 1.9 * static_cast<double>(lights.size()) +
                                                               0.37 * static_cast<double>(options.seed)),
                        half * k_degree});
  if (options.quick)
    for (size_t i = 0; i < 6; ++i) lights[i] = lights[2 * i];  // of each width, high, middle and low
  if (options.quick) lights.resize(6);
  return lights;
}

class Rows {
 public:
  // At most `limit`; infinite: reported. A control must be above it.
  void add(const std::string& group, const std::string& name, double value, double limit, bool control = false) {
    const bool holds = value <= limit;
    rows.push_back({group, group + ", " + name, "rmse", 0, value, limit, control ? !holds : holds, control});
  }
  // The same for the meshes that constants were chosen on; for others it is reported, because the number depends on the
  // shape.
  void chosen_on(const std::string& group, const std::string& name, double value, double limit, bool control = false) {
    const bool judged = group == "chair" || group == "armadillo";
    add(group, name, value, judged ? limit : k_reported, control && judged);
  }
  std::vector<Verdict> rows;
};

// ------------------------------------------------------------------------------------------------ one light

void whole_mesh(const CastRowsOptions& options, const CastMeshFile& file, ThreadPool& pool, Rows* rows) {
  const StandingObject object = stand_on_plane(file.mesh, file.name);
  std::map<std::string, Sum> sums;
  uint64_t stream = 0;
  for (const Light& light : wide_lights(options)) {
    const Drawn fine = cast_of(object.mesh, light, {.closed = file.closed});
    const ShadowRectangle rectangle = fitted(object.box, light);
    const double texel = fine.area(), area = area_of(rectangle);
    const Truth truth = truth_of(object.mesh, light, fine, ++stream, pool);
    const auto error = [&](const Drawn& drawn) {
      const bool same = drawn.rectangle.low_x == fine.rectangle.low_x && drawn.rectangle.low_z == fine.rectangle.low_z;
      return error_of(
          [&](size_t i) {
            const auto p = fine.place(i);
            return same ? static_cast<double>(drawn.left[i]) : drawn.at(p[0], p[1]);
          },
          truth, texel, area);
    };
    sums["64"].add(error(fine));
    const auto of = [&](Light l, uint32_t directions, bool closed) {
      return error(cast_of(object.mesh, l, {.directions = directions, .closed = closed}));
    };
    sums["32"].add(of(light, 32, file.closed));
    sums["both sides"].add(of(light, 64, false));
    sums["8"].add(of(light, 8, file.closed));
    sums["turned by 5 degrees"].add(of({turned(light.direction, 5), light.half}, 64, file.closed));
    sums["half as wide"].add(of({light.direction, 0.5 * light.half}, 64, file.closed));
    sums["a point"].add(of({light.direction, 1e-3}, 64, file.closed));
    sums["from the other side"].add(of({turned(light.direction, 180), light.half}, 64, file.closed));
  }
  const std::string& g = file.name;
  rows->add(g, "K 64", sums["64"].mean(), 0.012);
  rows->add(g, "K 64, worst light", sums["64"].worst, 0.021);
  rows->add(g, "K 64, both sides", sums["both sides"].mean(), 0.012);
  rows->add(g, "K 32", sums["32"].mean(), 0.016);
  for (const char* control : {"8", "turned by 5 degrees", "half as wide", "a point", "from the other side"})
    rows->add(g, control[0] == '8' ? "K 8" : std::string("light ") + control, sums[control].mean(), 0.016, true);
}

// The lights of the baked network, beside it.
void baked_lights(const CastRowsOptions& options, const CastMeshFile& file, ThreadPool& pool, Rows* rows) {
  const StandingObject object = stand_on_plane(file.mesh, file.name);
  Sum of_cast, of_network;
  Shadow network;
  std::vector<uint64_t> aligned((options.baked.size() + 7) / 8);
  std::copy(options.baked.begin(), options.baked.end(), reinterpret_cast<unsigned char*>(aligned.data()));
  sandglass_shadow_desc desc = shadow_desc(aligned.data(), options.baked.size());
  if (const Status made = network.create(desc); !made) throw Failure(made.reason);
  uint64_t stream = 100;
  for (const Direction& d : ring_directions(70 * k_degree, options.quick ? 4 : 12)) {
    const Light light = {d, 10 * k_degree};
    const Drawn drawn = cast_of(object.mesh, light, {.closed = file.closed});
    const double area = area_of(fitted(object.box, light));
    const Truth truth = truth_of(object.mesh, light, drawn, ++stream, pool);
    of_cast.add(error_of([&](size_t i) { return static_cast<double>(drawn.left[i]); }, truth, drawn.area(), area));
    std::array<float, 3> towards;
    for (size_t i = 0; i < 3; ++i) towards[i] = static_cast<float>(d[i]);
    (void)network.set_light(towards);
    sandglass_shadow* handle = network.get();
    while (sandglass_shadow_run(&handle, 1, UINT32_MAX) > 0) {
    }
    const sandglass_texture t = network.texture(0);
    Drawn other;
    other.texels = SANDGLASS_SHADOW_TEXELS;
    const double s = object.scale;
    other.rectangle = {(t.corner[0] - object.origin[0]) / s, (t.corner[2] - object.origin[2]) / s,
                       (t.corner[0] + t.along[0] - object.origin[0]) / s,
                       (t.corner[2] + t.across[2] - object.origin[2]) / s};
    for (uint32_t i = 0; i < other.texels * other.texels; ++i)
      other.left.push_back(1 - static_cast<float>(t.bytes[i]) / 255.0f * t.scale);
    of_network.add(
        error_of([&](size_t i) { return other.at(drawn.place(i)[0], drawn.place(i)[1]); }, truth, drawn.area(), area));
  }
  rows->add(file.name, "lights of the bake, K 64", of_cast.mean(), 0.012);
  rows->add(file.name, "lights of the bake, its network", of_network.mean(), k_reported);
}

// ------------------------------------------------------------------------------------------------ other planes

// The wall's own frame: x along it, y away from it, z down.
Mesh before_wall(const StandingObject& object, double heights) {
  Mesh m = object.mesh;
  for (size_t i = 0; i < m.vertices.size(); i += 3) {
    const double y = static_cast<double>(m.vertices[i + 1]), z = static_cast<double>(m.vertices[i + 2]);
    m.vertices[i + 1] = static_cast<float>(z + object.box.half_z + heights * object.box.height);
    m.vertices[i + 2] = static_cast<float>(-y);
  }
  return m;
}

void on_wall(const CastMeshFile& file, ThreadPool& pool, Rows* rows) {
  const StandingObject object = stand_on_plane(file.mesh, file.name);
  for (const double heights : {0.3, 1.0}) {
    const Mesh mesh = before_wall(object, heights);
    const double h = 1.5 * object.box.height;
    Sum sum, none;
    uint64_t stream = 200;
    for (const double half : {2.0, 5.0, 10.0, 20.0})
      for (const double elevation : {20.0, 40.0})
        for (const double azimuth : {60.0, 100.0}) {  // 90: straight at the wall
          const Direction w = direction_at(elevation * k_degree, azimuth * k_degree);
          const Light light = {{w[0], w[2], -w[1]}, half * k_degree};
          const CastChoice choice = {.closed = file.closed, .limits = ShadowRectangle{-h, -h, h, 0}};
          const Drawn drawn = cast_of(mesh, light, choice);
          const Truth truth = truth_of(mesh, light, drawn, ++stream, pool);
          const double area = 2 * h * h;
          sum.add(error_of([&](size_t i) { return static_cast<double>(drawn.left[i]); }, truth, drawn.area(), area));
          none.add(error_of([](size_t) { return 1.0; }, truth, drawn.area(), area));
        }
    const std::string name = heights < 0.5 ? "wall at 0.3 heights" : "wall at 1 height";
    rows->add(file.name, name + ", K 64", sum.mean(), 0.010);
    rows->add(file.name, name + ", no shadow", none.mean(), 0.010, true);
  }
}

Mesh together(const Mesh& a, const Mesh& b) {
  Mesh both = a;
  both.vertices.insert(both.vertices.end(), b.vertices.begin(), b.vertices.end());
  for (const uint32_t i : b.indices) both.indices.push_back(a.vertex_count() + i);
  return both;
}

// The object at a table's edge, the floor 0.7 heights below. What the floor's image must be multiplied by.
void below_table(const CastMeshFile& file, ThreadPool& pool, Rows* rows) {
  const StandingObject object = stand_on_plane(file.mesh, file.name);
  const float drop = 0.7f * static_cast<float>(object.box.height);
  Mesh up = object.mesh;
  for (size_t i = 1; i < up.vertices.size(); i += 3) up.vertices[i] += drop;
  const float x1 = 0.6f * static_cast<float>(object.box.half_x);
  const float low[3] = {-1.5f, drop - 0.03f, -1}, high[3] = {x1, drop - 0.001f, 1};
  Mesh board;
  for (uint32_t i = 0; i < 8; ++i)
    for (uint32_t axis = 0; axis < 3; ++axis) board.vertices.push_back((i >> axis & 1) != 0 ? high[axis] : low[axis]);
  board.indices = {0, 4, 6, 0, 6, 2, 1, 3, 7, 1, 7, 5, 0, 1, 5, 0, 5, 4,
                   2, 6, 7, 2, 7, 3, 0, 2, 3, 0, 3, 1, 4, 5, 7, 4, 7, 6};
  const Mesh both = together(up, board);
  Sum masked, alone, none;
  uint64_t stream = 300;
  for (const double half : {5.0, 10.0, 20.0})
    for (const double azimuth : {150.0, 200.0}) {
      const Light light = {direction_at(45 * k_degree, azimuth * k_degree), half * k_degree};
      const CastChoice choice = {.closed = file.closed, .limits = ShadowRectangle{-0.5, -1.25, 2.0, 1.25}};
      CastChoice with_table = choice;
      with_table.real = &board;
      const Drawn drawn = cast_of(up, light, with_table), plain = cast_of(up, light, choice);
      ++stream;
      const Truth of_both = truth_of(both, light, drawn, stream, pool),
                  of_board = truth_of(board, light, drawn, stream, pool);
      Drawn whole;  // the rectangle in which the bar was measured
      whole.rectangle = *choice.limits;
      whole.texels = 64;
      const Truth lit = truth_of(board, light, whole, stream, pool);
      double weight = 0;
      for (const float t : lit.a) weight += static_cast<double>(t) * static_cast<double>(t) * whole.area();
      const auto error = [&](const std::function<double(size_t)>& left) {
        double sum = 0;
        for (size_t i = 0; i < of_both.a.size(); ++i) {
          const double b = 0.5 * (static_cast<double>(of_board.a[i]) + static_cast<double>(of_board.b[i]));
          if (b < 0.02) continue;  // dark in the image already
          sum += (b * left(i) - static_cast<double>(of_both.a[i])) * (b * left(i) - static_cast<double>(of_both.b[i]));
        }
        return std::sqrt(std::max(sum, 0.0) * drawn.area() / weight);
      };
      masked.add(error([&](size_t i) { return static_cast<double>(drawn.left[i]); }));
      alone.add(error([&](size_t i) { return plain.at(drawn.place(i)[0], drawn.place(i)[1]); }));
      none.add(error([](size_t) { return 1.0; }));
    }
  rows->add(file.name, "below a table, masked", masked.mean(), 0.016);
  rows->chosen_on(file.name, "below a table, unmasked", alone.mean(), 0.016, true);
  rows->add(file.name, "below a table, no shadow", none.mean(), 0.016, true);
}

// A heap of sand in the object's shadow, as steep as sand lies: what both leave of the light, in one cast.
void with_heap(const CastMeshFile& file, ThreadPool& pool, Rows* rows) {
  constexpr uint32_t k_around = 48;
  const StandingObject object = stand_on_plane(file.mesh, file.name);
  const float height = 0.12f * static_cast<float>(object.box.height), radius = height / 0.6f;
  Sum errors;
  uint64_t stream = 350;
  for (const double half : {5.0, 10.0, 20.0})
    for (const double azimuth : {20.0, 140.0, 260.0}) {
      const Light light = {direction_at(40 * k_degree, azimuth * k_degree), half * k_degree};
      const double reach = 0.6 * object.box.height;  // from the object's middle, away from the light
      const double x = -reach * std::cos(azimuth * k_degree), z = -reach * std::sin(azimuth * k_degree);
      Mesh heap;
      heap.vertices = {static_cast<float>(x), height, static_cast<float>(z),
                       static_cast<float>(x), 0,      static_cast<float>(z)};
      for (uint32_t i = 0; i < k_around; ++i) {
        const double turn = 2 * std::numbers::pi * i / k_around;
        for (const double c :
             {x + static_cast<double>(radius) * std::cos(turn), 0.0, z + static_cast<double>(radius) * std::sin(turn)})
          heap.vertices.push_back(static_cast<float>(c));
        const uint32_t a = 2 + i, b = 2 + (i + 1) % k_around;
        heap.indices.insert(heap.indices.end(), {0, b, a, 1, a, b});
      }
      const Mesh both = together(object.mesh, heap);
      const Drawn of_both = cast_of(both, light, {.closed = file.closed});
      const Truth truth = truth_of(both, light, of_both, ++stream, pool);
      const double area = area_of(fitted(object.box, light));
      // Of the floor that is seen: what the heap covers is sand, which has a texture of its own.
      double sum = 0;
      for (size_t i = 0; i < truth.a.size(); ++i) {
        const auto p = of_both.place(i);
        if (std::hypot(p[0] - x, p[1] - z) < static_cast<double>(radius)) continue;
        const double left = static_cast<double>(of_both.left[i]);
        sum += (left - static_cast<double>(truth.a[i])) * (left - static_cast<double>(truth.b[i]));
      }
      errors.add(std::sqrt(std::max(sum, 0.0) * of_both.area() / area));
    }
  rows->add(file.name, "beside a heap, both in one cast", errors.mean(), 0.012);
}

// ------------------------------------------------------------------------------------------------ rooms

std::array<float, SANDGLASS_LIGHT_CELLS> floats(const std::array<double, SANDGLASS_LIGHT_CELLS>& cells) {
  std::array<float, SANDGLASS_LIGHT_CELLS> out;
  for (size_t i = 0; i < cells.size(); ++i) out[i] = static_cast<float>(cells[i]);
  return out;
}

// A panorama as the wall's frame sees it.
RadianceMap seen_from_wall(const RadianceMap& room) {
  return panorama_of(room.width, room.height, [&](Vec3 d) { return look_up(room, {d.x, -d.z, d.y}); });
}

// What an app has that knows the floor's cells alone: their radiance where they are above the wall's horizon, and a floor of
// albedo 0.3 below.
std::array<double, SANDGLASS_LIGHT_CELLS> of_floor(const Environment& floor) {
  std::array<double, SANDGLASS_LIGHT_CELLS> cells = {};
  double sum = 0;
  for (uint32_t k = 0; k < cells.size(); ++k)
    for (int i = 0; i < 64; ++i) {
      const Vec3 d = cell_direction(k, (i % 8 + 0.5) / 8, (i / 8 + 0.5) / 8), world = {d.x, -d.z, d.y};
      const double share = world.y > 0 ? floor.cells()[cell_of(world)] : 0.3 / 64;
      cells[k] += share;
      sum += share;
    }
  for (double& cell : cells) cell /= sum;
  return cells;
}

// What a room of the library knows of a wall, which faces +z: from a cube of the panorama, in its 512 parts.
std::array<double, SANDGLASS_LIGHT_CELLS> of_library(const RadianceMap& panorama) {
  cpp::Room room;
  know_room(panorama, &room);
  const float normal[3] = {0, 0, 1}, along[3] = {1, 0, 0};
  const sandglass_room_light light = light_on(room, normal, along);
  std::array<double, SANDGLASS_LIGHT_CELLS> cells;
  std::copy(std::begin(light.cells), std::end(light.cells), cells.begin());
  return cells;
}

void in_rooms(const CastRowsOptions& options, const CastMeshFile& file, bool wall, ThreadPool& pool, Rows* rows,
              const std::function<bool()>& go_on) {
  const StandingObject object = stand_on_plane(file.mesh, file.name);
  Mesh mesh = wall ? before_wall(object, 0.3) : object.mesh;
  if (wall)  // the middle of the square is where the object's middle is
    for (size_t i = 2; i < mesh.vertices.size(); i += 3)
      mesh.vertices[i] += static_cast<float>(0.75 * object.box.height);
  const EmbreeScene scene = EmbreeScene::triangles(mesh.vertices, mesh.indices);
  const FloorSquare square{wall ? 0.75 * object.box.height : 2 * object.box.height, 64};
  const ShadowRectangle around = {-square.half, -square.half, square.half, square.half};
  Sum cells, even, of_the_floor, of_room;
  uint64_t seed = 10 + options.seed;
  for (const RadianceMap& room : options.rooms) {
    if (!go_on()) return;
    const RadianceMap seen = wall ? seen_from_wall(room) : room;
    const Environment environment(seen);
    const Truth truth = {trace_ambient(scene, square, environment, 128, ++seed, pool),
                         trace_ambient(scene, square, environment, 128, 1000 + seed, pool)};
    Drawn grid;
    grid.rectangle = around;
    grid.texels = square.side;
    const auto error = [&](const std::array<double, SANDGLASS_LIGHT_CELLS>& shares) {
      const Drawn drawn =
          cast_of(mesh, {{0, 1, 0}, 0.1}, {.texels = 64, .closed = file.closed, .cells = floats(shares)});
      return error_of([&](size_t i) { return drawn.at(grid.place(i)[0], grid.place(i)[1]); }, truth, 1, 64 * 64);
    };
    cells.add(error(environment.cells()));
    std::array<double, SANDGLASS_LIGHT_CELLS> flat;
    flat.fill(1.0 / SANDGLASS_LIGHT_CELLS);
    even.add(error(flat));
    if (!wall) continue;
    of_the_floor.add(error(of_floor(Environment(room))));
    of_room.add(error(of_library(room)));
  }
  const std::string name = wall ? "ambient on a wall" : "ambient";
  const double limit = wall ? 0.031 : 0.020;
  rows->add(file.name, name + ", its cells", cells.mean(), limit);
  rows->add(file.name, name + ", an even sky", even.mean(), limit, true);
  if (!wall) return;
  rows->add(file.name, name + ", the library's room", of_room.mean(), 0.034);  // of 512 parts
  rows->add(file.name, name + ", the floor's cells", of_the_floor.mean(), limit, true);
}

// What a surface receives of an even sky beside what it would without itself, by rays from places on it; of a closed mesh
// alone: of another a cast counts both sides.
void of_surface(const CastMeshFile& file, Rows* rows) {
  constexpr int k_places = 3000, k_rings = 8;
  const StandingObject object = stand_on_plane(file.mesh, file.name);
  const EmbreeScene scene = EmbreeScene::triangles(object.mesh.vertices, object.mesh.indices);
  const auto corner = [&](size_t i) {
    return from_floats(object.mesh.vertices.data() + 3 * static_cast<size_t>(object.mesh.indices[i]));
  };
  std::vector<double> areas;
  double all = 0;
  for (size_t t = 0; t < object.mesh.indices.size(); t += 3)
    areas.push_back(all += length(cross(corner(t + 1) - corner(t), corner(t + 2) - corner(t))));
  Random random = random_stream(7, 0);
  double open = 0, sky = 0;
  for (int i = 0; i < k_places; ++i) {
    const double at = (i + random.uniform()) / k_places * all;
    const size_t t = 3 * static_cast<size_t>(std::lower_bound(areas.begin(), areas.end(), at) - areas.begin());
    double a = random.uniform(), b = random.uniform();
    if (a + b > 1) {
      a = 1 - a;
      b = 1 - b;
    }
    const Vec3 ab = corner(t + 1) - corner(t), ac = corner(t + 2) - corner(t), normal = normalised(cross(ab, ac));
    const Vec3 place = corner(t) + ab * a + ac * b + normal * 1e-4;
    double seen = 0, whole = 0;
    for (int j = 0; j < 4 * k_rings * k_rings; ++j) {
      const double y = (j / (4 * k_rings) + random.uniform()) / k_rings,
                   f = 2 * std::numbers::pi * (j % (4 * k_rings) + random.uniform()) / (4 * k_rings);
      const double flat = std::sqrt(1 - y * y), facing = dot(normal, {flat * std::cos(f), y, flat * std::sin(f)});
      if (facing <= 0) continue;
      whole += facing;
      if (!scene.occluded(place, {flat * std::cos(f), y, flat * std::sin(f)}, 10)) seen += facing;
    }
    open += seen;
    sky += whole;
  }
  CastChoice choice = {.closed = file.closed};
  choice.cells.emplace();
  choice.cells->fill(1.0f / SANDGLASS_LIGHT_CELLS);
  const double cast_open = cast_of(object.mesh, {{0, 1, 0}, 0.1}, choice).open;
  rows->add(file.name, "light of its own surface, off by", std::fabs(cast_open - open / sky),
            file.closed ? 0.03 : k_reported);
}

// ------------------------------------------------------------------------------------------------ from frame to frame

// How the error changes where the object, or the light, turns by half a degree a frame.
void shimmer(const CastMeshFile& file, ThreadPool& pool, Rows* rows) {
  const StandingObject object = stand_on_plane(file.mesh, file.name);
  for (const double half : {5.0, 20.0})
    for (const bool of_light : {false, true}) {
      const double e = 45 * k_degree;
      const Direction from = {0.8 * std::cos(e), std::sin(e), 0.6 * std::cos(e)};
      constexpr int k_frames = 8;
      std::vector<std::array<std::vector<double>, 2>> errors;
      Drawn first;
      Cast cast;
      for (int f = 0; f < k_frames; ++f) {
        const double degrees = 0.5 * f, c = std::cos(degrees * k_degree), s = std::sin(degrees * k_degree);
        Mesh mesh = object.mesh;
        if (!of_light)
          for (size_t i = 0; i < mesh.vertices.size(); i += 3) {
            const double x = static_cast<double>(mesh.vertices[i]), z = static_cast<double>(mesh.vertices[i + 2]);
            mesh.vertices[i] = static_cast<float>(c * x - s * z);
            mesh.vertices[i + 2] = static_cast<float>(s * x + c * z);
          }
        const Light light = {of_light ? turned(from, degrees) : from, half * k_degree};
        const CastChoice choice = {.closed = file.closed, .version = static_cast<uint32_t>(f)};
        const Drawn drawn = cast_of(mesh, light, choice, &cast);
        if (f == 0) first = drawn;
        const Truth truth = truth_of(mesh, light, first, 400 + static_cast<uint64_t>(f), pool);
        std::array<std::vector<double>, 2> error;
        for (size_t i = 0; i < truth.a.size(); ++i) {
          const double left = drawn.at(first.place(i)[0], first.place(i)[1]);
          error[0].push_back(left - static_cast<double>(truth.a[i]));
          error[1].push_back(left - static_cast<double>(truth.b[i]));
        }
        errors.push_back(std::move(error));
      }
      double sum = 0;
      for (size_t f = 1; f < errors.size(); ++f)
        for (size_t i = 0; i < errors[0][0].size(); ++i)
          sum += (errors[f][0][i] - errors[f - 1][0][i]) * (errors[f][1][i] - errors[f - 1][1][i]);
      // Over the rectangle of a box as wide as it is long, which holds the object however it is turned.
      ShadowBox box = object.box;
      box.half_x = box.half_z = 0.5;
      const double area = area_of(fitted(box, {from, half * k_degree}));
      const double change = std::sqrt(std::max(sum, 0.0) / (k_frames - 1) * first.area() / area);
      rows->chosen_on(file.name,
                      std::string(of_light ? "light" : "object") + " turns, " + (half < 10 ? "5" : "20") + " degrees",
                      change,
                      of_light    ? (half < 10 ? 0.010 : 0.0055)
                      : half < 10 ? 0.0075
                                  : 0.0035);
    }
}

}  // namespace

std::vector<Verdict> verify_casts(const CastRowsOptions& options, ThreadPool& pool,
                                  const std::function<bool(size_t done, size_t all)>& progress) {
  Rows rows;
  const size_t meshes = options.meshes.size(), with_rooms = options.rooms.empty() ? 0 : std::min<size_t>(2, meshes);
  const size_t all = 5 * meshes + (with_rooms != 0 ? (with_rooms + 1) * options.rooms.size() : 0);
  size_t done = 0;
  const auto next = [&] { return progress(++done, all); };
  for (const CastMeshFile& file : options.meshes) {
    whole_mesh(options, file, pool, &rows);
    if (!next()) return rows.rows;
    if (file.name == "chair" && !options.baked.empty()) baked_lights(options, file, pool, &rows);
    if (!next()) return rows.rows;
    on_wall(file, pool, &rows);
    if (!next()) return rows.rows;
    below_table(file, pool, &rows);
    with_heap(file, pool, &rows);
    of_surface(file, &rows);
    if (!next()) return rows.rows;
    shimmer(file, pool, &rows);
    if (!next()) return rows.rows;
  }
  for (size_t i = 0; i < with_rooms; ++i) in_rooms(options, options.meshes[i], false, pool, &rows, next);
  if (with_rooms != 0) in_rooms(options, options.meshes[0], true, pool, &rows, next);
  return rows.rows;
}

}  // namespace sandglass::host
