// `sandglass bake MESH -o FILE`: the soft shadow of a mesh as a network small enough for a phone's frame.
#include <array>
#include <cstdio>
#include <thread>

#include "models/baking/bake.h"
#include "models/files/atomic_file.h"
#include "models/files/measurement_json.h"
#include "models/lighting/dataset.h"
#include "models/mesh/generated.h"
#include "models/program/commands.h"
#include "models/work/progress.h"

namespace sandglass::host {

namespace {

struct BakeOptions {
  std::string mesh, output, json;
  BakeSettings settings;
  MeshOptions as_mesh;
  bool quick = false;
};

Options options_of(BakeOptions& o) {
  BakeSettings& s = o.settings;
  s.threads = std::max(1u, std::thread::hardware_concurrency());
  return {
      required({"MESH", &o.mesh, "", "A mesh file, or the name of a generated mesh"}),
      scale_option(o.as_mesh),
      up_option(o.as_mesh),
      output_file(o.output, "Write the shadow to this file, and beside it FILE.png: truth, result and difference"),
      {"--size", &s.shape.width, "N", "Neurons in each layer of the network", whole_number(8, 256)},
      {"--angle", &s.angular_diameter, "DEGREES", "Angular diameter of the light, degrees", number(1, 60)},
      {"--max-polar", &s.polar_max, "DEGREES", "Largest angle of the light from the zenith, degrees", number(1, 84)},
      seed_option(s.seed, "Equal seeds give equal files on CPUs of one instruction set"),
      standard("all of this machine", threads_option(s.threads)),
      {"--quick", &o.quick, "", "A rough shadow in seconds, to see whether mesh and light are what was meant"},
      json_option(o.json),
      {"--keep-float", &s.keep_float, "", "Keep the float network in the file, for `bench shadow`"},
  };
}

void print(const char* name, const ShadowError& e) {
  std::printf("  %-14s %9.4f %9.4f %9.2f %9.4f %12.4f\n", name, e.rmse, e.rmse_max, e.psnr, e.ssim, e.block);
}

std::array<std::pair<const char*, const BakeReport::Stage*>, 5> stages(const BakeReport& r) {
  return {{{"tracing", &r.tracing},
           {"training", &r.training},
           {"rounding", &r.rounding},
           {"validating", &r.validating},
           {"ambient", &r.ambient_stage}}};
}

// The rooms that the ambient shadow was measured in; those without rooms are left out.
std::vector<std::pair<std::string, const AmbientErrors*>> rooms_of(const AmbientReport& r) {
  std::vector<std::pair<std::string, const AmbientErrors*>> all;
  if (r.made_up.rooms > 0) all.emplace_back("made-up", &r.made_up);
  if (r.captured.rooms > 0) all.emplace_back("captured", &r.captured);
  return all;
}

std::string measurements(const BakeReport& r, const BakeSettings& settings) {
  std::vector<Measurement> all;
  const auto keep = [&](const char* name, const char* metric, const char* unit, double value) {
    all.push_back({"bake", name, metric, unit, "", value, settings.threads, {}});
  };
  const Validation& v = r.validation;
  const std::pair<const char*, const ShadowError*> networks[] = {
      {"f32", &v.network_float}, {"int8", &v.network_int8}, {"int8_adaptive", &v.network_adaptive}};
  for (const auto& [name, error] : networks) {
    keep(name, "rmse", "1", error->rmse);
    keep(name, "rmse_max", "1", error->rmse_max);
    keep(name, "psnr", "dB", error->psnr);
    keep(name, "ssim", "1", error->ssim);
    keep(name, "block", "1", error->block);
  }
  keep("validation", "lights", "1", v.lights);
  keep("validation", "whole_textures", "1", v.whole);  // how many textures ssim and block are computed from
  keep("int8", "ms", "ms", r.ms_full);
  keep("int8_adaptive", "ms", "ms", r.ms_adaptive);
  keep("int8_adaptive", "evaluated", "1", v.evaluated);
  for (const auto& [name, error] : rooms_of(r.ambient)) {
    const std::string group = "ambient, " + name;
    keep(group.c_str(), "rooms", "1", error->rooms);
    keep(group.c_str(), "rmse_none", "1", error->none);
    keep(group.c_str(), "rmse_occlusion", "1", error->occlusion);
    keep(group.c_str(), "rmse_cells", "1", error->cells);
    keep(group.c_str(), "rmse", "1", error->shipped);
  }
  keep("ambient", "components", "1", r.ambient.components);
  keep("ambient", "ms", "ms", r.ambient.ms);
  keep("surface", "points", "1", r.ambient.points);
  keep("file", "bytes", "byte", static_cast<double>(r.file_bytes));
  double seconds = 0;
  for (const auto& [name, stage] : stages(r)) seconds += stage->seconds;
  keep("bake", "seconds", "s", seconds);
  for (const auto& [name, stage] : stages(r)) {
    keep(name, "seconds", "s", stage->seconds);
    keep(name, "cpu_seconds", "s", stage->cpu_seconds);
  }
  return measurements_json(all);
}

void print(const AmbientReport& r) {
  if (r.components == 0) return;
  std::printf("ambient shadow of %u components, %.3f ms a texture; surface of %u points\n", r.components, r.ms,
              r.points);
  std::printf("  RMSE in %15s %10s %10s %10s %10s\n", "rooms", "no shadow", "occlusion", "64 cells", "as drawn");
  for (const auto& [name, e] : rooms_of(r))
    std::printf("  %4u %-17s %10.4f %10.4f %10.4f %10.4f\n", e->rooms, name.c_str(), e->none, e->occlusion, e->cells,
                e->shipped);
}

void print_network(const BakeReport& r) {
  const Validation& v = r.validation;
  std::printf("%u unseen lights      RMSE mean       max  PSNR (dB)     SSIM  16x16 block\n", v.lights);
  print("float", v.network_float);
  print("int8", v.network_int8);
  print("int8 adaptive", v.network_adaptive);
  std::printf("SSIM and block: of %u whole textures, evenly among them; the rest: of one texel in 4 x 4 of all\n",
              v.whole);
  std::printf("int8 to float %.4f, adaptive to float %.4f (RMSE); adaptive asks for %.1f %% of the texels\n",
              v.int8_to_float, v.adaptive_to_float, 100 * v.evaluated);
  std::printf("texture: %.2f ms full, %.2f ms adaptive, one thread of this machine\n", r.ms_full, r.ms_adaptive);
}

void print(const BakeReport& r, const BakeSettings& s) {
  print_network(r);
  print(r.ambient);
  std::printf("%-12s %10s %10s   %u thread%s\n", "stage", "wall, s", "CPU, s", s.threads, s.threads == 1 ? "" : "s");
  for (const auto& [name, stage] : stages(r))
    std::printf("  %-10s %10.1f %10.1f\n", name, stage->seconds, stage->cpu_seconds);
}

}  // namespace

static int run(const BakeOptions& options) {
  BakeSettings s = options.settings;
  if (options.quick) make_quick(&s);
  s.ambient.data = data_folder();
  const std::string picture = options.output + ".png";
  require_writable(picture);
  const Mesh mesh = named_mesh({options.mesh, options.as_mesh.units()}).mesh;
  const BakeReport report = bake(mesh, options.mesh, s, options.output, picture);
  if (report.interrupted) return k_exit_interrupted;
  print(report, s);
  std::printf("%s: %llu bytes\n", options.output.c_str(), static_cast<unsigned long long>(report.file_bytes));
  std::printf("picture: %s\n", picture.c_str());
  if (!options.json.empty()) write_file(options.json, measurements(report, s));
  return k_exit_done;
}

Command bake_command() { return command<BakeOptions>("bake", k_bake_help, options_of, run); }

}  // namespace sandglass::host
