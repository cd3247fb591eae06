// `sandglass_lab bench lighting`: time, memory and error of one estimate of the lighting network, by every back end of this
// build; and what a room costs. All back ends run the same file on the same images, on one thread, through the API that an
// app calls.
#include <algorithm>
#include <cstdio>

#include "models/files/aligned_bytes.h"
#include "models/files/atomic_file.h"
#include "models/files/failure.h"
#include "models/lighting/excerpts.h"
#include "models/lighting/light_runner.h"
#include "models/lighting/room_light.h"
#include "models/rooms/excerpt.h"
#include "models/work/random.h"
#include "runtime/light/camera/camera_image.h"
#include "runtime/light/network/backends.h"
#include "runtime/light/room/room.h"
#include "sandglass/sandglass.hpp"
#include "tests/camera_picture.h"
#include "tests/laboratory/bench.h"
#include "tests/laboratory/cpu_time.h"

namespace sandglass::host {

namespace {

constexpr uint32_t k_repeats = 25;  // the best counts: the machine may be shared

// ---- the network

constexpr uint32_t k_width = 256, k_height = 192;
constexpr double k_macs = 2.549e9;  // with pooling before the transitions' convolutions, and with the heads

struct BackEnd {
  const char* name;
  sandglass_estimator_backend backend;
  // CPU time of the thread, of an estimate and of the longest work unit; weights and activations: the block, and what
  // XNNPACK holds of its region.
  double ms = 1e30, longest_unit_ms = 0, arena_bytes = 0;
  std::vector<LightValues> estimates = {};  // of each image
};

// Without a camera pose, directions are in the world's axes: x right, y up, z backward.
LightValues values_of(const sandglass_estimator_light& e) {
  return {e.direction[0], -e.direction[1], -e.direction[2], e.light[0],   e.light[1],
          e.light[2],     e.ambient[0],    e.ambient[1],    e.ambient[2], e.contrast};
}

// The longest of the work units' best times.
double longest_unit(std::span<const uint8_t> file, const std::string& name, sandglass_isa isa,
                    sandglass_estimator_backend backend, std::span<const uint8_t> rgb) {
  LightRunner runner(file, name, isa, k_width, k_height, backend);
  LightNetwork* net = runner.network();
  std::vector<double> best(net->units, 1e30);
  for (uint32_t repeat = 0; repeat < k_repeats && !(repeat > 0 && interrupted()); ++repeat) {
    begin_light_network(net, rgb.data());
    for (uint32_t unit = 0; unit < net->units; ++unit) {
      const double from = cpu_ms_now();
      run_light_unit(net, unit);
      best[unit] = std::min(best[unit], cpu_ms_now() - from);
    }
  }
  return *std::max_element(best.begin(), best.end());
}

// The time of an estimate as an app would see it: of the first image.
void measure_back_end(std::span<const uint8_t> file, const std::string& name, sandglass_isa isa,
                      const LightBackend* found, const std::vector<Picture>& images, BackEnd* of) {
  const AlignedBytes aligned(file);
  sandglass_estimator_desc desc = estimator_desc();
  desc.asset = aligned.data();
  desc.asset_bytes = file.size();
  desc.isa = isa;
  desc.backend = of->backend;
  desc.smoothing = desc.interval = 0;
  Estimator light;
  if (const Status status = light.create(desc); !status) throw cannot("read", name, status.reason);
  uint64_t bytes = 0;
  if (sandglass_estimator_bytes(&desc, &bytes, nullptr) != SANDGLASS_OK) return;  // cannot be
  of->arena_bytes = static_cast<double>(bytes + (found == nullptr ? 0 : found->bytes_beside()));
  for (const Picture& picture : images) {
    if (interrupted()) return;
    const sandglass_camera_image image = camera_image_of(picture, k_excerpt_fov_deg);
    for (uint32_t repeat = 0; repeat < (&picture == &images[0] ? k_repeats : 1); ++repeat) {
      if (sandglass_estimator_set_image(light.get(), &image, nullptr, nullptr) != SANDGLASS_OK) return;  // cannot be
      const double begin = cpu_ms_now();
      sandglass_estimator_run(light.get(), UINT32_MAX);
      of->ms = std::min(of->ms, cpu_ms_now() - begin);
    }
    sandglass_estimator_light latest = light.light();
    sandglass_estimator_get_latest(light.get(), &latest);  // the filter rejects what contradicts the image before
    of->estimates.push_back(values_of(latest));
  }
  of->longest_unit_ms = longest_unit(file, name, isa, of->backend, images[0].rgb);
}

void measure_network(Bench* bench) {
  const std::string asset = SANDGLASS_LIGHTS_DIR "/room.light";
  const std::string content = read_file(asset, "lighting network", k_asset_limit);
  const std::span<const uint8_t> file(reinterpret_cast<const uint8_t*>(content.data()), content.size());
  std::vector<Picture> images;
  std::vector<LightValues> truth;
  for (const Excerpt& excerpt : read_excerpts(SANDGLASS_LIGHTING_DIR "/excerpts")) {
    images.emplace_back(static_cast<int>(k_width), static_cast<int>(k_height), Colour{0, 0, 0}).rgb = excerpt.rgb;
    truth.push_back(excerpt.values);
  }
  std::printf("%-13s %8s %8s %11s %17s %10s\n", "case", "ms", "GMAC/s", "arena, MiB", "longest unit, ms", "to float");
  for (BackEnd b : {BackEnd{"int8", SANDGLASS_ESTIMATOR_BACKEND_OWN},
                    BackEnd{"xnnpack_f32", SANDGLASS_ESTIMATOR_BACKEND_XNNPACK_F32},
                    BackEnd{"xnnpack_int8", SANDGLASS_ESTIMATOR_BACKEND_XNNPACK_INT8}}) {
    const LightBackend* found = nullptr;
    if (!find_light_backend(b.backend, &found, nullptr)) {
      std::puts("XNNPACK is not in this build: its rows are left out");
      break;
    }
    measure_back_end(file, asset, bench->isa, found, images, &b);
    if (interrupted()) return;
    const LightDifference off = median_difference(b.estimates, truth);
    std::printf("%-13s %8.2f %8.1f %11.2f %17.3f %5.2f deg, %.4f\n", b.name, b.ms, k_macs / b.ms * 1e-6,
                b.arena_bytes / (1 << 20), b.longest_unit_ms, off.angle_deg, off.other);
    bench->keep(b.name, "ms", "ms", b.ms);
    bench->keep(b.name, "gmac_per_s", "GMAC/s", k_macs / b.ms * 1e-6);
    bench->keep(b.name, "arena_bytes", "B", b.arena_bytes);
    bench->keep(b.name, "longest_unit_ms", "ms", b.longest_unit_ms);
    bench->keep(b.name, "angle_to_f32", "deg", off.angle_deg);
    bench->keep(b.name, "difference_to_f32", "1", off.other);
  }
  std::puts("to float: medians over 56 excerpts of made-up rooms, against the float network behind the file");
}

// ---- the room

// A camera that turns once about itself, and sees the same grain everywhere.
void measure_room(Bench* bench) {
  constexpr uint32_t k_images = 24, k_columns = 640, k_rows = 480;
  std::vector<uint8_t> pixels(size_t{3} * k_columns * k_rows);
  for (size_t i = 0; i < pixels.size(); ++i) pixels[i] = static_cast<uint8_t>(64 + 120 * random_unit(i));
  sandglass_camera_image image = tests::camera_picture(pixels.data(), k_columns, k_rows, 520.0f);
  decltype(sandglass_room::room) room = {};
  room.half_life = 180;
  room.interval_ns = 100'000'000;
  std::printf("\n%-26s %8s\n", "room, 640 x 480", "ms");
  const auto tell = [&](const std::string& name, double ms) {
    if (interrupted()) return;
    std::printf("%-26s %8.3f\n", name.c_str(), ms);
    bench->keep("room, " + name, "ms", "ms", ms, 1, "portable");
  };
  for (const bool exposure_known : {true, false}) {
    double best = 1e30;
    image.exposure = exposure_known ? 1.0f : 0.0f;
    for (uint32_t i = 0; i < k_repeats * k_images && !interrupted(); ++i) {
      const float axis[3] = {0, 1, 0};
      (void)sandglass_rotation_about(axis, 0.2618f * static_cast<float>(i % k_images), image.orientation);
      image.timestamp_ns = 1 + 200'000'000ull * (i % k_images);
      if (i % k_images == 0) room_reset(&room);
      const double from = cpu_ms_now();
      (void)room_take_image(&room, image);
      while (room.phase != RoomPhase::idle) room_run_unit(&room);
      if (i % k_images != 0) best = std::min(best, cpu_ms_now() - from);  // the first image finds no exposure
    }
    tell(exposure_known ? "image, exposure told" : "image, exposure not told", best);
  }
  const sandglass_room_place place = {sizeof place, {0.5f, -0.5f, -1.0f}, nullptr, nullptr, nullptr, nullptr, nullptr};
  sandglass_room_light light = {};
  light.struct_size = sizeof light;
  double best = 1e30;
  for (uint32_t repeat = 0; repeat < k_repeats; ++repeat) {
    const double from = cpu_ms_now();
    room_estimate(room, k_room_model, place, &light);
    best = std::min(best, cpu_ms_now() - from);
  }
  tell("light at a place", best);
  std::printf("%.1f KiB\n", static_cast<double>(sizeof(sandglass_room)) / 1024);
}

void measure(const BenchOptions&, Bench* bench) {
  measure_network(bench);
  if (!interrupted()) measure_room(bench);
}

Options options_of(BenchOptions& o) { return {isa_option(o.isa), json_option(o.json)}; }

}  // namespace

Command bench_lighting_suite() {
  return bench_command("lighting", "The lighting network: one estimate by every back end", options_of, measure,
                       Bench::Kernels::bytes);
}

}  // namespace sandglass::host
