#include "tests/laboratory/room/probes.h"

#include <algorithm>
#include <cmath>

#include "runtime/light/harmonics.h"

namespace sandglass::host {

namespace {

constexpr uint32_t k_linear_size = 16, k_bytes_size = 128;
// The main light: what stands out of the ring around it.
constexpr double k_cos_light = 0.9659, k_cos_ring = 0.9063;  // 15 and 25 degrees

// The direction of a place on a face, s to the right and t down in -1..1 (OpenGL 4.6, table 8.19, solved for it).
Vec3 face_direction(int face, double s, double t) {
  const double side = face % 2 == 0 ? 1 : -1;
  if (face < 2) return {side, -t, -side * s};
  if (face < 4) return {s, side, side * t};
  return {side * s, -t, side};
}

// Six faces, one below the other.
RadianceMap faces_of(const RadianceMap& panorama, uint32_t size, uint32_t points, bool mirrored = false) {
  const auto n = static_cast<int>(size), fine = static_cast<int>(points);
  RadianceMap faces(n, 6 * n);
  for (int y = 0; y < faces.height; ++y)
    for (int x = 0; x < n; ++x) {
      Vec3 sum;
      double area = 0;
      for (int k = 0; k < fine * fine; ++k) {
        const double s = 2 * (x + (k % fine + 0.5) / fine) / n - 1, t = 2 * (y % n + (k / fine + 0.5) / fine) / n - 1;
        Vec3 d = face_direction(y / n, s, t);
        const double weight = std::pow(dot(d, d), -1.5);  // solid angle
        if (mirrored) d.x = -d.x;
        sum = sum + look_up(panorama, d) * weight;
        area += weight;
      }
      faces.set(x, y, sum * (1 / area));
    }
  return faces;
}

sandglass_cube linear_cube(const RadianceMap& faces) {
  sandglass_cube cube;
  sandglass_cube_default(&cube);
  cube.format = SANDGLASS_CUBE_RGB32F;
  cube.size = static_cast<uint32_t>(faces.width);
  cube.stride = 3 * static_cast<int32_t>(sizeof(float)) * faces.width;
  for (int face = 0; face < 6; ++face) cube.faces[face] = faces.at(0, face * faces.width);
  return cube;
}

// Exposed as a camera exposes by itself, clipped, and rounded; its exposure is not told.
std::vector<uint8_t> bytes_of(const RadianceMap& faces) {
  const double exposure = exposed_by_itself(faces);
  std::vector<uint8_t> bytes;
  for (size_t i = 0; i < faces.rgb.size(); i += 3) {
    for (size_t c = 0; c < 3; ++c)
      bytes.push_back(srgb_byte(std::min(1.0, static_cast<double>(faces.rgb[i + c]) * exposure)));
    bytes.push_back(255);
  }
  return bytes;
}

sandglass_cube bytes_cube(const std::vector<uint8_t>& bytes, uint32_t size) {
  sandglass_cube cube;
  sandglass_cube_default(&cube);
  cube.format = SANDGLASS_CUBE_RGBA8;
  cube.size = size;
  cube.stride = 4 * static_cast<int32_t>(size);
  for (size_t face = 0; face < 6; ++face) cube.faces[face] = bytes.data() + face * 4 * size * size;
  return cube;
}

// Calls use(direction, radiance, solid angle) for each pixel.
template <class Use>
void over_pixels(const RadianceMap& map, const Use& use) {
  for (int v = 0; v < map.height; ++v)
    for (int u = 0; u < map.width; ++u)
      use(panorama_direction(u, v, map.width, map.height), map.colour(u, v),
          pixel_solid_angle(v, map.width, map.height));
}

struct MainLight {
  Vec3 direction, irradiance;
};

MainLight main_light_of(const RadianceMap& map) {
  MainLight light = {{0, 1, 0}, {}};
  double brightest = -1;
  over_pixels(map, [&](Vec3 d, Vec3 colour, double) {
    if (luminance(colour) > brightest) {
      brightest = luminance(colour);
      light.direction = d;
    }
  });
  for (int round = 0; round < 3; ++round) {
    Vec3 sum;
    over_pixels(map, [&](Vec3 d, Vec3 colour, double area) {
      if (dot(d, light.direction) > k_cos_light) sum = sum + d * (area * std::pow(luminance(colour), 2));
    });
    light.direction = normalised(sum);
  }
  Vec3 ring;
  double ring_area = 0;
  over_pixels(map, [&](Vec3 d, Vec3 colour, double area) {
    const double near = dot(d, light.direction);
    if (near <= k_cos_ring || near >= k_cos_light) return;
    ring = ring + colour * area;
    ring_area += area;
  });
  over_pixels(map, [&](Vec3 d, Vec3 colour, double area) {
    if (dot(d, light.direction) > k_cos_light)
      light.irradiance = light.irradiance + (colour - ring * (1 / ring_area)) * area;
  });
  const Vec3 e = light.irradiance;
  light.irradiance = {std::max(e.x, 0.0), std::max(e.y, 0.0), std::max(e.z, 0.0)};
  return light;
}

void add_light(Vec3 d, Vec3 light, float sh[27]) {
  const double at[3] = {d.x, d.y, d.z}, colour[3] = {light.x, light.y, light.z};
  double y[9];
  harmonic_polynomials(at, y);
  for (size_t j = 0; j < 9; ++j)
    for (size_t c = 0; c < 3; ++c) sh[3 * j + c] += static_cast<float>(k_harmonic_factors[j] * y[j] * colour[c]);
}

sandglass_harmonics harmonics_of(const RadianceMap& map) {
  sandglass_harmonics harmonics;
  sandglass_harmonics_default(&harmonics);
  harmonics.kind = SANDGLASS_HARMONICS_TOTAL;
  over_pixels(map, [&](Vec3 d, Vec3 colour, double area) { add_light(d, colour * area, harmonics.sh); });
  return harmonics;
}

}  // namespace

std::vector<sandglass_room_light> probe_lights(const RadianceMap& panorama, const SeenRoom& turn, bool exposure_known,
                                               Vec3 place) {
  std::vector<sandglass_room_light> lights;
  const auto tell = [&](const Room& seen, const auto& begin) {
    Room room = seen;
    RoomProbe probe = {};
    room.probe = &probe;
    begin(&room);
    while (room_probe_units_left(room) > 0) probe.run(&room);
    sandglass_room_place at;
    sandglass_room_place_default(&at);
    to_floats(place, at.position);
    sandglass_room_light light = {};
    light.struct_size = sizeof light;
    room_estimate(room, k_room_model, at, &light);
    lights.push_back(light);
  };
  const Room fresh = look_around(panorama, Session::nothing, {}).room;
  const auto cube = [&](const sandglass_cube& c) { tell(fresh, [&](Room* room) { room_begin_cube(room, c); }); };
  const auto harmonics = [&](const sandglass_harmonics& h) {
    tell(fresh, [&](Room* room) { room_begin_harmonics(room, h); });
  };

  const RadianceMap linear = faces_of(panorama, k_linear_size, 12), fine = faces_of(panorama, k_bytes_size, 2);
  cube(linear_cube(linear));
  const std::vector<uint8_t> bytes = bytes_of(fine);
  cube(bytes_cube(bytes, k_bytes_size));

  const sandglass_harmonics all = harmonics_of(panorama);
  const MainLight main = main_light_of(panorama);
  sandglass_harmonics ambient = all;
  ambient.kind = SANDGLASS_HARMONICS_AMBIENT;
  add_light(main.direction, main.irradiance * -1, ambient.sh);
  to_floats(main.direction, ambient.main_direction);
  to_floats(main.irradiance, ambient.main_irradiance);
  harmonics(ambient);
  harmonics(all);

  sandglass_cube with_exposure = linear_cube(linear);
  with_exposure.exposure = exposure_known ? 1 : 0;
  tell(turn.room, [&](Room* room) { room_begin_cube(room, with_exposure); });

  const RadianceMap mirrored = faces_of(panorama, k_linear_size, 12, true);
  cube(linear_cube(mirrored));
  sandglass_cube turned = linear_cube(linear);
  turned.orientation[1] = turned.orientation[3] = static_cast<float>(std::sqrt(0.5));
  cube(turned);
  sandglass_harmonics phase = all;
  for (const size_t j : {1u, 3u, 5u, 7u})  // of odd order m
    for (size_t c = 0; c < 3; ++c) phase.sh[3 * j + c] = -phase.sh[3 * j + c];
  harmonics(phase);
  return lights;
}

}  // namespace sandglass::host
