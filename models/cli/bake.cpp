// `sandglass bake MESH -o FILE`: the soft shadow of a mesh as a network small enough for a phone's frame.
#include <array>
#include <charconv>
#include <cstdio>
#include <thread>

#include "models/cli/commands.h"
#include "models/cli/options.h"
#include "models/host/atomic_file.h"
#include "models/host/failure.h"
#include "models/host/measurement_json.h"
#include "models/host/mesh/generated.h"
#include "models/host/progress.h"
#include "models/shadow/bake.h"

namespace sandglass::host {

namespace {

constexpr int k_exit_interrupted = 130;

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

double degrees(const std::string& text, const char* option, double least, double most) {
  double value = 0;
  std::string_view unit;
  if (!number_at(text, &value, &unit) || !(unit.empty() || unit == "deg") || !(value >= least && value <= most))
    throw Failure(std::string(option) + " '" + text + "' is not an angle in " +
                  std::to_string(static_cast<int>(least)) + ".." + std::to_string(static_cast<int>(most)) +
                  " degrees; write 20deg, say");
  return value;
}

NetworkShape network_shape(const std::string& text) {
  NetworkShape shape;
  std::string_view layers, nothing;
  const bool read = number_at(text, &shape.width, &layers) && layers.starts_with('x') &&
                    number_at(layers.substr(1), &shape.layers, &nothing) && nothing.empty();
  if (!read || shape.width < 8 || shape.width > 256 || shape.layers < 1 || shape.layers > 8)
    throw Failure("--size '" + text +
                  "' is not WIDTHxLAYERS with 8..256 neurons and 1..8 layers after the first; the usual one is 128x2");
  return shape;
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

}  // namespace

void add_bake_command(Command& program, int* exit_code) {
  const auto options = std::make_shared<Options>();
  BakeSettings& settings = options->settings;
  settings.threads = std::max(1u, std::thread::hardware_concurrency());
  Command command = program.add_subcommand("bake", "Train the soft shadow of a mesh");
  command
      ->add_option("mesh", options->mesh,
                   "A mesh file (y up, metres), or the name of a generated one: chair, trefoil, torus, ...")
      ->required();
  command->add_option("-o,--output", options->output, "File to write")->required();
  command->add_option("--size", options->size, "Neurons a layer x layers after the first")->capture_default_str();
  command->add_option("--angle", options->angle, "Angular diameter of the light")->capture_default_str();
  command->add_option("--max-polar", options->polar, "Largest angle of the light from the zenith")
      ->capture_default_str();
  command->add_option("--plane", options->plane, "fitted to the light, or one fixed square")
      ->check(one_of({"fitted", "fixed"}))
      ->capture_default_str();
  command->add_option("--seed", settings.seed, "Equal seeds give equal files, on CPUs of one instruction set")
      ->capture_default_str();
  command->add_option("--threads", settings.threads, "Threads; the file does not depend on them")
      ->check(range(1u, 256u));
  command->add_option("--steps", settings.steps, "Steps of training")
      ->check(range(1u, 100'000'000u))
      ->capture_default_str();
  command->add_option("--quantised-steps", settings.quantised_steps, "Steps with rounded weights after them")
      ->check(range(0u, 100'000'000u))
      ->capture_default_str();
  command->add_option("--rate", settings.rate, "Rate of learning at the start of training")
      ->check(range(1e-5, 1.0))
      ->capture_default_str();
  command->add_option("--textures", settings.textures, "Rays as for so many whole textures")
      ->check(range(1u, 3000u))
      ->capture_default_str();
  command->add_option("--validation-lights", settings.validation_lights, "Unseen lights that the error is measured on")
      ->check(range(1u, 100'000u))
      ->capture_default_str();
  command->add_option("--picture", options->picture,
                      "Where to draw truth, network and difference for four lights, as a PNG; by default OUTPUT.png");
  command->add_flag("--no-picture", options->no_picture, "Draw none");
  command->add_option("--json", options->json, "Write the measurements to this file");
  command->add_flag("--keep-float", settings.keep_float, "Keep the float network in the file, for sandglass bench");
  command->add_flag("--resume", options->resume,
                    "Go on where an interrupted bake of the same command stopped; from the beginning if none was");
  command->callback([options, exit_code] {
    listen_for_interrupt();
    BakeSettings& s = options->settings;
    s.shape = network_shape(options->size);
    s.angular_diameter = degrees(options->angle, "--angle", 1, 60);
    s.polar_max = degrees(options->polar, "--max-polar", 1, 84);
    s.plane = options->plane == "fixed" ? PlaneRule::fixed : PlaneRule::fitted;
    MeshResult loaded = make_named(options->mesh);
    if (!loaded) loaded = load_mesh(options->mesh);
    if (!loaded) throw Failure(loaded.error);
    require_writable(options->output);
    require_writable(options->output + ".checkpoint");
    if (options->picture.empty()) options->picture = options->output + ".png";
    if (options->no_picture) options->picture.clear();
    for (const std::string& path : {options->picture, options->json})
      if (!path.empty()) require_writable(path);
    const BakeReport r = bake(loaded.mesh, options->mesh, s, options->output, options->picture, options->resume);
    if (r.interrupted) {
      std::printf("interrupted; to go on, repeat the command with --resume\n");
      *exit_code = k_exit_interrupted;
      return;
    }
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
    std::printf("%s: %llu bytes\n", options->output.c_str(), static_cast<unsigned long long>(r.file_bytes));
    if (!options->picture.empty()) std::printf("picture: %s\n", options->picture.c_str());
    if (!options->json.empty()) write_file(options->json, measurements(r, s));
    *exit_code = 0;
  });
}

}  // namespace sandglass::host
