// Writes a small piece of sand, its light and its camera by the names of the kit's uniforms, and the pictures that the
// program draws of it, as JSON. Bytes are hexadecimal; pictures are RGBA from the upper left corner.
#include <cmath>
#include <cstdio>
#include <vector>

#include "models/drawing/sand_layer.h"
#include "models/files/image.h"
#include "models/kit/grain_block.h"

using namespace sandglass::host;

namespace {

constexpr int k_width = 320, k_height = 240;
constexpr double k_focal = 5, k_pixels = k_focal * k_height;
constexpr uint32_t k_side = 46;  // vertices along a side of the mesh, 2 mm apart
constexpr Vec3 k_around = {0.35, 0.4, 0.5}, k_around_by_height = {0.1, 0.05, 0.0}, k_below = {0.12, 0.09, 0.05};

template <class T>
void bytes(const char* name, const std::vector<T>& all) {
  std::printf(",\"%s\":\"", name);
  const auto* first = reinterpret_cast<const uint8_t*>(all.data());
  for (size_t i = 0; i < all.size() * sizeof(T); ++i) std::printf("%02x", first[i]);
  std::printf("\"");
}
void numbers(const char* name, const std::vector<double>& values) {
  std::printf(",\"%s\":", name);
  for (size_t i = 0; i < values.size(); ++i) std::printf("%c%.9g", i == 0 ? '[' : ',', values[i]);
  std::printf("]");
}
std::vector<double> list(Vec3 v) { return {v.x, v.y, v.z}; }

// A hill whose foot is in the floor, in patches of 5 by 5 cells that have blocks of their own. SwiftShader moves
// vertices to sixteenths of a pixel, so these are there already.
SandShape hill(const CameraFrame& camera) {
  SandShape shape;
  for (uint32_t i = 0; i < k_side * k_side; ++i) {
    const uint32_t column = i % k_side, row = i / k_side, patch = (column / 5 + 16 * (row / 5)) * 2654435761u;
    const double x = 0.002 * column - 0.046, z = 0.002 * row - 0.046, e = 0.028 * std::exp(-1250 * (x * x + z * z));
    const double y = e - 0.003 + 0.0015 * std::sin(190 * x);
    const Vec3 normal = normalised(Vec3{2500 * x * e - 0.285 * std::cos(190 * x), 1, 2500 * z * e}) * 127;
    const Vec3 to = Vec3{x, y, z} - camera.eye;
    const double step = dot(to, camera.forward) / k_pixels / 16;
    const auto moved = [&](Vec3 axis) { return axis * (std::round(dot(to, axis) / step) * step - dot(to, axis)); };
    sandglass_skin_vertex v = {};
    to_floats(camera.eye + to + moved(camera.right) + moved(camera.up), v.position);
    for (size_t k = 0; k < 3; ++k) v.normal[k] = static_cast<int8_t>(list(normal)[k]);
    for (size_t k = 0; k < 3; ++k) v.origin[k] = static_cast<uint16_t>(patch >> 8 * k);
    v.hollow = static_cast<uint8_t>(128 - 100 * std::sin(190 * x));
    v.over = static_cast<int16_t>(1e6 * y);
    shape.vertices.push_back(v);
    if (column + 1 == k_side || row + 1 == k_side) continue;
    shape.indices.insert(shape.indices.end(), {i + k_side, i + 1, i, i + 1, i + k_side, i + k_side + 1});
  }
  return shape;
}

// A stream, two particles that fly beside it, and some that lie.
void add_loose(SandShape& shape) {
  shape.particle_radius = 0.004f;
  shape.nozzles = {{{-0.025f, 0.05f, 0.01f}, {0, 0, 0, 1}, 0.006f, 0.8f, 0}};
  shape.loose = {{{-0.026f, 0.035f, 0.012f}, 1, {0, -1.1f, 0}, 0},  {{-0.022f, 0.03f, 0.008f}, 1, {0.1f, -1.2f, 0}, 1},
                 {{-0.03f, 0.02f, 0.007f}, 0.8f, {0, -1.4f, 0}, 2}, {{0.02f, 0.035f, 0}, 1, {1.5f, 0.6f, 0.4f}, 3},
                 {{0.03f, 0.03f, -0.02f}, 0.5f, {-3, 1, 1}, 4},     {{0, 0.001f, 0.04f}, 1, {0, 1, 0}, 5},
                 {{-0.03f, 0.001f, 0.035f}, 0.4f, {0, 1, 0}, 6},    {{0.038f, 0.002f, 0.02f}, 1, {0.6f, 0.8f, 0}, 7},
                 {{0.04f, 0.001f, -0.01f}, 0.7f, {0, 1, 0}, 8},     {{0.01f, 0.025f, 0}, 1, {0.36f, 0.8f, 0.48f}, 9}};
  shape.flying = 5;
}

void picture(const char* name, const SandShape& shape, const SandLight& light, const CameraFrame& camera, int samples) {
  const SandLayer layer(shape, light, camera, {k_width, k_height, samples}, 1);
  std::vector<uint8_t> rgba;
  for (int i = 0; i < k_width * k_height; ++i) {
    int sums[4] = {}, count = samples * samples;
    for (int s = 0; s < count; ++s) {
      const auto& [depth, radiance] = layer.at(i % k_width, i / k_width, s);
      for (int c = 0; c < 3; ++c) sums[c] += srgb_byte(static_cast<double>(radiance[c]));
      sums[3] += std::isinf(depth) ? 0 : 255;
    }
    for (const int sum : sums) rgba.push_back(static_cast<uint8_t>(sum / count));
  }
  bytes(name, rgba);
}

}  // namespace

int main() {
  const Vec3 place = {0.12, 0.2, 0.28}, forward = normalised(Vec3{0, 0.012, 0} - place);
  const Vec3 right = normalised(cross(forward, {0, 1, 0})), up = cross(right, forward);
  const CameraFrame camera = {place, right, up, forward, k_focal};
  SandLight light = {normalised(Vec3{-0.5, 0.75, 0.4}), {1.1, 1.0, 0.85}, {}, {}, {}, {}, {}, 0.3};
  light.around = [](Vec3 n) { return k_around + k_around_by_height * n.y; };
  light.around_below = [](Vec3 n) { return k_below * (0.5 - 0.5 * n.y); };
  light.pile_passed = light.object_passed = light.under_sky = [](Vec3) { return 1.0; };
  const SandShape surface = hill(camera);
  SandShape all = surface, loose;
  add_loose(all);
  add_loose(loose);

  std::printf("{\"flying\":%u,\"size\":[%d,%d]", all.flying, k_width, k_height);
  picture("surface", surface, light, camera, 1);
  picture("loose", loose, light, camera, 1);
  picture("all", all, light, camera, 1);
  picture("smooth", all, light, camera, 2);
  bytes("vertices", all.vertices);
  bytes("indices", all.indices);
  bytes("particles", all.loose);
  bytes("block", sandglass::kit::sand_block(sandglass::kit::k_beach));
  numbers("view", {right.x, up.x, -forward.x, 0, right.y, up.y, -forward.y, 0, right.z, up.z, -forward.z, 0,
                   -dot(right, place), -dot(up, place), dot(forward, place), 1});
  constexpr double k_near = 0.01;  // and nothing is too far
  numbers("projection", {2 * k_pixels / k_width, 0, 0, 0, 0, 2 * k_focal, 0, 0, 0, 0, -1, -1, 0, 0, -2 * k_near, 0});
  numbers("eye", list(place));
  numbers("to_light", list(light.to_light));
  numbers("sun", list(light.sun));
  numbers("ambient", {k_around.x, k_around.y, k_around.z, k_around_by_height.x, k_around_by_height.y, 0});
  numbers("below", list(k_below));
  numbers("table_of_room", {1, 0, 0, 0, 1, 0, 0, 0, 1});
  numbers("wet", {light.wet});
  numbers("block_side", {0.0084});
  numbers("pixels", {k_pixels});
  numbers("particle_radius", {all.particle_radius});
  numbers("frame_seconds", {all.seconds});
  numbers("stream_narrow", {0.3});
  const sandglass_emitter& nozzle = all.nozzles[0];
  numbers("streams", {nozzle.position[0], nozzle.position[1], nozzle.position[2], nozzle.radius});
  numbers("stream_ways", {0, -1, 0, nozzle.speed});
  std::vector<double> minerals;
  float share = 0;
  for (const auto& [albedo, own] : sandglass::kit::k_beach)
    minerals.insert(minerals.end(), {albedo[0], albedo[1], albedo[2], share += own});
  numbers("minerals", minerals);
  std::printf("}\n");
}
