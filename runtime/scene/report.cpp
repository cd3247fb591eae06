// What a frame did: numbers for the report, sentences for the log.
#include "runtime/scene/scene.h"

namespace sandglass {

void report_scene(const sandglass_scene& scene, sandglass_frame_report* report) {
  const Granular& g = scene.granular;
  report->frame = scene.frame;
  report->simulated_time = g.simulated;
  const double debt = g.owed + g.slipped;
  report->time_debt = debt > 1e-9 ? debt : 0.0;
  report->grain_lag = g.grain_count == 0 ? 0.0f : static_cast<float>(g.unswept);
  report->substep = g.substep;
  report->substeps = g.substeps;
  report->list_builds = g.list_builds;
  report->particles = g.particle_count;
  report->awake = g.awake_count;
  report->grains = g.grain_count;
  const uint32_t awake_grains = g.grain_group_count * k_lane_group;
  report->awake_grains = awake_grains < g.grain_count ? awake_grains : g.grain_count;
  report->dropped_contacts = g.dropped_contacts;
  report->quarantined = g.quarantined;
  report->ignored_colliders = g.ignored_colliders;
  report->particle_numbers = g.particle_count + g.free_particle_count;
  report->grain_numbers = g.grain_count + g.free_grain_count;
  report->emitted_particles = g.emitted_particles;
  report->emitted_grains = g.emitted_grains;
  report->removed_particles = g.removed_particles;
  report->removed_grains = g.removed_grains;
  report->denied_particles = g.denied_particles;
  report->speed_max = g.speed_max;
}

void log_frame(const sandglass_scene& scene) {
  const sandglass_log& log = scene.desc.log;
  if (log.write == nullptr) return;
  const Granular& g = scene.granular;
  if (g.dropped_contacts != 0)
    log.write(log.user, "granular: more neighbours than a list holds; some contacts were left out in this frame.");
  if (g.quarantined != 0)
    log.write(log.user,
              "granular: a particle or grain left the coordinate range or was not finite; it was put to rest.");
  if (g.ignored_colliders != 0)
    log.write(
        log.user,
        "granular: a collider, emitter or sink was left out: it is not finite, has no size, or is beyond the capacity "
        "for its kind. Check what the frame input holds.");
}

}  // namespace sandglass
