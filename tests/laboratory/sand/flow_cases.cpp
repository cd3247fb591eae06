// Flow experiments, in frames of 20 ms without a budget. The deposit is found with the metrics' own cell grid, not with
// the library's neighbour lists.
#include "tests/laboratory/sand/flow_cases.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "models/files/failure.h"
#include "models/geometry/cell_grid.h"
#include "models/simulation/metrics.h"
#include "models/simulation/simulation.h"
#include "tests/laboratory/sand/apparatus.h"

namespace sandglass::host {

namespace {

constexpr double k_loosest = 0.54;       // the packing that sand is assumed to have when an amount is chosen
constexpr double k_densest = 0.64;       // dense random packing
constexpr double k_quiet = 0.03;         // poured sand has settled when its speed is below this, in sqrt(g d)
constexpr uint32_t k_pour_frames = 300;  // the longest wait until sand has settled
constexpr double k_chain = 1.1;          // distance between neighbours in the deposit, in d
constexpr int k_sectors = 24;
constexpr double k_beverloo_k = 1.4;

double sphere_volume(double radius) { return 4.0 / 3.0 * std::numbers::pi * radius * radius * radius; }

void require(sandglass_status status, const char* const& reason) {
  if (status != SANDGLASS_OK) throw cannot("run", "flow", reason != nullptr ? reason : sandglass_status_name(status));
}

// The positions of the particles that were not removed.
std::vector<float> present(Simulation* simulation) {
  const std::vector<float>& all = simulation->particle_positions();
  std::vector<float> kept;
  for (size_t i = 0; i < all.size(); i += 3)
    if (all[i + 1] > 0.5f * SANDGLASS_REMOVED_Y) kept.insert(kept.end(), &all[i], &all[i] + 3);
  return kept;
}

// Runs frames until the sand has settled.
void settle(Simulation* simulation, std::span<const sandglass_collider> colliders, double diameter,
            const CaseStep& step) {
  const double quiet = k_quiet * std::sqrt(k_gravity * diameter);
  for (uint32_t frame = 0; frame < k_pour_frames; ++frame) {
    simulation->frame(k_frame, k_no_budget, colliders);
    step();
    if (frame > 50 && speed_rms(simulation->particle_velocities()) < quiet) return;
  }
}

// The packing between two heights and within a distance of the axis: the share of a regular grid of probes that lies
// inside a particle.
double packing_within(std::span<const float> positions, double radius, double reach, double low, double high,
                      double centre_x = 0.0) {
  const CellGrid grid(positions, 2.0 * radius);
  const double spacing = 0.4 * radius;
  uint64_t probes = 0, inside = 0;
  for (double x = -reach; x <= reach; x += spacing)
    for (double z = -reach; z <= reach; z += spacing) {
      if (x * x + z * z > reach * reach) continue;
      for (double y = low; y <= high; y += spacing) {
        bool hit = false;
        const Vec3 p = {x + centre_x, y, z};
        grid.near(p, radius, [&](uint32_t i) {
          hit = hit || length(Vec3{positions[3 * i], positions[3 * i + 1], positions[3 * i + 2]} - p) < radius;
        });
        ++probes;
        inside += hit ? 1 : 0;
      }
    }
  return probes == 0 ? 0.0 : static_cast<double>(inside) / static_cast<double>(probes);
}

// Marks every particle that a chain of neighbours joins to the particle nearest to a place on the floor.
std::vector<bool> joined_to(std::span<const float> positions, double diameter, double x, double z) {
  const uint32_t count = static_cast<uint32_t>(positions.size() / 3);
  std::vector<bool> joined(count, false);
  if (count == 0) return joined;
  const CellGrid grid(positions, k_chain * diameter);
  const auto at = [&](uint32_t i) { return Vec3{positions[3 * i], positions[3 * i + 1], positions[3 * i + 2]}; };
  uint32_t first = 0;
  for (uint32_t i = 1; i < count; ++i)
    if (length(at(i) - Vec3{x, 0.0, z}) < length(at(first) - Vec3{x, 0.0, z})) first = i;
  std::vector<uint32_t> open = {first};
  joined[first] = true;
  while (!open.empty()) {
    const uint32_t i = open.back();
    open.pop_back();
    grid.near(at(i), k_chain * diameter, [&](uint32_t j) {
      if (joined[j] || length(at(i) - at(j)) >= k_chain * diameter) return;
      joined[j] = true;
      open.push_back(j);
    });
  }
  return joined;
}

// The scene's bytes, to go on from them in other scenes.
std::vector<unsigned char> saved(const Simulation& simulation) {
  std::vector<unsigned char> bytes(sandglass_scene_save_bytes(simulation.handle()));
  const char* reason = nullptr;
  uint64_t written = 0;
  require(sandglass_scene_save(simulation.handle(), bytes.data(), bytes.size(), &written, &reason), reason);
  return bytes;
}

void restore(Simulation* simulation, const std::vector<unsigned char>& bytes) {
  const char* reason = nullptr;
  require(sandglass_scene_restore(simulation->handle(), bytes.data(), bytes.size(), &reason), reason);
}

}  // namespace

double lube_runout(double aspect) { return aspect < 1.7 ? 1.24 * aspect : 1.6 * std::sqrt(aspect); }

Collapse collapse(const sandglass_scene_desc& desc, const CollapseSetting& setting, const CaseStep& step) {
  constexpr double k_far = 900.0;  // metres
  const double r = desc.granular.particle_radius, d = 2.0 * r;
  const double r0 = setting.radius_d * d, height = setting.aspect * r0;
  const double base = std::numbers::pi * r0 * r0;
  const double far = setting.at_far_end ? k_far : 0.0;
  const uint32_t count = static_cast<uint32_t>(k_densest * 1.02 * base * (height + d) / sphere_volume(r));

  Simulation simulation(with_room(desc, count));
  std::vector<float> points = scattered(count, r0, 0.0, r, setting.seed);
  const double top = highest_of(points);
  for (size_t i = 0; i < points.size(); i += 3) points[i] += static_cast<float>(far);
  simulation.add(points, {});

  // The tube comes last, because it is taken away to release the column.
  const cpp::Field tube = vessel(cylinder(r0, -4.0 * d, top + 4.0 * d), r);
  std::vector<sandglass_collider> colliders = {cpp::floor_at(0.0f),
                                               cpp::field_at(tube, static_cast<float>(far), 0.0f, 0.0f)};
  settle(&simulation, colliders, d, step);

  // Particles that reach into a box over the column are removed.
  const sandglass_collider above =
      cpp::box(static_cast<float>(far), static_cast<float>(height - r) + 10.0f, 0.0f, 10.0f, 10.0f, 10.0f);
  const char* reason = nullptr;
  require(sandglass_scene_remove(simulation.handle(), &above, nullptr, nullptr, &reason), reason);

  Collapse result;
  result.packing = packing_within(present(&simulation), r, r0 - 2.0 * d, 2.0 * d, height - 2.0 * d, far);
  colliders.pop_back();
  for (uint32_t frame = 0; frame < frames_in(setting.seconds); ++frame) {
    simulation.frame(k_frame, k_no_budget, colliders);
    step();
  }

  std::vector<float> deposit = present(&simulation);
  for (size_t i = 0; i < deposit.size(); i += 3) deposit[i] -= static_cast<float>(far);
  const std::vector<bool> joined = joined_to(deposit, d, 0.0, 0.0);
  std::array<double, k_sectors> front = {};
  for (size_t i = 0; i < joined.size(); ++i) {
    if (!joined[i]) continue;
    const double x = deposit[3 * i], z = deposit[3 * i + 2];
    const double share = std::atan2(z, x) / (2.0 * std::numbers::pi) + 0.5;
    const size_t part = static_cast<size_t>(std::clamp(static_cast<int>(share * k_sectors), 0, k_sectors - 1));
    front[part] = std::max(front[part], std::sqrt(x * x + z * z) + r);
  }
  for (const double reach : front) result.runout += reach / k_sectors;
  result.runout = (result.runout - r0) / r0;
  return result;
}

double repose(const sandglass_scene_desc& desc, double radius_d, double aspect, uint64_t seed, const CaseStep& step) {
  constexpr double k_drain_seconds = 3.0;
  const double r = desc.granular.particle_radius, d = 2.0 * r, reach = radius_d * d, height = aspect * reach;
  const uint32_t count =
      static_cast<uint32_t>(k_loosest * std::numbers::pi * reach * reach * height / sphere_volume(r));
  const std::vector<float> points = scattered(count, reach, 0.0, r, seed);
  const cpp::Field platform = vessel(cylinder(reach, -3.0 * d, 0.0), r, SANDGLASS_SOLID_INSIDE),
                   tube = vessel(cylinder(reach, -6.0 * d, highest_of(points) + 4.0 * d), r);
  const sandglass_collider colliders[2] = {cpp::field_at(platform, 0.0f, 0.0f, 0.0f),
                                           cpp::field_at(tube, 0.0f, 0.0f, 0.0f)};
  Simulation simulation(with_room(desc, count));
  simulation.add(points, {});
  settle(&simulation, colliders, d, step);
  const double packing = packing_within(simulation.particle_positions(), r, reach - 2.0 * d, 2.0 * d, 0.5 * height);
  for (uint32_t frame = 0; frame < frames_in(k_drain_seconds); ++frame) {
    simulation.frame(k_frame, k_no_budget, {colliders, 1});
    step();
  }
  uint32_t stay = 0;
  for (size_t i = 1; i < 3 * static_cast<size_t>(count); i += 3) stay += simulation.particle_positions()[i] > 0.0f;
  const double volume = stay * sphere_volume(r) / packing;
  return std::atan(3.0 * volume / (std::numbers::pi * reach * reach * reach)) * 180.0 / std::numbers::pi;
}

namespace {

constexpr double k_silo_d = 40.0, k_fill_d = 24.0;

// A silo that is filled from above as it runs out through an orifice.
class Silo {
 public:
  Silo(const sandglass_scene_desc& full, const std::vector<unsigned char>& filled, double orifice_d,
       const CaseStep& step)
      : d_(2.0 * static_cast<double>(full.granular.particle_radius)), step_(step), simulation_(full) {
    constexpr double k_plate_d = 1.5, k_nozzle_d = 14.0, k_height_d = 1.6 * k_fill_d, k_below_d = -8.0;
    constexpr float k_pour_speed = 1.0f;
    const double silo = 0.5 * k_silo_d * d_, hole = 0.5 * orifice_d * d_, height = k_height_d * d_,
                 below = k_below_d * d_, plate = -k_plate_d * d_;
    // The field's nodes are half a radius apart, because the orifice's edge decides the result.
    open_ = vessel({{0.0, below},
                    {silo, below},
                    {silo, plate},
                    {hole, plate},
                    {hole, 0.0},
                    {silo, 0.0},
                    {silo, height},
                    {0.0, height}},
                   0.25 * d_);
    collider_ = cpp::field_at(open_, 0.0f, 0.0f, 0.0f);
    emitter_ = cpp::emitter(0.0f, static_cast<float>(height - 2.0 * d_), 0.0f, static_cast<float>(k_nozzle_d * d_),
                            k_pour_speed, 0);
    sink_ = cpp::floor_at(static_cast<float>(below + 4.0 * d_));
    restore(&simulation_, filled);
    input_.time_step = static_cast<float>(k_frame);
    input_.budget_ns = k_no_budget;
    input_.colliders = &collider_;
    input_.collider_count = 1;
    input_.emitters = &emitter_;
    input_.emitter_count = 1;
    input_.sinks = &sink_;
    input_.sink_count = 1;
    removed_ = simulation_.frame(input_).sand.removed_particles;
  }

  // How many particles come out in so many frames.
  double run(uint32_t frames) {
    const uint64_t before = removed_;
    for (uint32_t frame = 0; frame < frames; ++frame) {
      removed_ = simulation_.frame(input_).sand.removed_particles;
      step_();
    }
    return static_cast<double>(removed_ - before);
  }
  // The bed's height: how high particles lie at a distance of 12 d to 16 d from the axis.
  double head_d() {
    const std::vector<float> bed = present(&simulation_);
    std::vector<double> heights;
    for (size_t i = 0; i < bed.size(); i += 3) {
      const double at = std::hypot(static_cast<double>(bed[i]), static_cast<double>(bed[i + 2]));
      if (at > 12.0 * d_ && at < 16.0 * d_) heights.push_back(bed[i + 1]);
    }
    return quantile(heights, 0.98) / d_;
  }

 private:
  double d_;
  const CaseStep& step_;
  Simulation simulation_;
  cpp::Field open_;
  sandglass_collider collider_ = {}, sink_ = {};
  sandglass_emitter emitter_ = {};
  sandglass_frame_input input_ = cpp::frame_input();
  uint64_t removed_ = 0;
};

}  // namespace

DischargeCurve discharge(const sandglass_scene_desc& desc, const DischargeSetting& setting, const CaseStep& step) {
  constexpr int k_quarters = 4;
  const double r = desc.granular.particle_radius, d = 2.0 * r, silo = 0.5 * k_silo_d * d;
  const uint32_t count = static_cast<uint32_t>(0.58 * std::numbers::pi * silo * silo * k_fill_d * d / sphere_volume(r));
  sandglass_scene_desc full = with_room(desc, count);
  full.granular.emitter_capacity = full.granular.sink_capacity = 1;

  const std::vector<float> points = scattered(count, silo, 0.0, r, 1);
  Simulation filled(full);
  filled.add(points, {});
  {
    const cpp::Field closed = vessel(cylinder(silo, 0.0, highest_of(points) + 4.0 * d), r);
    const sandglass_collider collider = cpp::field_at(closed, 0.0f, 0.0f, 0.0f);
    settle(&filled, {&collider, 1}, d, step);
  }
  DischargeCurve curve;
  curve.packing = packing_within(filled.particle_positions(), r, silo - 3.0 * d, 3.0 * d, 0.6 * k_fill_d * d);
  const std::vector<unsigned char> bytes = saved(filled);

  std::vector<double> openings, flows;
  for (const double orifice_d : setting.orifices_d) {
    Silo open(full, bytes, orifice_d, step);
    open.run(frames_in(setting.settle_seconds));
    Discharge point;
    point.orifice_d = orifice_d;
    // Beverloo's law predicts how long it takes until enough particles have come out.
    const double expected =
        0.58 * curve.packing * std::sqrt(k_gravity) * std::pow((orifice_d - k_beverloo_k) * d, 2.5) / sphere_volume(r);
    const uint32_t frames =
        frames_in(std::min(setting.measure_seconds, setting.enough_particles / expected) / k_quarters);
    std::array<double, k_quarters> rates;
    double out = 0.0;
    point.head_d = 1e30;
    for (double& rate : rates) {
      const double came = open.run(frames);
      out += came;
      rate = came / (frames * k_frame);
      point.head_d = std::min(point.head_d, open.head_d());
    }
    point.rate = out / (frames * k_quarters * k_frame);
    for (const double rate : rates) point.unsteady = std::max(point.unsteady, std::fabs(rate / point.rate - 1.0));
    openings.push_back((orifice_d - k_beverloo_k) * d);
    flows.push_back(std::max(point.rate, 1e-9));
    curve.points.push_back(point);
  }
  curve.exponent = fitted_exponent(openings, flows);
  return curve;
}

TubeLoad tube_load(const sandglass_scene_desc& desc, bool frictionless, const CaseStep& step) {
  constexpr double k_tube_d = 8.0, k_settle_seconds = 2.0, k_sinking_d = 0.25;  // d a second
  constexpr int k_looks = 150;  // how many instants are averaged; they are a frame apart
  const double r = desc.granular.particle_radius, d = 2.0 * r, tube = 0.5 * k_tube_d * d;
  const double mass_per_diameter = k_loosest * std::numbers::pi * tube * tube * k_tube_d * d / sphere_volume(r);
  std::vector<double> weights, loads;  // M g, and the load on the bottom, in weights of one tube diameter of sand
  for (const double diameters : {4.0, 8.0}) {
    const uint32_t count = static_cast<uint32_t>(diameters * mass_per_diameter);
    sandglass_scene_desc full = with_room(desc, count);
    full.granular.sleep_after = 0.0f;
    if (frictionless) full.granular.static_friction = full.granular.kinetic_friction = 0.0f;
    const std::vector<float> points = scattered(count, tube, 0.0, r, 1);
    const cpp::Field wall = vessel(cylinder(tube, -4.0 * d, highest_of(points) + 4.0 * d), r);
    sandglass_collider colliders[2] = {cpp::field_at(wall, 0.0f, 0.0f, 0.0f), cpp::floor_at(0.0f)};
    sandglass_collider& piston = colliders[1];
    Simulation simulation(full);
    simulation.add(points, {});
    settle(&simulation, colliders, d, step);
    // Friction on sand at rest may point either way. The floor sinks slowly, as in the experiments, so that all
    // friction points up.
    piston.linear_velocity[1] = static_cast<float>(-k_sinking_d * d);
    const auto sink = [&] { piston.position[1] += static_cast<float>(k_frame) * piston.linear_velocity[1]; };
    for (uint32_t frame = 0; frame < frames_in(k_settle_seconds); ++frame) {
      sink();
      simulation.frame(k_frame, k_no_budget, colliders);
      step();
    }
    double load = 0.0;
    for (int look = 0; look < k_looks; ++look) {
      sink();
      // A contact's force is its overlap divided by the square of the sub-step's length.
      const double substep = static_cast<double>(simulation.frame(k_frame, k_no_budget, colliders).sand.substep);
      step();
      // One sub-step without the floor: how far the sand sinks below it is how far the floor would have lifted it.
      piston.position[1] += static_cast<float>(substep) * piston.linear_velocity[1];
      const sandglass_frame_report report = simulation.frame(substep, k_no_budget, {colliders, 1});
      if (report.sand.substeps != 1)
        throw cannot("measure", "load", "the sub-step that measures it was split", "Report this");
      double lifted = 0.0;
      for (size_t i = 1; i < simulation.particle_positions().size(); i += 3) {
        const double depth =
            static_cast<double>(piston.position[1]) + r - static_cast<double>(simulation.particle_positions()[i]);
        lifted += std::max(depth, 0.0);
      }
      load += lifted / (substep * substep) / k_gravity / k_looks;  // in weights of a particle
    }
    weights.push_back(count / mass_per_diameter);
    loads.push_back(load / mass_per_diameter);
  }
  return {(loads[1] - loads[0]) / (weights[1] - weights[0]), loads[1] / weights[1]};
}

}  // namespace sandglass::host
