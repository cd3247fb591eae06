#include "tests/sand/invariants.h"

#include <algorithm>
#include <cmath>

namespace sandglass::tests {

namespace {

bool finite(const float* v) { return std::isfinite(v[0]) && std::isfinite(v[1]) && std::isfinite(v[2]); }

}  // namespace

std::string Invariants::broken(const sandglass_frame_report& report) {
  const sandglass_time_report& t = report.time;
  const uint64_t late = t.elapsed_ns > t.last_unit_ns ? t.elapsed_ns - t.last_unit_ns : 0;
  if (t.clock_fault == 0 && late > std::max(t.target_ns, t.mandatory_ns)) return "the law of the budget";
  if (report.sand.quarantined != 0) return "something was quarantined";
  if (report.sand.particles != s_.particles_added + report.sand.emitted_particles - report.sand.removed_particles)
    return "particles were lost or made";
  if (report.sand.grains != s_.grains_added + report.sand.emitted_grains - report.sand.removed_grains)
    return "grains were lost or made";
  if (std::fabs(report.time.simulated + report.time.debt - s_.asked) > 1e-6 * (1.0 + s_.asked))
    return "the ledger of time";
  if (!(report.time.debt >= 0.0) || !(report.sand.grain_lag >= 0.0f)) return "a debt below 0";
  if (!s_.block.guards_intact() || !s_.drawn.guards_intact()) return "a byte outside was touched";
  const std::string sand = particles(report);
  return sand.empty() ? grains(report) : sand;
}

std::string Invariants::particles(const sandglass_frame_report& report) {
  const sandglass_granular_desc& g = s_.desc.granular;
  positions_.resize(3ull * report.sand.particle_numbers);
  velocities_.resize(3ull * report.sand.particle_numbers);
  sandglass_scene_particles(s_.scene.get(), positions_.data(), velocities_.data());
  // The limit of a pass, on which a body's rotation comes. Sand of the app or of a nozzle has its own speed at first. The
  // report's sub-step may have just begun: speeds are then of the one before.
  const float substep = substep_before_ > 0.0f ? std::min(report.sand.substep, substep_before_) : report.sand.substep;
  substep_before_ = report.sand.substep;
  const double fastest = 1.001 * static_cast<double>(g.courant * g.particle_radius) / static_cast<double>(substep);
  const float low = g.particle_radius * (1.0f - 1e-3f);
  // granular.courant: what can reach nothing is not slowed, as long as there are at most 64.
  uint32_t far_and_fast = 0;
  for (uint32_t i = 0; i < report.sand.particle_numbers; ++i) {
    const float *p = &positions_[3 * i], *v = &velocities_[3 * i];
    if (!finite(p) || !finite(v)) return "particle " + std::to_string(i) + " is not finite";
    if (p[1] == SANDGLASS_REMOVED_Y) continue;
    const bool body = i < s_.in_bodies;
    if (p[1] < (body ? -g.particle_radius : low) && !(body && !s_.bodies_have_floor))
      return "particle " + std::to_string(i) + " is below the floor, y = " + std::to_string(p[1]) + " m";
    const double speed = std::hypot(static_cast<double>(v[0]), static_cast<double>(v[1]), static_cast<double>(v[2]));
    if (report.sand.substeps != 0 && speed > (body ? 3.0 * fastest : std::max(fastest, k_given_speed)) &&
        (body || ++far_and_fast > 64 || !alone(i, report.sand.particle_numbers))) {
      return "particle " + std::to_string(i) + " is too fast: " + std::to_string(speed) + " of " +
             std::to_string(fastest) + " m/s";
    }
  }
  return "";
}

// No other particle within the reach of a neighbour list.
bool Invariants::alone(uint32_t particle, uint32_t count) const {
  const float reach = (2.0f + s_.desc.granular.list_margin) * s_.desc.granular.particle_radius;
  const float* p = &positions_[3 * particle];
  for (uint32_t i = 0; i < count; ++i) {
    const float* q = &positions_[3 * i];
    if (i != particle && std::hypot(p[0] - q[0], p[1] - q[1], p[2] - q[2]) < reach) return false;
  }
  return true;
}

std::string Invariants::grains(const sandglass_frame_report& report) {
  positions_.resize(3ull * report.sand.grain_numbers);
  velocities_.resize(3ull * report.sand.grain_numbers);
  if (report.sand.grain_numbers == 0) return "";
  sandglass_scene_grains(s_.scene.get(), positions_.data(), velocities_.data());
  for (uint32_t i = 0; i < report.sand.grain_numbers; ++i) {
    const float *p = &positions_[3 * i], *v = &velocities_[3 * i];
    if (!finite(p) || !finite(v)) return "grain " + std::to_string(i) + " is not finite";
    if (s_.grains_have_floor && p[1] != SANDGLASS_REMOVED_Y && p[1] < 0.0f)
      return "grain " + std::to_string(i) + " is below the floor, y = " + std::to_string(p[1]) + " m";
  }
  return "";
}

}  // namespace sandglass::tests
