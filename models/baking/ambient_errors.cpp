// Two truths of each texel are traced with rays of their own. The product of a result's differences to both has no part
// of their noise on average, unlike a square.
#include "models/baking/ambient_errors.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <functional>

#include "models/baking/light_cells.h"
#include "models/baking/shadow_runner.h"
#include "models/baking/validate.h"
#include "models/rooms/panorama_file.h"
#include "models/rooms/room_render.h"
#include "models/work/random.h"

namespace sandglass::host {
namespace {

constexpr uint32_t k_rays = 128, k_stride = 2;  // rays of one truth; one texel in 2 x 2 is looked at
constexpr uint32_t k_methods = 4;               // errors of a room
constexpr uint64_t k_first_room = 770'000;
constexpr int k_room_width = 128, k_room_paths = 8;
constexpr double k_lift = 1e-5;  // of the object's size: a face in the plane hides nothing
using Cells = std::array<double, SANDGLASS_LIGHT_CELLS>;

// The share of the room's light that reaches places of one texel.
double trace_texel(const EmbreeScene& object, const FloorSquare& square, const Environment& room, uint32_t texel,
                   uint32_t rays, uint64_t random) {
  uint32_t free = 0;
  const double step = 2 * square.half / square.side;
  for (uint32_t i = 0; i < rays; ++i) {
    double at[5];
    for (double& x : at) {
      random = random_mix(random);
      x = random_unit(random);
    }
    const Vec3 d = room.direction((i + at[0]) / rays, at[1], at[2]);
    const Vec3 from = {step * (texel % square.side + at[3]) - square.half, k_lift,
                       step * (texel / square.side + at[4]) - square.half};
    free += object.occluded(from, d, INFINITY) ? 0 : 1;
  }
  return static_cast<double>(free) / rays;
}

std::vector<uint8_t> texture_of(std::span<const uint8_t> file, const Cells& cells) {
  ShadowRunner runner(file, "baked", SANDGLASS_ISA_AUTOMATIC, SANDGLASS_SHADOW_ADAPTIVE);
  return runner.ambient(cells);
}

Cells uniform_cells() {
  Cells cells;
  cells.fill(1.0 / SANDGLASS_LIGHT_CELLS);
  return cells;
}

}  // namespace

AmbientErrors measure_ambient(const AmbientCandidate& candidate, std::span<const Environment> rooms, uint64_t seed,
                              ThreadPool& pool) {
  const FloorSquare& square = candidate.square;
  std::vector<uint32_t> texels;
  for (uint32_t v = 0; v < square.side; v += k_stride)
    for (uint32_t u = 0; u < square.side; u += k_stride) {
      const uint64_t pick = random_mix(seed + v * square.side + u) % (k_stride * k_stride);
      texels.push_back((v + static_cast<uint32_t>(pick / k_stride)) * square.side + u +
                       static_cast<uint32_t>(pick % k_stride));
    }
  const std::vector<uint8_t> occlusion = texture_of(candidate.file, uniform_cells());
  std::vector<std::array<double, k_methods>> errors(rooms.size());
  pool.run(static_cast<uint32_t>(rooms.size()), [&](uint32_t r) {
    const Environment& room = rooms[r];
    const std::vector<uint8_t> shipped = texture_of(candidate.file, room.cells());
    std::array<double, k_methods> squares = {};
    for (const uint32_t texel : texels) {
      double truth[2], left = 1;
      for (uint32_t half = 0; half < 2; ++half)
        truth[half] = trace_texel(candidate.object, square, room, texel, k_rays,
                                  random_mix(seed ^ (uint64_t{2} * r + half + 1)) + uint64_t{texel} * 1'000'003);
      for (uint32_t i = 0; i < SANDGLASS_LIGHT_CELLS; ++i)
        left -= room.cells()[i] * static_cast<double>(candidate.hidden[size_t{texel} * SANDGLASS_LIGHT_CELLS + i]);
      const double results[k_methods] = {1, occlusion[texel] / 255.0, left, shipped[texel] / 255.0};
      for (uint32_t m = 0; m < k_methods; ++m) squares[m] += (results[m] - truth[0]) * (results[m] - truth[1]);
    }
    for (uint32_t m = 0; m < k_methods; ++m)
      errors[r][m] = std::sqrt(std::max(0.0, squares[m] / static_cast<double>(texels.size())));
  });
  AmbientErrors mean;
  mean.rooms = static_cast<uint32_t>(rooms.size());
  double* const means[k_methods] = {&mean.none, &mean.occlusion, &mean.cells, &mean.shipped};
  for (const auto& of_room : errors)
    for (uint32_t m = 0; m < k_methods; ++m) *means[m] += of_room[m] / static_cast<double>(rooms.size());
  return mean;
}

std::vector<float> trace_ambient(const EmbreeScene& object, const FloorSquare& square, const Environment& room,
                                 uint32_t rays, uint64_t seed, ThreadPool& pool) {
  std::vector<float> left(size_t{square.side} * square.side);
  pool.run(square.side, [&](uint32_t v) {
    for (uint32_t texel = v * square.side; texel < (v + 1) * square.side; ++texel)
      left[texel] = static_cast<float>(
          trace_texel(object, square, room, texel, rays, random_mix(seed) + uint64_t{texel} * 1'000'003));
  });
  return left;
}

std::vector<Environment> made_up_environments(uint32_t count, uint32_t threads) {
  std::vector<Environment> rooms;
  for (uint32_t i = 0; i < count; ++i)
    rooms.emplace_back(trace_room(make_room(k_first_room + i), {k_room_width, k_room_paths, threads}).radiance);
  return rooms;
}

std::vector<Environment> captured_environments(const std::string& folder) {
  std::vector<std::string> paths;
  std::error_code error;
  for (const auto& entry : std::filesystem::directory_iterator(folder + "/hdri/indoor", error))
    if (entry.path().extension() == ".hdr") paths.push_back(entry.path().string());
  std::sort(paths.begin(), paths.end());
  std::vector<Environment> rooms;
  for (const std::string& path : paths) rooms.emplace_back(read_panorama(path));
  return rooms;
}

std::vector<Picture> ambient_pictures(const AmbientCandidate& candidate, std::span<const Environment> rooms,
                                      ThreadPool& pool) {
  constexpr uint32_t k_picture_rays = 256;
  std::vector<Picture> pictures;
  for (size_t r = 0; r < rooms.size(); ++r) {
    const std::vector<float> truth =
        trace_ambient(candidate.object, candidate.square, rooms[r], k_picture_rays, r, pool);
    std::vector<float> drawn;
    for (const uint8_t byte : texture_of(candidate.file, rooms[r].cells())) drawn.push_back(byte / 255.0f);
    append_compared(
        truth, drawn, candidate.square.side,
        {"ray traced, light of made-up room " + std::to_string(r + 1), "ambient shadow, as drawn", "difference x 8"},
        &pictures);
  }
  return pictures;
}

}  // namespace sandglass::host
