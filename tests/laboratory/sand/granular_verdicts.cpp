// The claims about sand, in groups. Each group adds its rows to the table. The quick table leaves out groups that take
// long.
#include "tests/laboratory/sand/granular_verdicts.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "models/simulation/metrics.h"
#include "tests/laboratory/sand/apparatus.h"
#include "tests/laboratory/sand/physics_cases.h"

namespace sandglass::host {

namespace {

constexpr double k_wrong_mu = 0.1, k_rough_mu = 0.6;
constexpr double k_slippery_mu = 0.05;  // a third of the default
constexpr double k_reported = std::numeric_limits<double>::infinity();

struct Stopped {};

struct Table {
  sandglass_isa isa;
  CaseStep step;
  std::vector<Verdict>* rows;
  std::string group;
  uint64_t seed;

  // NaN is never within the limit.
  static bool within(double result, double truth, double limit) { return std::fabs(result - truth) <= limit; }

  void claim(const std::string& name, const char* unit, double truth, double result, double limit) {
    rows->push_back({group, name, unit, truth, result, limit, within(result, truth, limit), false});
  }
  void control(const std::string& name, const char* unit, double truth, double result, double limit) {
    rows->push_back({group, name, unit, truth, result, limit, !within(result, truth, limit), true});
  }
  void report(const std::string& name, const char* unit, double truth, double result) {
    claim(name, unit, truth, result, k_reported);
  }

  sandglass_scene_desc defaults() const {
    sandglass_scene_desc desc = cpp::scene_desc();
    desc.isa = isa;
    return desc;
  }
  sandglass_scene_desc with_friction(double mu) const {
    sandglass_scene_desc desc = physics_desc(mu);
    desc.isa = isa;
    return desc;
  }
  // A solver that is too coarse: one long step a frame and one averaged iteration.
  sandglass_scene_desc coarse() const {
    sandglass_scene_desc desc = defaults();
    desc.granular.reference.scheme = SANDGLASS_SCHEME_AVERAGED;
    desc.granular.reference.relaxation = 2.0f;
    desc.granular.reference.solver_iterations = 1;
    desc.granular.reference.stabilisation_iterations = 0;
    desc.granular.substep_max = desc.granular.substep_min = 0.02f;
    return desc;
  }
};

void one_particle(Table& t) {
  constexpr double k_mu = 0.6, k_seconds = 2.0;
  const sandglass_scene_desc desc = t.with_friction(k_mu), slippery = t.with_friction(k_wrong_mu);
  const double d = 2.0 * static_cast<double>(desc.granular.particle_radius), slide = 1.0 / (2.0 * k_mu * k_gravity);
  t.claim("free_fall", "relative", 0.0, free_fall_error(desc), 1e-5);
  double substep = 0.0;
  const double x = sliding_distance(desc, &substep);
  t.claim("sliding_block", "m", slide, x, 1.05 * 1.0 * substep / 2.0);
  const double wrong = sliding_distance(slippery, &substep);
  t.control("sliding_block mu=0.1", "m", slide, wrong, 1.05 * 1.0 * substep / 2.0);
  for (const double mu : {0.1, 0.3, 0.5}) {
    const double stop = sliding_distance(t.with_friction(mu), &substep);
    char name[40];
    std::snprintf(name, sizeof name, "sliding_block at mu=%g", mu);
    t.claim(name, "m", 1.0 / (2.0 * mu * k_gravity), stop, 1.05 * 1.0 * substep / 2.0);
  }
  t.claim("incline 0.99 mu rests", "d", 0.0, incline_distance(desc, 0.99 * k_mu, 5.0) / d, 0.01);
  t.control("incline 0.99 mu, mu=0.1", "d", 0.0, incline_distance(slippery, 0.99 * k_mu, 1.0) / d, 0.01);
  for (const double factor : {1.05, 1.5}) {
    const double truth = incline_truth(desc, factor * k_mu, k_seconds);
    t.claim(factor < 1.2 ? "incline 1.05 mu slides" : "incline 1.5 mu slides", "m", truth,
            incline_distance(desc, factor * k_mu, k_seconds), 0.01 * truth);
  }
}

void rest(Table& t) {
  for (const bool rough : {false, true}) {
    const RestingPile pile = resting_pile(rough ? t.with_friction(k_rough_mu) : t.defaults());
    const std::string of = rough ? ", rough sand" : "";
    t.claim("overlap at rest, mean" + of, "r", 0.0, pile.overlap_mean, 0.01);
    t.claim("overlap at rest, max" + of, "r", 0.0, pile.overlap_max, 0.10);
    t.claim("speed at rest" + of, "sqrt(g d)", 0.0, pile.speed, 0.005);
    t.claim("sinking at rest" + of, "d/s", 0.0, pile.sinking, 0.01);
    t.claim("kinetic energy left" + of, "of max", 0.0, pile.energy_ratio, 0.001);
    t.claim("grains under the floor" + of, "grains", 0.0, pile.grains_below, 0.0);
  }
  t.control("overlap at rest, coarse", "r", 0.0, resting_pile(t.coarse()).overlap_mean, 0.01);
}

void momentum(Table& t) {
  const Cloud cloud = free_cloud(t.defaults());
  t.claim("momentum drift, free cloud", "a step", 0.0, cloud.drift_per_step, 1e-7);
  t.claim("momentum drift, 0.4 s", "of sum |p|", 0.0, cloud.drift, 1e-6);  // rounding of 512 floats over 1300 sub-steps
  t.claim("particles that collided", "of 512", 512.0, cloud.collisions, 255.0);
  sandglass_scene_desc averaged = t.defaults();
  averaged.granular.reference.scheme = SANDGLASS_SCHEME_AVERAGED;
  averaged.granular.reference.relaxation = 1.0f;
  t.control("momentum drift, averaged", "of sum |p|", 0.0, free_cloud(averaged).drift, 1e-4);
}

void refinement(Table& t) {
  // A grain follows how far the particles went in a frame. In each of 36 sub-steps a coordinate below 0.5 m is rounded
  // by 2^-26 m at most: of 0.62 m/s in 20 ms that is 0.43e-4 along an axis, and sqrt(3) times that in all.
  t.claim("uniform field reproduced", "of |u|", 0.0, uniform_field_error(t.defaults(), 0.0), 0.75e-4);
  t.control("uniform field, sheared", "of |u|", 0.0, uniform_field_error(t.defaults(), 0.5), 1e-3);
  t.claim("lambda threshold, one ulp", "d", 0.0, threshold_jump(t.defaults()), 0.001);
  const PushOnALine push = push_on_a_line(t.defaults());
  t.claim("push, from grain to grain", "d", 0.0, push.change, 0.001);
  t.control("push, were it at once", "d", 0.0, push.max, 0.001);
  sandglass_scene_desc source = t.defaults();
  source.granular.reference.blend = SANDGLASS_BLEND_SOURCE;
  const double jump = threshold_jump(source);
  t.control("lambda threshold, source", "d", 0.0, jump, 0.001);
  // The rule as printed makes grains jump by 1 - W(r) = 0.298 of the particles' 1 m/s for 8 ms. The unit is d = 2 cm.
  t.claim("lambda threshold, source's jump", "d", 0.298 * 0.008 / 0.02, jump, 0.002);
}

void column(Table& t) {
  constexpr double k_low_end = 1.7;   // the aspect ratio at which the law's exponent changes from 1 to 1/2
  constexpr double k_high_end = 5.0;  // the exponent is fitted up to here
  constexpr uint64_t k_seeds = 2;
  std::vector<double> low_a, low_r, high_a, high_r, wrong_a, wrong_r;
  double packing = 0.0;
  const auto mean_runout = [&](const sandglass_scene_desc& desc, CollapseSetting setting, uint64_t seeds) {
    double sum = 0.0;
    for (uint64_t seed = 1; seed <= seeds; ++seed) {
      setting.seed = 1000 * t.seed + seed;
      const Collapse trial = collapse(desc, setting, t.step);
      sum += trial.runout / static_cast<double>(seeds);
      packing = std::max(packing, trial.packing);
    }
    return sum;
  };
  for (const double aspect : {0.5, 0.75, 1.0, 1.5, 2.0, 3.0, 4.0, 6.0, 8.0}) {
    CollapseSetting setting;
    setting.aspect = aspect;
    const double runout = mean_runout(t.defaults(), setting, k_seeds), law = lube_runout(aspect);
    char name[48];
    std::snprintf(name, sizeof name, "column a=%g", aspect);
    const bool gated = aspect != 0.75 && aspect != 1.5 && aspect != 4.0;
    t.claim(name, "R0", law, runout, gated ? 0.25 * law : k_reported);
    if (aspect > k_high_end) continue;
    (aspect < k_low_end ? low_a : high_a).push_back(aspect);
    (aspect < k_low_end ? low_r : high_r).push_back(runout);
  }
  t.claim("column exponent, a < 1.7", "", 1.0, fitted_exponent(low_a, low_r), 0.15);
  t.claim("column exponent, a > 1.7", "", 0.5, fitted_exponent(high_a, high_r), 0.15);
  t.claim("packing of poured sand", "", 0.33, packing, 0.33);  // that is, at most 0.66
  for (const double aspect : {0.5, 1.0}) {
    CollapseSetting setting;
    setting.aspect = aspect;
    const double runout = mean_runout(t.with_friction(k_slippery_mu), setting, k_seeds), law = lube_runout(aspect);
    if (aspect == 0.5) t.control("column a=0.5, mu=0.05", "R0", law, runout, 0.25 * law);
    wrong_a.push_back(aspect);
    wrong_r.push_back(runout);
  }
  t.control("column exponent, mu=0.05", "", 1.0, fitted_exponent(wrong_a, wrong_r), 0.15);
  t.control("column a=1, mu=0.6", "R0", lube_runout(1.0), mean_runout(t.with_friction(k_rough_mu), {}, 1),
            0.25 * lube_runout(1.0));
}

void beverloo(Table& t) {
  DischargeSetting setting;
  setting.orifices_d = {5.0, 6.0, 7.0, 8.5, 10.0};
  const DischargeCurve curve = discharge(t.defaults(), setting, t.step);
  t.claim("discharge exponent", "", 2.5, curve.exponent, 0.15);
  for (const Discharge& point : curve.points) {
    char name[48];
    std::snprintf(name, sizeof name, "discharge steady, D/d=%g", point.orifice_d);
    t.claim(name, "of mean", 0.0, point.unsteady, 0.05);
  }
  double head = 1e30;
  for (const Discharge& point : curve.points) head = std::min(head, point.head_d / point.orifice_d);
  t.claim("head over orifice, least", "h/D", 3.0, head, 1.0);
  setting.enough_particles = 3000.0;  // its rate need not be steady
  setting.measure_seconds = 4.0;
  t.control("discharge exponent, coarse", "", 2.5, discharge(t.coarse(), setting, t.step).exponent, 0.15);
}

void janssen(Table& t) {
  // The walls are so rough that 8 diameters are many times the law's own length.
  sandglass_scene_desc plain = t.with_friction(0.3);
  plain.granular.height_weighting = 0.0f;
  const TubeLoad tube = tube_load(plain, false, t.step), smooth = tube_load(plain, true, t.step);
  t.claim("tube load added, 4-8 D (k=0)", "of weight", 0.0, tube.marginal, 0.2);
  t.control("tube load added, smooth wall", "of weight", 0.0, smooth.marginal, 0.2);
  // Without friction the column swings on its floor. The mean of 150 instants counts.
  t.claim("smooth tube carries all (k=0)", "of weight", 1.0, smooth.carried, 0.1);
  t.report("smooth tube, default k", "of weight", 1.0, tube_load(t.defaults(), true, t.step).carried);
}

void angles(Table& t) {
  constexpr double k_radius_d = 8.0, k_aspect = 1.2;
  constexpr uint64_t k_seeds = 4;  // two leave an angle uncertain by more than it rises between rough coefficients
  double rise_min = 1e30, before = 0.0;
  for (int tenth = 1; tenth <= 10; ++tenth) {
    const double mu = 0.1 * tenth;
    double angle = 0.0;
    for (uint64_t seed = 1; seed <= k_seeds; ++seed)
      angle += repose(t.with_friction(mu), k_radius_d, k_aspect, 1000 * t.seed + seed, t.step) / k_seeds;
    char name[40];
    std::snprintf(name, sizeof name, "repose mu=%.1f", mu);
    t.report(name, "deg", std::atan(mu) * 57.29577951308232, angle);
    if (tenth > 1) rise_min = std::min(rise_min, angle - before);
    before = angle;
  }
  // The angle must rise strictly: the least rise from one coefficient to the next is above 0.
  constexpr double k_rise_max = 45.0;
  t.claim("repose rises with mu, least", "deg", k_rise_max, rise_min, k_rise_max * (1.0 - 1e-9));
}

void hard(Table& t) {
  const sandglass_scene_desc desc = t.defaults();
  for (const uint32_t count : {2u, 64u}) {
    const Coincident together = coincident(desc, count);
    const std::string name = "coincident, " + std::to_string(count);
    t.claim(name + ": overlap", "r", 0.0, together.overlap, 0.1);
    // Each contact drives its two particles apart at sqrt(g d), each at half of that. Of two, one rises by d/8. With
    // twelve neighbours it could rise by 18 d.
    t.claim(name + ": rise", "d", 0.0, together.rise_d, count == 2 ? 0.125 : 18.0);
  }
  t.claim("stack of 20", "height", 0.99, stack(desc, 20, 5.0).height, 0.01);
  t.control("stack of 20, coarse", "height", 0.99, stack(t.coarse(), 20, 5.0).height, 0.01);
  const Stack hundred = stack(desc, 100, 5.0);
  t.claim("stack of 100", "height", 0.975, hundred.height, 0.025);  // no higher than its spheres
  t.claim("stack of 100: highest", "height", 1.0, hundred.highest, 0.01);
  t.claim("projectile at 40 m/s", "r deep", 0.0, projectile_depth(desc), 0.01);
  for (const double k : {0.0, 0.3, 0.6, 0.9, 1.5}) {
    char name[40];
    std::snprintf(name, sizeof name, "height weighting k=%g", k);
    t.claim(name, "m/s", 0.0, weighting_speed(desc, k), 1.0);
  }
  const double strange[] = {0.0, -1.0, std::nan(""), -std::numeric_limits<double>::infinity()}, huge[] = {1e9};
  t.claim("time steps 0, -1, NaN, -Inf", "s", 0.0, simulated_time(desc, strange), 0.0);
  t.claim("time step 1e9 s", "s", 0.1, simulated_time(desc, huge), 1e-6);
}

void far_end(Table& t) {
  CollapseSetting setting;
  setting.radius_d = 8.0;
  const double near = collapse(t.defaults(), setting, t.step).runout;
  setting.at_far_end = true;
  const double far = collapse(t.defaults(), setting, t.step).runout;
  // The difference is relative to the radius, not to its growth, because one sees a pile's radius.
  t.claim("column 900 m from the origin", "of R", 0.0, (far - near) / (1.0 + near), 0.05);
}

struct Group {
  const char* name;
  void (*run)(Table& table);
  uint64_t steps;  // about how often it calls `step`
  bool quick;
};
// Progress counts frames, whether a scene is small or large. The weight below corrects for the large ones.
constexpr Group k_groups[] = {
    {"particle", one_particle, 0, true},  {"rest", rest, 0, true},           {"momentum", momentum, 0, true},
    {"refinement", refinement, 0, true},  {"hard", hard, 0, true},           {"far", far_end, 500, true},
    {"column", column, 4900, false},      {"janssen", janssen, 2200, false}, {"repose", angles, 11000, false},
    {"beverloo", beverloo, 10500, false},
};
constexpr uint64_t k_group_cost = 100;  // what each group costs beside its frames, counted in frames

uint64_t weight(const Group& group) { return std::string(group.name) == "beverloo" ? 8 : 1; }

}  // namespace

std::vector<std::string> verdict_groups() {
  std::vector<std::string> names;
  for (const Group& group : k_groups) names.emplace_back(group.name);
  return names;
}

std::vector<std::string> quick_verdict_groups() {
  std::vector<std::string> names;
  for (const Group& group : k_groups)
    if (group.quick) names.emplace_back(group.name);
  return names;
}

std::vector<Verdict> granular_verdicts(const VerdictChoice& choice,
                                       const std::function<bool(uint64_t, uint64_t)>& progress) {
  std::vector<Verdict> rows;
  std::vector<const Group*> chosen;
  for (const Group& group : k_groups) {
    const bool named = choice.groups.empty() ||
                       std::find(choice.groups.begin(), choice.groups.end(), group.name) != choice.groups.end();
    if (named && (group.quick || !choice.quick)) chosen.push_back(&group);
  }
  uint64_t total = 0, before = 0;
  for (const Group* group : chosen) total += k_group_cost + group->steps * weight(*group);
  for (const Group* group : chosen) {
    const uint64_t cost = k_group_cost + group->steps * weight(*group);
    uint64_t within = 0;
    const CaseStep step = [&] {
      within = std::min(within + weight(*group), cost);
      if (!progress(before + within, total)) throw Stopped();
    };
    Table table{choice.isa, step, &rows, group->name, choice.seed};
    try {
      group->run(table);
    } catch (const Stopped&) {
      break;
    }
    before += cost;
    if (!progress(before, total)) break;
  }
  return rows;
}

}  // namespace sandglass::host
