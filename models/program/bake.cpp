// `sandglass bake MESH -o FILE`: the soft shadow of a mesh as a network small enough for a phone's frame.
#include <array>
#include <charconv>
#include <cstdio>
#include <thread>

#include "models/baking/bake.h"
#include "models/files/atomic_file.h"
#include "models/laboratory/measurement_json.h"
#include "models/program/command_line.h"
#include "models/program/commands.h"
#include "models/work/progress.h"

namespace sandglass::host {

namespace {

struct Options {
  std::string mesh, output, size = "128x2", angle = "20deg", polar = "70deg", plane = "fitted", picture, json;
  BakeSettings settings;
  bool resume = false, no_picture = false;
};

// The number that `text` begins with, decimal, without sign, and what follows it; false: none, or too large.
template <class Number>
bool number_at(std::string_view text, Number* number, std::string_view* rest) {
  const bool digit = !text.empty() && text[0] >= '0' && text[0] <= '9';
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), *number);
  *rest = text.substr(static_cast<size_t>(end - text.data()));
  return digit && error == std::errc();
}

// "20" or "20deg"
bool read_degrees(const std::string& text, double* value) {
  std::string_view unit;
  return number_at(text, value, &unit) && (unit.empty() || unit == "deg");
}

Check angle(int low, int high) {
  const std::string range = std::to_string(low) + " to " + std::to_string(high) + " degrees";
  return {range,
          "an angle from " + range + ", such as 20deg",
          [low, high](const std::string& text) {
            double value = 0;
            return read_degrees(text, &value) && value >= low && value <= high;
          },
          {}};
}

// "128x2"
bool read_shape(const std::string& text, NetworkShape* shape) {
  std::string_view layers, nothing;
  return number_at(text, &shape->width, &layers) && layers.starts_with('x') &&
         number_at(layers.substr(1), &shape->layers, &nothing) && nothing.empty() && shape->width >= 8 &&
         shape->width <= 256 && shape->layers >= 1 && shape->layers <= 8;
}

Check shape_of_network() {
  return {"8x1 to 256x8",
          "WIDTHxLAYERS with 8 to 256 neurons and 1 to 8 layers, such as 128x2",
          [](const std::string& text) {
            NetworkShape shape;
            return read_shape(text, &shape);
          },
          {}};
}

void print(const char* name, const ShadowError& e) {
  std::printf("  %-14s %9.4f %9.4f %9.2f %9.4f %12.4f\n", name, e.rmse, e.rmse_max, e.psnr, e.ssim, e.block);
}

std::array<std::pair<const char*, const BakeReport::Stage*>, 4> stages(const BakeReport& r) {
  return {
      {{"tracing", &r.tracing}, {"training", &r.training}, {"rounding", &r.rounding}, {"validating", &r.validating}}};
}

std::string measurements(const BakeReport& r, const BakeSettings& settings) {
  std::vector<Measurement> all;
  const auto keep = [&](const char* name, const char* metric, const char* unit, double value) {
    Measurement m;
    m.suite = "bake", m.scene = name, m.metric = metric, m.unit = unit, m.value = value;
    m.threads = settings.threads;
    all.push_back(m);
  };
  const Validation& v = r.validation;
  const std::pair<const char*, const ShadowError*> ways[] = {
      {"f32", &v.network_float}, {"int8", &v.network_int8}, {"int8_adaptive", &v.network_adaptive}};
  for (const auto& [name, error] : ways) {
    keep(name, "rmse", "1", error->rmse);
    keep(name, "rmse_max", "1", error->rmse_max);
    keep(name, "psnr", "dB", error->psnr);
    keep(name, "ssim", "1", error->ssim);
    keep(name, "block", "1", error->block);
  }
  keep("validation", "lights", "1", v.lights);
  keep("validation", "whole_textures", "1", v.whole);  // that ssim and block are of
  keep("int8", "ms", "ms", r.ms_full);
  keep("int8_adaptive", "ms", "ms", r.ms_adaptive);
  keep("int8_adaptive", "evaluated", "1", v.evaluated);
  keep("file", "bytes", "byte", static_cast<double>(r.file_bytes));
  keep("bake", "seconds", "s", r.tracing.seconds + r.training.seconds + r.rounding.seconds + r.validating.seconds);
  for (const auto& [name, stage] : stages(r)) {
    keep(name, "seconds", "s", stage->seconds);
    keep(name, "cpu_seconds", "s", stage->cpu_seconds);
  }
  return measurements_json(all);
}

void print(const BakeReport& r, const BakeSettings& s) {
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
  std::printf("%-12s %10s %10s   %u thread%s\n", "stage", "wall, s", "CPU, s", s.threads, s.threads == 1 ? "" : "s");
  for (const auto& [name, stage] : stages(r))
    std::printf("  %-10s %10.1f %10.1f\n", name, stage->seconds, stage->cpu_seconds);
}

int bake_and_report(Options& options) {
  BakeSettings& s = options.settings;
  read_shape(options.size, &s.shape);
  read_degrees(options.angle, &s.angular_diameter);
  read_degrees(options.polar, &s.polar_max);
  s.plane = options.plane == "fixed" ? PlaneRule::fixed : PlaneRule::fitted;
  const Mesh mesh = named_mesh(options.mesh).mesh;
  require_writable(options.output);
  require_writable(options.output + ".checkpoint");
  if (options.picture.empty()) options.picture = options.output + ".png";
  if (options.no_picture) options.picture.clear();
  for (const std::string& path : {options.picture, options.json})
    if (!path.empty()) require_writable(path);
  const BakeReport report = bake(mesh, options.mesh, s, options.output, options.picture, options.resume);
  if (report.interrupted) {
    std::printf("interrupted; to go on, repeat the command with --resume\n");
    return k_exit_interrupted;
  }
  print(report, s);
  std::printf("%s: %llu bytes\n", options.output.c_str(), static_cast<unsigned long long>(report.file_bytes));
  if (!options.picture.empty()) std::printf("picture: %s\n", options.picture.c_str());
  if (!options.json.empty()) write_file(options.json, measurements(report, s));
  return k_exit_done;
}

void add_options(Command& command, Options& options) {
  BakeSettings& settings = options.settings;
  constexpr uint64_t k_most_steps = 100'000'000;
  command.add("MESH", options.mesh, "A mesh file (y up, metres), or the name of a generated mesh").required();
  command.add("-o,--output FILE", options.output, "Write the shadow to this file").required();
  command.add("--size WxL", options.size, "Size of the network: neurons a layer, and layers after the first")
      .checked(shape_of_network());
  command.add("--angle ANGLE", options.angle, "Angular diameter of the light").checked(angle(1, 60));
  command.add("--max-polar ANGLE", options.polar, "Largest angle of the light from the zenith").checked(angle(1, 84));
  command.add("--plane KIND", options.plane, "Square of the plane: fitted to each light, or one fixed for all")
      .checked(one_of({"fitted", "fixed"}));
  command.add("--seed N", settings.seed, "Equal seeds give equal files on CPUs of one instruction set");
  add_threads(command, settings.threads).by_default("all of this machine");
  command.add("--steps N", settings.steps, "Steps of training").checked(whole_number(1, k_most_steps));
  command.add("--quantised-steps N", settings.quantised_steps, "Further steps with rounded weights")
      .checked(whole_number(0, k_most_steps));
  command.add("--rate X", settings.rate, "Learning rate at the start").checked(number(1e-5, 1));
  command.add("--textures N", settings.textures, "Rays, as many as for this many whole textures")
      .checked(whole_number(1, 3000));
  command.add("--validation-lights N", settings.validation_lights, "Unseen lights that the error is measured on")
      .checked(whole_number(1, 100'000));
  command
      .add("--picture FILE", options.picture, "Draw truth, network and difference for four lights to this file, .png")
      .by_default("OUTPUT.png");
  command.add_flag("--no-picture", options.no_picture, "Draw no picture");
  add_json(command, options.json);
  command.add_flag("--keep-float", settings.keep_float, "Keep the float network in the file, for `bench shadow`");
  command.add_flag("--resume", options.resume, "Go on where an interrupted bake of the same command stopped");
}

}  // namespace

void add_bake_command(Command& program, const std::string& group) {
  const auto options = std::make_shared<Options>();
  options->settings.threads = std::max(1u, std::thread::hardware_concurrency());
  Command& command = program.add_command("bake", "Train the soft shadow of a mesh", group);
  add_options(command, *options);
  command.runs([options] {
    listen_for_interrupt();
    return bake_and_report(*options);
  });
}

}  // namespace sandglass::host
