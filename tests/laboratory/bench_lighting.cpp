// `sandglass_lab bench lighting`: time, memory and error of one estimate of the lighting network, by every back end.
#include <cstdio>

#include "models/files/atomic_file.h"
#include "models/lighting/excerpts.h"
#include "tests/laboratory/bench.h"
#include "tests/laboratory/light/lighting_bench.h"
#include "tests/laboratory/room/room_bench.h"

namespace sandglass::host {

namespace {

void print_and_keep(const LightingBench& result, Bench* bench) {
  std::printf("%-13s %8s %8s %11s %17s %10s\n", "case", "ms", "GMAC/s", "arena, MiB", "longest unit, ms", "to float");
  for (const LightingBenchRow& r : result.rows) {
    char to_float[32] = "-";
    if (result.compared) std::snprintf(to_float, sizeof to_float, "%5.2f deg, %.4f", r.angle_deg, r.difference);
    std::printf("%-13s %8.2f %8.1f %11.2f %17.3f %s\n", r.name.c_str(), r.ms, r.gmac_per_s, r.arena_bytes / (1 << 20),
                r.longest_unit_ms, to_float);
    bench->keep(r.name, "ms", "ms", r.ms);
    bench->keep(r.name, "gmac_per_s", "GMAC/s", r.gmac_per_s);
    bench->keep(r.name, "arena_bytes", "B", r.arena_bytes);
    bench->keep(r.name, "longest_unit_ms", "ms", r.longest_unit_ms);
    if (result.compared) {
      bench->keep(r.name, "angle_to_f32", "deg", r.angle_deg);
      bench->keep(r.name, "difference_to_f32", "1", r.difference);
    }
  }
}

void print_and_keep(const RoomBench& room, Bench* bench) {
  std::printf("\n%-26s %8s\n", "room, 640 x 480", "ms");
  for (const RoomBenchRow& r : room.rows) {
    std::printf("%-26s %8.3f\n", r.name.c_str(), r.ms);
    bench->keep("room, " + r.name, "ms", "ms", r.ms, 1, "portable");
  }
  std::printf("%.1f KiB\n", static_cast<double>(room.bytes) / 1024);
}

void measure(const BenchOptions&, Bench* bench) {
  const std::string asset = SANDGLASS_LIGHTS_DIR "/room.light";
  const std::string content = read_file(asset, "lighting network", k_asset_limit);
  const std::vector<Excerpt> excerpts = read_excerpts(SANDGLASS_LIGHTING_DIR "/excerpts");
  const LightingBench result = with_progress("measuring", [&](const auto& go_on) {
    return bench_lighting(std::span(reinterpret_cast<const uint8_t*>(content.data()), content.size()), asset,
                          bench->isa, excerpts, go_on);
  });
  print_and_keep(result, bench);
  if (result.compared)
    std::puts("to float: medians over 56 excerpts of made-up rooms, against the float network behind the file");
  if (!result.has_xnnpack) std::puts("XNNPACK is not in this build: its rows are left out");
  if (!interrupted()) print_and_keep(bench_room(), bench);
}

Options options_of(BenchOptions& o) { return {isa_option(o.isa), json_option(o.json)}; }

}  // namespace

Command bench_lighting_suite() {
  return bench_command("lighting", "The lighting network: one estimate by every back end", options_of, measure,
                       Bench::Kernels::bytes);
}

}  // namespace sandglass::host
