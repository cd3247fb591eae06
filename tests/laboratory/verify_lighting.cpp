// `sandglass_lab verify lighting`: estimates of the light against labels and baselines, on panoramas of real rooms.
#include <cmath>
#include <cstdio>
#include <limits>
#include <memory>
#include <set>

#include "models/compositing/light_estimate.h"
#include "models/files/atomic_file.h"
#include "models/files/failure.h"
#include "models/files/npy.h"
#include "models/lighting/dataset.h"
#include "models/lighting/light_net.h"
#include "models/lighting/light_runner.h"
#include "models/lighting/lit_view.h"
#include "models/mesh/generated.h"
#include "models/program/command_line.h"
#include "models/simulation/simulation.h"
#include "models/work/progress.h"
#include "tests/laboratory/light/turning_camera.h"
#include "tests/laboratory/light/verify_lighting.h"
#include "tests/laboratory/verify.h"
#ifdef SANDGLASS_HAVE_EMBREE
#include "tests/laboratory/light/lighting_floor.h"
#endif

namespace sandglass::host {

namespace {

constexpr const char* k_usual_object = "trefoil";

bool is_float(const std::string& network) { return network.ends_with(".npz"); }

LightLabels labels_of_values(const float* direction, const float* light, const float* ambient, float contrast) {
  const auto vector = [](const float* v) { return Vec3{v[0], v[1], v[2]}; };
  return {normalised(vector(direction)), vector(light), vector(ambient), contrast, true};
}

// The runtime's byte network, or for exported weights (.npz) the slow float network.
LightEstimator estimator_of(const std::string& network, sandglass_isa isa) {
  if (is_float(network)) {
    const auto net = std::make_shared<LightNet>(light_net_of(read_npz(network)));
    return [net](const Picture& image, const std::string&) {
      const LightValues v = light_of(*net, features_of(net->trunk, image.rgb, image.width, image.height));
      return labels_of_values(&v[0], &v[3], &v[6], v[9]);
    };
  }
  const std::string bytes = read_file(network, "lighting network", k_asset_limit);
  const auto runner = std::make_shared<LightRunner>(
      std::span(reinterpret_cast<const uint8_t*>(bytes.data()), bytes.size()), network, isa);
  return [runner](const Picture& image, const std::string&) {
    const LightOutputs o = runner->run(image.rgb);
    return labels_of_values(o.direction, o.light, o.ambient, o.contrast);
  };
}

// What is measured. By default, the data folder's places are measured with their cross-validated estimates, and
// panoramas that are named with the shipped network. The options may name others.
struct LightingSources {
  std::vector<std::string> panoramas;
  std::string manifest, estimates, network;
};

constexpr const char* k_cross_validated = SANDGLASS_LIGHTING_DIR "/cross_validated_estimates.csv";

LightingSources lighting_sources(const VerifyOptions& options) {
  LightingSources s = {options.panoramas, options.manifest, options.estimates, options.network};
  if (options.samples == 0 && options.object != k_usual_object)
    throw Failure("cannot use \"--object\" with \"--samples 0\", which renders nothing. Leave one of them out.");
  const bool own = s.panoramas.empty();
  if (own) {
    const std::string data = data_folder();
    if (data.empty()) throw no_panoramas("lighting");
    s.panoramas = {data + "/hdri/indoor", data + "/hdri/studio"};
    if (s.manifest.empty()) s.manifest = data + "/manifest.csv";
  }
  if (s.estimates.empty() && s.network.empty())
    (own ? s.estimates : s.network) = own ? k_cross_validated : shipped_light_network();
  if (options.isa != "automatic" && (s.network.empty() || is_float(s.network)))
    throw Failure("cannot use \"--isa\" of \"verify lighting\": no network in bytes runs here. Leave it out.");
  return s;
}

// The shipped network was fitted to all places of the cross-validation.
std::string said_of_training(const LightingSources& sources) {
  const std::string shipped = shipped_light_network();
  if (sources.network.empty() || shipped.empty() || is_float(sources.network)) return "";
  if (read_file(sources.network, "lighting network", k_asset_limit) !=
      read_file(shipped, "lighting network", k_asset_limit))
    return "";
  const std::set<std::string> fitted = panoramas_of_estimates(read_file(k_cross_validated, "estimates", k_text_limit));
  const std::vector<std::string> panoramas = find_panoramas(sources.panoramas);
  size_t known = 0;
  for (const std::string& path : panoramas) known += fitted.count(stem_of(path));
  if (known == 0) return "";
  return std::to_string(known) + " of " + std::to_string(panoramas.size()) +
         " panoramas are of places that the network was fitted to: what it does there is no test. Of places that it "
         "never saw `sandglass_lab verify lighting` on the data folder has the cross-validated estimates.\n";
}

// Adds four turns of the camera for each panorama. They show how much the light wanders in the world.
void add_turns(const LightingSources& sources, std::vector<Verdict>* rows) {
  const std::vector<std::string> paths = find_panoramas(sources.panoramas);
  double filtered = 0, latest = 0, labels = 0, fixed = 0, turns = 0;
  Progress progress("turning the camera", paths.size());
  for (size_t i = 0; i < paths.size() && !interrupted(); ++i) {
    const LitPanorama panorama(paths[i]);
    for (int quarter = 0; quarter < 4 && !interrupted(); ++quarter, ++turns) {
      const Turn turn = turn_camera(sources.network, panorama, 0.5 * M_PI * quarter);
      filtered += wander_deg(turn.filtered), latest += wander_deg(turn.latest);
      labels += wander_deg(turn.labels), fixed += wander_deg(turn.fixed);
    }
    progress.done(i + 1);
  }
  const double infinity = std::numeric_limits<double>::infinity();
  const auto report = [&](const char* name, double sum) {
    rows->push_back({"lighting", std::string("camera turns by 90 deg, light wanders: ") + name, "deg", 0.0, sum / turns,
                     infinity, true, false});
  };
  report("labels", labels), report("network, unfiltered", latest), report("fixed to the camera", fixed);
  report("network", filtered);
}

#ifdef SANDGLASS_HAVE_EMBREE
// Adds what the estimates do to an object's shadow on the floor, and gives the table of it.
std::string add_floor(uint32_t threads, LightingVerdicts* verdicts) {
  ThreadPool pool(threads);
  const auto objects = std::make_shared<const std::vector<FloorObject>>(study_objects(data_folder(), &pool));
  const LightingFloor floor = lighting_floor(*verdicts, objects, threads);
  if (floor.rows.empty()) return "";
  for (const Verdict& row : floor_verdicts(floor.rows)) verdicts->rows.push_back(row);
  return drawn_markdown(floor.study, floor.rows);
}
#endif

LightEstimator chosen_estimator(const LightingSources& sources, const VerifyOptions& options) {
  if (!sources.network.empty()) return estimator_of(sources.network, find_isa(options.isa));
  return estimates_of_csv(read_file(sources.estimates, "estimates", k_text_limit), sources.estimates);
}

void write_folder(const std::string& folder, const LightingVerdicts& verdicts, const std::string& said,
                  const std::string& floor) {
  write_file(folder + "/lighting.csv", lighting_csv(verdicts));
  write_file(folder + "/lighting.txt", said + lighting_table(verdicts));
  write_file(folder + "/estimates.csv", estimates_csv(verdicts));
  write_file(folder + "/floor.md", floor);
  write_verdicts(folder, verdicts.rows);
  write_png(folder + "/lighting.png", picture_grid(verdicts.pictures, 8, 4));
}

}  // namespace

int verify_lighting_command(const VerifyOptions& options) {
  const LightingSources sources = lighting_sources(options);
  const bool in_bytes = !sources.network.empty() && !is_float(sources.network);
  LightingVerdictOptions lighting;
  lighting.panoramas = sources.panoramas, lighting.manifest = sources.manifest;
  lighting.views = options.views, lighting.samples = options.samples, lighting.threads = options.threads;
  lighting.estimator = chosen_estimator(sources, options);
  const std::string said = said_of_training(sources);
  std::fputs(said.c_str(), stdout);
  lighting.object = named_mesh(options.object).mesh;
  LightingVerdicts verdicts = verify_lighting(lighting);
  if (interrupted()) return k_exit_interrupted;
  std::printf("%zu views of %zu panoramas, estimates: %s\n\n%s\n", verdicts.views.size(), verdicts.pictures.size(),
              sources.network.empty() ? sources.estimates.c_str() : sources.network.c_str(),
              lighting_table(verdicts).c_str());
#ifdef SANDGLASS_HAVE_EMBREE
  const std::string floor = add_floor(options.threads, &verdicts);
  std::printf("%s\n", floor.c_str());
#else
  const std::string floor;
#endif
  if (in_bytes && !interrupted()) add_turns(sources, &verdicts.rows);
  if (interrupted()) return k_exit_interrupted;
  print_verdicts(verdicts.rows);
  if (!options.json.empty())
    write_file(options.json, measurements_json(measurements_of("lighting", in_bytes ? "int8" : "f32", options.threads,
                                                               verdicts.rows)));
  if (!options.out.empty()) write_folder(options.out, verdicts, said, floor);
  return count_failed(verdicts.rows) > 0 ? k_exit_check_failed : k_exit_done;
}

}  // namespace sandglass::host
