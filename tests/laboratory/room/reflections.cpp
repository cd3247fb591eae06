#include "tests/laboratory/room/reflections.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>

#include "models/work/random.h"
#include "runtime/light/cube_map.h"
#include "runtime/math/half.h"
#include "tests/laboratory/room/session.h"

namespace sandglass::host {

namespace {

constexpr int k_across = 40, k_width = 512, k_lobe_width = 128;
constexpr double k_alpha = 0.04;       // roughness as GGX has it: the square of what artists set
constexpr double k_mean_shown = 0.35;  // of white: the room's mean radiance

RadianceMap times(const RadianceMap& map, const std::function<double(double)>& change) {
  RadianceMap out(map.width, map.height);
  for (int v = 0; v < map.height; ++v)
    for (int u = 0; u < map.width; ++u) {
      const Vec3 c = map.colour(u, v);
      out.set(u, v, {change(c.x), change(c.y), change(c.z)});
    }
  return out;
}

double mean_of(const RadianceMap& map) {
  double sum = 0, area = 0;
  for (int v = 0; v < map.height; ++v)
    for (int u = 0; u < map.width; ++u) {
      sum += luminance(map.colour(u, v)) * pixel_solid_angle(v, map.width, map.height);
      area += pixel_solid_angle(v, map.width, map.height);
    }
  return sum / area;
}

// ---- a panorama as an engine samples a cube of it: bilinear, over the edges of faces too

struct Cube {
  int size;
  std::vector<Vec3> texels;

  Vec3 texel(CubePoint at) const {
    double d[3];
    cube_direction(at, d);  // beyond a face's edge lies the next one
    at = cube_point(d);
    const auto index = [&](double x) { return std::clamp(static_cast<int>((x + 1) / 2 * size), 0, size - 1); };
    return texels[static_cast<size_t>((static_cast<int>(at.face) * size + index(at.t)) * size + index(at.s))];
  }
  Vec3 sample(Vec3 direction) const {
    const double d[3] = {direction.x, direction.y, direction.z};
    const CubePoint at = cube_point(d);
    const double x = (at.s + 1) / 2 * size - 0.5, y = (at.t + 1) / 2 * size - 0.5, left = std::floor(x),
                 top = std::floor(y);
    Vec3 sum;
    for (int i = 0; i < 4; ++i) {
      const double u = left + i % 2, v = top + i / 2;
      const double weight = (1 - std::fabs(x - u)) * (1 - std::fabs(y - v));
      sum = sum + texel({at.face, 2 * (u + 0.5) / size - 1, 2 * (v + 0.5) / size - 1}) * weight;
    }
    return sum;
  }
  RadianceMap map() const {
    return panorama_of(k_width, k_width / 2, [&](Vec3 d) { return sample(d); });
  }
};

// The mean of each texel.
Cube cube_of(const RadianceMap& map) {
  constexpr int k_size = static_cast<int>(k_cube_size), k_fine = 6;
  Cube cube = {k_size, std::vector<Vec3>(k_cube_texels)};
  for (uint32_t i = 0; i < k_cube_texels; ++i) {
    Vec3 sum;
    double area = 0;
    for (int k = 0; k < k_fine * k_fine; ++k) {
      const double s = 2 * (i % k_cube_size + (k % k_fine + 0.5) / k_fine) / k_size - 1;
      const double t = 2 * (i / k_cube_size % k_cube_size + (k / k_fine + 0.5) / k_fine) / k_size - 1;
      double d[3];
      cube_direction({i / (k_cube_size * k_cube_size), s, t}, d);
      const double weight = std::pow(1 + s * s + t * t, -1.5);
      sum = sum + look_up(map, {d[0], d[1], d[2]}) * weight;
      area += weight;
    }
    cube.texels[i] = sum * (1 / area);
  }
  return cube;
}

// As the library gives it. The session's world is the panorama's, and its sphere has radius 1.
Cube cube_of(const SeenRoom& seen) {
  Cube cube = {static_cast<int>(k_cube_size), std::vector<Vec3>(k_cube_texels)};
  constexpr size_t k_face = size_t{k_cube_size} * k_cube_size;
  std::vector<uint16_t> face(4 * k_face);
  const float middle[3] = {0, 0, 0};
  for (uint32_t f = 0; f < 6; ++f) {
    room_face(seen.room, k_room_model, middle, 0.0f, f, false, face.data());
    for (size_t i = 0; i < k_face; ++i)
      cube.texels[f * k_face + i] =
          Vec3{from_half(face[4 * i]), from_half(face[4 * i + 1]), from_half(face[4 * i + 2])} * (1 / seen.exposure);
  }
  return cube;
}

// Had each texel been seen as it is.
SeenRoom seen_exactly(const RadianceMap& map, SeenRoom seen) {
  const Cube cube = cube_of(map);
  seen.texels = std::make_shared<std::vector<RoomTexel>>(k_cube_texels);
  seen.room.texels = seen.texels->data();
  seen.room.yaw = 0;
  for (uint32_t i = 0; i < k_cube_texels; ++i) {
    RoomTexel& texel = (*seen.texels)[i];
    const Vec3 there = cube.texels[i] * (seen.exposure * seen.room.scale / seen.room.light);
    texel = {{static_cast<float>(there.x), static_cast<float>(there.y), static_cast<float>(there.z)}, 0, 128, 0};
  }
  return seen;
}

// ---- the balls

// From +z, in a room that is turned so that `azimuth` lies ahead.
std::vector<Vec3> ball(const RadianceMap& map, double azimuth) {
  const Vec3 forward = {std::cos(azimuth), 0, std::sin(azimuth)}, right = {-std::sin(azimuth), 0, std::cos(azimuth)};
  const RadianceMap low = shrunk(map, map.width / k_lobe_width);
  std::vector<Vec3> pixels;
  for (int i = 0; i < k_across * k_across; ++i) {
    const double x = 2 * (i % k_across + 0.5) / k_across - 1, y = 1 - 2 * (i / k_across + 0.5) / k_across;
    if (x * x + y * y > 0.96) continue;
    Vec3 sum;
    double all = 0;
    const Vec3 normal = right * x + Vec3{0, y, 0} - forward * std::sqrt(std::max(0.0, 1 - x * x - y * y));
    const Vec3 reflected = forward - normal * (2 * dot(normal, forward));
    for (int v = 0; v < low.height; ++v)
      for (int u = 0; u < low.width; ++u) {
        const double c = dot(panorama_direction(u, v, low.width, low.height), reflected);
        if (c <= 0) continue;
        const double half2 = (1 + c) / 2, d = half2 * (k_alpha * k_alpha - 1) + 1;
        const double lobe = k_alpha * k_alpha / (d * d) * c;
        if (lobe < 1e-3) continue;
        const double weight = lobe * pixel_solid_angle(v, low.width, low.height);
        sum = sum + low.colour(u, v) * weight;
        all += weight;
      }
    pixels.push_back(sum * (1 / all));
  }
  return pixels;
}

double rms_distance(const std::vector<Vec3>& a, const std::vector<Vec3>& b) {
  double squares = 0;
  for (size_t i = 0; i < a.size(); ++i) {
    const Vec3 d = {srgb_of(a[i].x) - srgb_of(b[i].x), srgb_of(a[i].y) - srgb_of(b[i].y),
                    srgb_of(a[i].z) - srgb_of(b[i].z)};
    squares += dot(d, d) / 3;
  }
  return std::sqrt(squares / static_cast<double>(a.size()));
}

enum Map { k_exact, k_everything, k_turn, k_parts, k_clipped, k_turned, k_maps };
constexpr std::array<const char*, k_maps> k_names = {
    "cube, every texel seen exactly", "cube, a session that sees everything",
    "cube, a session of one turn",    "the 512 parts, everything seen",
    "cube of clipped images",         "cube, turned by 90 degrees"};

}  // namespace

std::vector<Verdict> verify_reflections(const std::vector<RadianceMap>& rooms, uint64_t seed,
                                        const std::function<bool()>& go_on) {
  double sums[k_maps] = {};
  for (size_t i = 0; i < rooms.size(); ++i) {
    if (!go_on()) return {};
    const double gain = k_mean_shown / mean_of(rooms[i]);
    const RadianceMap room = times(rooms[i], [gain](double x) { return x * gain; });
    SessionOptions options;
    options.azimuth = 2 * std::numbers::pi * random_stream(i, 77 + seed).uniform();
    options.seed = mix_bits(seed + 1000 * i);
    options.reflections = true;
    const SeenRoom everything = look_around(room, Session::everything_shorter, options);
    SeenRoom parts = everything;
    parts.texels = std::make_shared<std::vector<RoomTexel>>(k_cube_texels);
    parts.room.texels = parts.texels->data();
    RadianceMap turned(room.width, room.height);
    for (int v = 0; v < room.height; ++v)
      for (int u = 0; u < room.width; ++u) turned.set(u, v, room.colour((u + room.width / 4) % room.width, v));
    const RadianceMap clipped = times(room, [](double x) { return std::min(x, 1.0); });
    const std::array<RadianceMap, k_maps> maps = {cube_of(seen_exactly(room, everything)).map(),
                                                  cube_of(everything).map(),
                                                  cube_of(look_around(room, Session::full_turn_shorter, options)).map(),
                                                  cube_of(parts).map(),
                                                  cube_of(clipped).map(),
                                                  cube_of(turned).map()};
    const std::vector<Vec3> truth = ball(room, options.azimuth);
    for (size_t map = 0; map < k_maps; ++map)
      sums[map] += rms_distance(ball(maps[map], options.azimuth), truth) / static_cast<double>(rooms.size());
  }
  std::vector<Verdict> rows;
  // Half of what clipped images reach is 0.05.
  constexpr double k_reported = std::numeric_limits<double>::infinity();
  constexpr std::array<double, k_maps> k_limits = {0.012, 0.05, k_reported, k_reported, 0.05, 0.05};
  for (size_t map = 0; map < k_maps; ++map) {
    const bool within = sums[map] <= k_limits[map], control = map >= k_clipped;
    rows.push_back({"reflections", std::string(k_names[map]) + ", alpha 0.04", "rmse", 0.0, sums[map], k_limits[map],
                    control ? !within : within, control});
  }
  return rows;
}

}  // namespace sandglass::host
