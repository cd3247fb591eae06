// What a frame did: numbers for the report, sentences for the log.
#include "runtime/math/hash.h"
#include "runtime/scene/scene.h"

namespace sandglass {

void report_scene(const sandglass_scene& scene, sandglass_frame_report* report) {
  const Granular& g = scene.granular;
  report->frame = scene.frame;
  report->time.simulated = g.time.simulated;
  const double debt = g.time.debt + g.time.slipped;
  report->time.debt = debt > k_time_resolution ? debt : 0.0;
  report->sand.grain_lag = g.grains.count == 0 ? 0.0f : static_cast<float>(g.time.grain_lag);
  report->sand.grains_time = g.time.grains.reached;
  report->sand.shown_time = g.time.grains.shown;
  report->sand.substep = g.substep.length;
  report->sand.substeps = g.counts.substeps;
  report->sand.list_builds = g.counts.list_builds;
  report->sand.particles = g.particles.count;
  report->sand.awake = g.sleep.awake_count;
  report->sand.grains = g.grains.count;
  const uint32_t awake_grains = g.grain_sleep.group_count * k_lane_group;
  report->sand.awake_grains = awake_grains < g.grains.count ? awake_grains : g.grains.count;
  report->sand.dropped_contacts = g.counts.dropped_contacts;
  report->sand.quarantined = g.counts.quarantined;
  report->sand.grid_full = g.motion.grid.overflowed;
  report->sand.ignored_colliders = g.counts.ignored_colliders;
  report->sand.ignored_emitters = g.counts.ignored_emitters;
  report->sand.ignored_sinks = g.counts.ignored_sinks;
  report->sand.particle_numbers = g.particles.count + g.flow.free_particle_count;
  report->sand.grain_numbers = g.grains.count + g.flow.free_grain_count;
  report->sand.emitted_particles = g.flow.counts.emitted_particles;
  report->sand.emitted_grains = g.flow.counts.emitted_grains;
  report->sand.removed_particles = g.flow.counts.removed_particles;
  report->sand.removed_grains = g.flow.counts.removed_grains;
  report->sand.removed_bodies = g.flow.counts.removed_bodies;
  report->sand.denied_particles = g.flow.counts.denied_particles;
  report->sand.speed_max = g.particles.speed_max;
  report->versions.grains = g.output.version;
  report->versions.bodies = scene.body_version;
}

void follow_bodies(sandglass_scene* scene) {
  const Granular& g = scene->granular;
  // What falls asleep in a frame has moved in it; what the app does to bodies between frames wakes them, moves all sand or
  // changes their number.
  const bool moving = g.sleep.awake_count != 0 || g.output.last_change == g.output.frame;
  const bool look = moving || scene->bodies_moved || g.bodies.count != scene->body_count;
  scene->bodies_moved = moving;
  scene->body_count = g.bodies.count;
  if (!look || (g.bodies.count == 0 && scene->body_hash == 0)) return;
  uint64_t hash = 0;
  for (uint32_t i = 0; i < g.desc.body_capacity; ++i) {
    if (!bodies_has(g.bodies, i)) continue;
    sandglass_body_pose pose = {};
    granular_body_pose(g, i, &pose);
    hash = hash_with(hash_with(hash, i + 1), hash_bytes(&pose, sizeof pose));
  }
  if (hash != scene->body_hash) {
    scene->body_hash = hash;
    ++scene->body_version;
  }
}

void log_frame(const sandglass_scene& scene) {
  const sandglass_log& log = scene.desc.log;
  if (log.write == nullptr) return;
  const FrameCounts& counts = scene.granular.counts;
  const struct {
    uint32_t count;
    const char* sentence;
  } events[] = {
      {counts.dropped_contacts,
       "granular: more neighbours than a list holds; some contacts were left out in this frame."},
      {counts.quarantined,
       "granular: a particle or grain left the coordinate range or was not finite; it was put to rest."},
      {counts.ignored_colliders,
       "granular: a collider was left out: a number of it is out of range, or it is beyond collider_capacity."},
      {counts.ignored_emitters,
       "granular: an emitter was left out: a number of it is out of range, or it is beyond emitter_capacity."},
      {counts.ignored_sinks,
       "granular: a sink was left out: a number of it is out of range, or it is beyond sink_capacity."},
      {counts.denied_particles,
       "granular: an emitter poured less than it should: raise particle_capacity or grain_capacity, pass a sink, or "
       "clear the place before its nozzle."},
  };
  for (const auto& event : events)
    if (event.count != 0) log.write(log.user, event.sentence);
}

}  // namespace sandglass
