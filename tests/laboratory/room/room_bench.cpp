#include "tests/laboratory/room/room_bench.h"

#include <algorithm>

#include "models/work/progress.h"
#include "models/work/random.h"
#include "runtime/light/camera/camera_image.h"
#include "runtime/light/room/room.h"
#include "sandglass/camera.h"
#include "tests/laboratory/cpu_time.h"

namespace sandglass::host {

namespace {

constexpr uint32_t k_images = 24, k_repeats = 15, k_width = 640, k_height = 480;

// A camera that turns once about itself, and sees the same grain everywhere.
class Turn {
 public:
  Turn() : pixels_(size_t{3} * k_width * k_height) {
    for (size_t i = 0; i < pixels_.size(); ++i) pixels_[i] = static_cast<uint8_t>(64 + 120 * random_unit(i));
    sandglass_camera_image_default(&image_);
    image_.width = k_width;
    image_.height = k_height;
    image_.planes[0] = pixels_.data();
    image_.strides[0] = 3 * k_width;
    image_.focal_x = image_.focal_y = 520.0f;
    image_.centre_x = 319.5f;
    image_.centre_y = 239.5f;
  }
  const sandglass_camera_image& at(uint32_t i, bool told) {
    const float axis[3] = {0, 1, 0};
    (void)sandglass_rotation_about(axis, 0.2618f * static_cast<float>(i), image_.orientation);
    image_.timestamp_ns = 1 + 200'000'000ull * i;
    image_.exposure = told ? 1.0f : 0.0f;
    return image_;
  }

 private:
  std::vector<uint8_t> pixels_;
  sandglass_camera_image image_ = {};
};

RoomBenchRow measured(const std::string& name, bool told, Turn* turn, Room* room) {
  RoomBenchRow row = {name, 1e30};
  for (uint32_t repeat = 0; repeat < k_repeats && !interrupted(); ++repeat) {
    room_reset(room);
    for (uint32_t i = 0; i < k_images; ++i) {
      const double from = cpu_ms_now();
      (void)room_take_image(room, turn->at(i, told));
      while (room->phase != RoomPhase::idle) room_run_unit(room);
      if (i != 0) row.ms = std::min(row.ms, cpu_ms_now() - from);  // the first image finds no exposure
    }
  }
  return row;
}

}  // namespace

RoomBench bench_room() {
  Turn turn;
  Room room = {};
  room.half_life = 180;
  room.interval_ns = 100'000'000;
  room_reset(&room);
  RoomBench bench = {{}, sizeof(sandglass_room)};
  bench.rows.push_back(measured("image, exposure told", true, &turn, &room));
  bench.rows.push_back(measured("image, exposure not told", false, &turn, &room));
  if (interrupted()) return {{}, bench.bytes};
  const sandglass_room_place place = {sizeof place, {0.5f, -0.5f, -1.0f}, nullptr, nullptr, nullptr, nullptr, nullptr};
  sandglass_room_light light = {};
  light.struct_size = sizeof light;
  RoomBenchRow answer = {"light at a place", 1e30};
  for (uint32_t repeat = 0; repeat < k_repeats; ++repeat) {
    const double from = cpu_ms_now();
    room_estimate(room, k_room_model, place, &light);
    answer.ms = std::min(answer.ms, cpu_ms_now() - from);
  }
  bench.rows.push_back(answer);
  return bench;
}

}  // namespace sandglass::host
