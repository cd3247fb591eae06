// `sandglass_lab verify lighting`: estimates of the light against labels and baselines, on panoramas of real rooms.
#include <cstdio>
#include <memory>

#include "models/compositing/light_estimate.h"
#include "models/files/atomic_file.h"
#include "models/lighting/dataset.h"
#include "models/lighting/light_runner.h"
#include "models/lighting/lit_view.h"
#include "tests/laboratory/light/verify_lighting.h"
#include "tests/laboratory/verify.h"

namespace sandglass::host {

namespace {

constexpr const char* k_cross_validated = SANDGLASS_LIGHTING_DIR "/cross_validated_estimates.csv";

struct LightingOptions : VerifyOptions {
  std::string estimates;
};

// What is measured. By default, the data folder's places are measured with their cross-validated estimates, because the
// shipped network was fitted to them. Panoramas that are named are measured with the shipped network.
struct LightingSources {
  std::vector<std::string> panoramas;
  std::string manifest, estimates, network;
};

LightingSources lighting_sources(const LightingOptions& options) {
  LightingSources s = {panoramas_of(options, "lighting"), manifest_of(options), options.estimates, options.network};
  const bool own = options.panoramas.empty();
  if (s.estimates.empty() && s.network.empty())
    (own ? s.estimates : s.network) = own ? k_cross_validated : shipped_light_network();
  return s;
}

LightEstimator estimator_of(const LightingSources& sources) {
  if (sources.network.empty())
    return estimates_of_csv(read_file(sources.estimates, "estimates", k_text_limit), sources.estimates);
  const std::string bytes = read_file(sources.network, "lighting network", k_asset_limit);
  const auto runner = std::make_shared<LightRunner>(
      std::span(reinterpret_cast<const uint8_t*>(bytes.data()), bytes.size()), sources.network);
  return [runner](const Picture& image, const std::string&) {
    const auto vector = [](const float(&v)[3]) { return Vec3{v[0], v[1], v[2]}; };
    const LightOutputs o = runner->run(image.rgb);
    return LightLabels{normalised(vector(o.direction)), vector(o.light), vector(o.ambient), o.contrast, true};
  };
}

// Says so if the shipped network runs on places that it was fitted to.
void tell_of_training(const LightingSources& sources) {
  const std::string shipped = shipped_light_network();
  if (sources.network.empty() || shipped.empty() ||
      read_file(sources.network, "lighting network", k_asset_limit) !=
          read_file(shipped, "lighting network", k_asset_limit))
    return;
  const std::string fitted = read_file(k_cross_validated, "estimates", k_text_limit);
  size_t known = 0;
  for (const std::string& path : sources.panoramas)
    known += fitted.find("\n" + stem_of(path) + "_0.png,") != std::string::npos;
  if (known > 0)
    std::printf(
        "%zu of %zu panoramas are of places that the network was fitted to: what it does there is no test. Of places "
        "that it never saw `sandglass_lab verify lighting` on the data folder has the cross-validated estimates.\n",
        known, sources.panoramas.size());
}

Options options_of(LightingOptions& o) {
  return {panoramas_option(o),
          manifest_option(o),
          standard("the shipped one for --panoramas", {"--network", &o.network, "FILE", "Network that estimates"}),
          excludes("--network",
                   standard("the cross-validated ones for SANDGLASS_DATA_DIR",
                            {"--estimates", &o.estimates, "FILE", "Estimates of all views, as train.py writes them"})),
          seed_option(o.seed, "Where the cameras look"),
          threads_option(o.threads),
          json_option(o.json)};
}

int run(const LightingOptions& options) {
  const LightingSources sources = lighting_sources(options);
  const bool in_bytes = !sources.network.empty();
  const LightingVerdictOptions lighting = {.panoramas = sources.panoramas,
                                           .manifest = sources.manifest,
                                           .estimator = estimator_of(sources),
                                           .seed = options.seed + 1,
                                           .threads = options.threads};
  tell_of_training(sources);
  const std::vector<Verdict> rows = verify_lighting(lighting);
  if (interrupted()) return k_exit_interrupted;
  std::printf("estimates: %s\n", in_bytes ? sources.network.c_str() : sources.estimates.c_str());
  return tell(options, "lighting", in_bytes ? "int8" : "f32", rows);
}

}  // namespace

Command verify_lighting_suite() {
  return command<LightingOptions>("lighting", "Light: estimates against labels and baselines", options_of, run);
}

}  // namespace sandglass::host
