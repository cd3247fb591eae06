// `sandglass verify SUITE`: claims with their truth, measured now, and wrong settings that must fail them; as a table
// on the terminal, and with --out as CSV, Markdown and curves.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <limits>
#include <set>
#include <utility>

#include "models/cli/commands.h"
#include "models/cli/options.h"
#include "models/host/atomic_file.h"
#include "models/host/failure.h"
#include "models/host/granular_plots.h"
#include "models/host/granular_verdicts.h"
#include "models/host/measurement_json.h"
#include "models/host/mesh/generated.h"
#include "models/host/npz.h"
#include "models/host/physics_cases.h"
#include "models/host/progress.h"
#include "models/host/simulation.h"
#include "models/lighting/dataset.h"
#include "models/lighting/light_net.h"
#include "models/lighting/light_runner.h"
#include "models/lighting/lit_view.h"
#include "models/lighting/turning_camera.h"
#include "models/lighting/verify_lighting.h"
#include "models/shot/light_estimate.h"
#include "models/shot/verify_shot.h"

namespace sandglass::host {

namespace {

constexpr int k_exit_check_failed = 1, k_exit_interrupted = 130;

constexpr const char* k_usual_object = "trefoil";

struct Options {
  std::string suite, json, out, isa = "automatic";
  std::vector<std::string> cases;
  bool quick = false;
  std::vector<std::string> panoramas;
  std::string manifest, estimates, network, object = k_usual_object;
  int views = 8, samples = 48;
  uint32_t threads = 1;
  uint64_t seed = 0;
};

const char* outcome_of(const Verdict& v) {
  if (v.control) return v.pass ? "fails, as it must" : "PASSES, but must fail";
  if (!v.pass) return "FAIL";
  return std::isinf(v.limit) ? "reported" : "pass";
}

std::string number(double value) {
  char text[32];
  if (std::isinf(value)) return "";
  std::snprintf(text, sizeof text, "%.5g", value);
  return text;
}

void print_table(const std::vector<Verdict>& rows) {
  std::printf("%-11s %-32s %11s %11s %11s  %-11s %s\n", "case", "claim", "truth", "result", "limit", "unit", "");
  for (const Verdict& v : rows)
    std::printf("%-11s %-32s %11s %11s %11s  %-11s %s\n", v.group.c_str(), v.name.c_str(), number(v.truth).c_str(),
                number(v.result).c_str(), number(v.limit).c_str(), v.unit.c_str(), outcome_of(v));
}

std::string table_csv(const std::vector<Verdict>& rows) {
  std::string text = "case,claim,unit,truth,result,limit,control,pass\n";
  for (const Verdict& v : rows)
    text += v.group + ",\"" + v.name + "\"," + v.unit + "," + number(v.truth) + "," + number(v.result) + "," +
            number(v.limit) + "," + (v.control ? "1" : "0") + "," + (v.pass ? "1" : "0") + "\n";
  return text;
}

std::string table_markdown(const std::vector<Verdict>& rows) {
  std::string text = "| case | claim | truth | result | limit | unit | |\n|---|---|---|---|---|---|---|\n";
  for (const Verdict& v : rows)
    text += "| " + v.group + " | " + v.name + " | " + number(v.truth) + " | " + number(v.result) + " | " +
            number(v.limit) + " | " + v.unit + " | " + outcome_of(v) + " |\n";
  return text;
}

std::vector<Measurement> measurements_of(const std::string& suite, const std::string& isa, uint32_t threads,
                                         const std::vector<Verdict>& rows) {
  std::vector<Measurement> measurements;
  for (const Verdict& v : rows) {
    Measurement m;
    m.suite = suite, m.scene = v.name, m.metric = "result", m.unit = v.unit, m.isa = isa, m.value = v.result;
    m.threads = threads, m.judgement = Measurement::Judgement{v.truth, v.limit, v.pass, v.control};
    measurements.push_back(m);
  }
  return measurements;
}

void write_folder(const std::string& folder, const VerdictTable& table) {
  make_folder(folder);
  write_file(folder + "/verify.csv", table_csv(table.rows));
  write_file(folder + "/verify.md", table_markdown(table.rows));
  std::string drawn;
  for (const GranularPlot& plot : granular_plots(table.curves)) {
    write_png(folder + "/" + plot.name + ".png", draw_plot(plot.plot));
    drawn += ", " + plot.name + ".png";
  }
  std::printf("%s: verify.csv, verify.md%s\n", folder.c_str(), drawn.c_str());
}

int verify_granular(const Options& options) {
  VerdictChoice choice;
  choice.isa = find_isa(options.isa);
  choice.groups = options.cases;
  choice.quick = options.quick;
  sandglass_scene_desc desc = physics_desc(0.6);
  desc.isa = choice.isa;
  desc.granular.particle_capacity = 1;
  const std::string isa_name = sandglass_isa_name(sandglass_scene_isa(Simulation(desc).handle()));
  VerdictTable table;
  {
    Progress progress("verifying", 1);
    table = granular_verdicts(choice, [&](uint64_t done, uint64_t total) {
      progress.total(total);
      progress.done(done);
      return !interrupted();
    });
  }
  print_table(table.rows);
  uint32_t failed = 0;
  for (const Verdict& v : table.rows) failed += v.pass ? 0 : 1;
  std::printf("%zu rows, %u failed\n", table.rows.size(), failed);
  if (!options.json.empty())
    write_file(options.json, measurements_json(measurements_of("granular", isa_name, 1, table.rows)));
  if (!options.out.empty()) write_folder(options.out, table);
  return interrupted() ? k_exit_interrupted : failed > 0 ? k_exit_check_failed : 0;
}

bool is_float(const std::string& network) { return network.ends_with(".npz"); }

LightLabels labels_of_values(const float* direction, const float* light, const float* ambient, float contrast) {
  const auto vector = [](const float* v) { return Vec3{v[0], v[1], v[2]}; };
  return {normalised(vector(direction)), vector(light), vector(ambient), contrast, true};
}

// The runtime's bytes; of exported weights (.npz) the float network, slowly.
LightEstimator estimator_of(const std::string& network, sandglass_isa isa) {
  if (is_float(network)) {
    const auto net = std::make_shared<LightNet>(light_net_of(read_npz(network)));
    return [net](const Picture& image, const std::string&) {
      const LightValues v = light_of(*net, features_of(net->trunk, image.rgb, image.width, image.height));
      return labels_of_values(&v[0], &v[3], &v[6], v[9]);
    };
  }
  const std::string bytes = read_file(network, "lighting network");
  const auto runner = std::make_shared<LightRunner>(
      std::span(reinterpret_cast<const uint8_t*>(bytes.data()), bytes.size()), network, isa);
  return [runner](const Picture& image, const std::string&) {
    const LightOutputs o = runner->run(image.rgb);
    return labels_of_values(o.direction, o.light, o.ambient, o.contrast);
  };
}

std::string data_folder() {
  const char* data = std::getenv("SANDGLASS_DATA_DIR");
  return data == nullptr ? "" : data;
}

// What is measured where: on the data folder the cross-validated estimates of its places, on panoramas that are named
// the shipped network; or what the options name.
struct LightingSources {
  std::vector<std::string> panoramas;
  std::string manifest, estimates, network;
};

constexpr const char* k_cross_validated = SANDGLASS_LIGHTING_DIR "/cross_validated_estimates.csv";

LightingSources lighting_sources(const Options& options) {
  LightingSources s = {options.panoramas, options.manifest, options.estimates, options.network};
  if (options.samples == 0 && options.object != k_usual_object)
    throw Failure("--object is what is rendered, and --samples 0 renders nothing; leave one of them out");
  const bool own = s.panoramas.empty();
  if (own) {
    const std::string data = data_folder();
    if (data.empty())
      throw Failure(
          "verify lighting needs panoramas; name .hdr or .exr files or folders of them with --panoramas, or the data "
          "folder in SANDGLASS_DATA_DIR");
    s.panoramas = {data + "/hdri/indoor", data + "/hdri/studio"};
    if (s.manifest.empty()) s.manifest = data + "/manifest.csv";
  }
  if (s.estimates.empty() && s.network.empty())
    (own ? s.estimates : s.network) = own ? k_cross_validated : shipped_light_network();
  if (options.isa != "automatic" && (s.network.empty() || is_float(s.network)))
    throw Failure("--isa chooses what runs a network in bytes, and none is run here; leave it out");
  return s;
}

// The shipped network was fitted to all places of the cross-validation.
std::string said_of_training(const LightingSources& sources) {
  const std::string shipped = shipped_light_network();
  if (sources.network.empty() || shipped.empty() || is_float(sources.network)) return "";
  if (read_file(sources.network, "lighting network") != read_file(shipped, "lighting network")) return "";
  const std::set<std::string> fitted = panoramas_of_estimates(read_file(k_cross_validated, "estimates"));
  const std::vector<std::string> panoramas = find_panoramas(sources.panoramas);
  size_t known = 0;
  for (const std::string& path : panoramas) known += fitted.count(stem_of(path));
  if (known == 0) return "";
  return std::to_string(known) + " of " + std::to_string(panoramas.size()) +
         " panoramas are of places that the network was fitted to: what it does there is no test. Of places that it "
         "never saw `sandglass verify lighting` on the data folder has the cross-validated estimates.\n";
}

// Of the panoramas, four turns of the camera each: how much the light wanders in the world.
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

int verify_lighting_suite(const Options& options) {
  const LightingSources sources = lighting_sources(options);
  const bool in_bytes = !sources.network.empty() && !is_float(sources.network);
  LightingVerdictOptions lighting;
  lighting.panoramas = sources.panoramas, lighting.manifest = sources.manifest;
  lighting.views = options.views, lighting.samples = options.samples, lighting.threads = options.threads;
  if (!sources.estimates.empty())
    lighting.estimator = estimates_of_csv(read_file(sources.estimates, "estimates"), sources.estimates);
  if (!sources.network.empty()) lighting.estimator = estimator_of(sources.network, find_isa(options.isa));
  const std::string said = said_of_training(sources);
  std::fputs(said.c_str(), stdout);
  MeshResult mesh = make_named(options.object);
  if (!mesh) mesh = load_mesh(options.object);
  if (!mesh) throw Failure(mesh.error);
  lighting.object = mesh.mesh;
  LightingVerdicts verdicts = verify_lighting(lighting);
  if (interrupted()) return k_exit_interrupted;
  std::printf("%zu views of %zu panoramas, estimates: %s\n\n%s\n", verdicts.views.size(), verdicts.pictures.size(),
              sources.network.empty() ? sources.estimates.c_str() : sources.network.c_str(),
              lighting_table(verdicts).c_str());
  if (in_bytes) add_turns(sources, &verdicts.rows);
  if (interrupted()) return k_exit_interrupted;
  print_table(verdicts.rows);
  uint32_t failed = 0;
  for (const Verdict& v : verdicts.rows) failed += v.pass ? 0 : 1;
  if (!options.json.empty())
    write_file(options.json, measurements_json(measurements_of("lighting", in_bytes ? "int8" : "f32", options.threads,
                                                               verdicts.rows)));
  if (!options.out.empty()) {
    make_folder(options.out);
    write_file(options.out + "/lighting.csv", lighting_csv(verdicts));
    write_file(options.out + "/lighting.txt", said + lighting_table(verdicts));
    write_file(options.out + "/estimates.csv", estimates_csv(verdicts));
    write_file(options.out + "/verify.csv", table_csv(verdicts.rows));
    write_file(options.out + "/verify.md", table_markdown(verdicts.rows));
    write_png(options.out + "/lighting.png", picture_grid(verdicts.pictures, 8, 4));
    std::printf("%s: lighting.csv, lighting.txt, lighting.png, verify.csv, verify.md\n", options.out.c_str());
  }
  return failed > 0 ? k_exit_check_failed : 0;
}

// Where the data folder's indoor panoramas are; empty: nowhere.
std::vector<std::string> indoor_panoramas(const Options& options) {
  if (!options.panoramas.empty()) return find_panoramas(options.panoramas);
  const std::string data = data_folder();
  return data.empty() ? std::vector<std::string>{} : find_panoramas({data + "/hdri/indoor"});
}

// The views of a study, against each ablation; returns how many comparisons are lost.
uint32_t judge_views(const ShotStudy& study, std::vector<Measurement>* measurements) {
  uint32_t failed = 0;
  for (const ShotVariant ablation : {ShotVariant::no_shadow, ShotVariant::hard_shadow, ShotVariant::arbitrary_light})
    for (int m = 0; m < k_shot_metrics; ++m) {
      const bool pass = study.beats(ablation, m);
      if (!pass) std::printf("FAIL: true labels do not beat %s in %s\n", name_of(ablation), shot_metric_name(m));
      failed += pass ? 0 : 1;
      Measurement row;
      row.suite = "shot", row.scene = name_of(ablation), row.metric = shot_metric_name(m), row.isa = "automatic";
      row.value = study.mean[static_cast<int>(ablation)][m];
      row.judgement = Measurement::Judgement{study.mean[0][m], study.mean[0][m], pass, true};
      measurements->push_back(row);
    }
  return failed;
}

uint32_t judge_pile_shadow(const std::vector<PileShadowError>& lights, std::vector<Measurement>* measurements) {
  const PileShadowError whole = whole_of(lights);
  const bool pass = holds(whole);
  if (!pass) std::printf("FAIL: the shadow of the sand\n");
  const std::pair<const char*, const PileShadowError::Part*> parts[] = {
      {"clear floor", &whole.clear}, {"floor among grains", &whole.among_grains}, {"on the sand", &whole.on_sand}};
  for (const auto& [name, part] : parts) {
    Measurement row;
    row.suite = "shot", row.scene = "shadow of the sand, " + std::string(name), row.metric = "RMSE of visibility";
    row.isa = "automatic", row.value = part->rmse;
    row.judgement = Measurement::Judgement{0.0, part->without, pass, false};
    measurements->push_back(row);
  }
  return pass ? 0 : 1;
}

int verify_shot_suite(const Options& options) {
  ShotStudyOptions study;
  study.panoramas = indoor_panoramas(options);
  study.network = options.network.empty() ? shipped_light_network() : options.network;
  study.folder = options.out, study.threads = options.threads, study.seed = options.seed;
  if (options.seed > 0) study.views = study.panoramas.size();
  if (!study.folder.empty()) make_folder(study.folder);
  uint32_t failed = 0;
  std::vector<Measurement> measurements;
  std::string text;
  {
    Progress progress("compositing and tracing views",
                      std::max<size_t>(1, std::min(study.views, study.panoramas.size())));
    const ShotStudy result = study_shots(study, [&](size_t done) {
      progress.done(done);
      return !interrupted();
    });
    if (interrupted()) return k_exit_interrupted;
    if (!result.views.empty()) {
      text = shot_study_text(result) + "\n";
      failed += judge_views(result, &measurements);
    }
  }
  if (study.panoramas.empty())
    std::printf(
        "views skipped: no panoramas; name a folder with --panoramas, or the data folder in "
        "SANDGLASS_DATA_DIR\n\n");
  if (study.network.empty()) std::printf("no lighting network: without estimates\n");
  const std::vector<PileShadowError> pile = study_pile_shadow();
  text += pile_shadow_text(pile);
  failed += judge_pile_shadow(pile, &measurements);
  std::fputs(text.c_str(), stdout);
  if (!study.folder.empty()) write_file(study.folder + "/shot.md", text);
  if (!options.json.empty()) write_file(options.json, measurements_json(measurements));
  return failed > 0 ? k_exit_check_failed : 0;
}

const std::vector<OptionUse> k_uses = {{"--case", {"granular"}},
                                       {"--quick", {"granular"}},
                                       {"--json", {}},
                                       {"--out", {}},
                                       {"--isa", {"granular", "lighting"}},
                                       {"--panoramas", {"lighting", "shot"}},
                                       {"--manifest", {"lighting"}},
                                       {"--estimates", {"lighting"}},
                                       {"--network", {"lighting", "shot"}},
                                       {"--object", {"lighting"}},
                                       {"--views", {"lighting"}},
                                       {"--samples", {"lighting"}},
                                       {"--seed", {"shot"}},
                                       {"--threads", {"lighting", "shot"}}};

}  // namespace

void add_verify_command(Command& program, int* exit_code) {
  const auto options = std::make_shared<Options>();
  Command command = program.add_subcommand("verify", "Measure claims against their truths; exit code 1 if one fails");
  command->add_option("suite", options->suite, "granular, lighting or shot")
      ->required()
      ->check(one_of({"granular", "lighting", "shot"}));
  command->add_option("--case", options->cases, "Only these cases (all)")->check(one_of(verdict_groups()));
  command->add_flag("--quick", options->quick, "Granular: only the cases that take seconds");
  command->add_option("--json", options->json, "Write the rows to this file");
  command->add_option("--out", options->out, "Write table and curves into this folder");
  command->add_option("--isa", options->isa, "Kernels to use (automatic)");
  command->add_option("--panoramas", options->panoramas,
                      "Lighting and shot: .hdr or .exr files, or folders of them (the data folder's interiors)");
  command->add_option("--manifest", options->manifest, "Lighting: CSV with file, group and fold");
  command
      ->add_option(
          "--estimates", options->estimates,
          "Lighting: the estimates of all views, as train.py writes them (on the data folder the cross-validated ones)")
      ->excludes(command->add_option(
          "--network", options->network,
          "Lighting and shot: a network's file, run as in an app (the shipped one); lighting, .npz: in float"));
  command->add_option("--object", options->object, "Lighting: a mesh file or a generated mesh's name")
      ->capture_default_str();
  command->add_option("--views", options->views, "Lighting: of each panorama's eight")
      ->check(range(1, 8))
      ->capture_default_str();
  command->add_option("--samples", options->samples, "Lighting: paths a pixel; 0 renders nothing")
      ->check(range(0, 4096))
      ->capture_default_str();
  command
      ->add_option("--seed", options->seed,
                   "Shot: where the cameras look; 0 is the study, others check it in all panoramas")
      ->capture_default_str();
  command->add_option("--threads", options->threads, "Lighting and shot: threads; the result does not depend on them")
      ->check(range(1u, 256u))
      ->capture_default_str();
  command->callback([options, exit_code, command] {
    command.refuse_unused(options->suite, k_uses);
    listen_for_interrupt();
    *exit_code = options->suite == "shot"       ? verify_shot_suite(*options)
                 : options->suite == "lighting" ? verify_lighting_suite(*options)
                                                : verify_granular(*options);
  });
}

}  // namespace sandglass::host
