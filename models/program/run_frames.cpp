// The frames of a run.
#include <cstdio>
#include <filesystem>

#include "models/files/npy.h"
#include "models/program/run.h"
#include "models/work/progress.h"
#include "platform/clock.h"

namespace sandglass::host {

namespace {

void dump_frame(const std::string& folder, uint32_t frame, double particle_radius, Simulation* simulation) {
  const auto write = [&](const char* item, const char* what, const std::vector<float>& values, uint64_t columns) {
    char name[64];
    std::snprintf(name, sizeof name, "%s_%06u_%s.npy", item, frame, what);
    write_npy((std::filesystem::path(folder) / name).string(), values, values.size() / columns, columns);
  };
  const std::vector<float>& particles = simulation->particle_positions();
  const uint32_t particle_count = static_cast<uint32_t>(particles.size() / 3);
  write("particles", "position", particles, 3);
  write("particles", "velocity", simulation->particle_velocities(), 3);
  write("particles", "radius", std::vector<float>(particle_count, static_cast<float>(particle_radius)), 1);
  const std::vector<float>& grains = simulation->grain_positions();
  const uint32_t grain_count = static_cast<uint32_t>(grains.size() / 3);
  if (grain_count == 0) return;
  write("grains", "position", grains, 3);
  write("grains", "velocity", simulation->grain_velocities(), 3);
  write("grains", "radius",
        std::vector<float>(grain_count, drawn_grain_radius(particle_radius, particle_count, grain_count)), 1);
}

// The positions without those of removed particles.
std::vector<float> present(const std::vector<float>& positions) {
  std::vector<float> left;
  left.reserve(positions.size());
  for (size_t i = 0; i < positions.size(); i += 3)
    if (positions[i + 1] != SANDGLASS_REMOVED_Y) left.insert(left.end(), &positions[i], &positions[i] + 3);
  return left;
}

}  // namespace

uint64_t Run::hash() const {
  const uint64_t of_pile = pile_ ? sandglass_pile_shadow_hash(pile_->handle()) : 0;
  return sandglass_scene_hash(simulation_->handle()) + shadows_->hash() + of_pile;
}

// The light with which the frame is drawn.
FrameLight Run::light_of(uint32_t frame) const {
  FrameLight light;
  if (!shot_ && !scene_.light) return light;
  ShotLight now;
  if (shot_) now = shot_->light(frame);
  else now.towards = scene_.light->towards(static_cast<double>(frame) / scene_.frames);
  const auto put = [](Vec3 from, double(&to)[3]) { to[0] = from.x, to[1] = from.y, to[2] = from.z; };
  light.known = true, light.coloured = shot_.has_value();
  put(normalised(now.towards), light.towards), put(now.light, light.light), put(now.ambient, light.ambient);
  light.contrast = now.contrast, light.confidence = now.confidence;
  return light;
}

// Runs one frame, by clock and budget or as recorded.
sandglass_frame_report Run::advance(uint32_t frame, std::vector<sandglass_collider>* colliders) {
  if (shot_) simulation_->see(shot_->estimator(), shot_->image());
  if (shot_ || scene_.light) {
    const Vec3 towards =
        shot_ ? shot_->light(frame).towards : scene_.light->towards(static_cast<double>(frame) / scene_.frames);
    shadows_->set_light(scene_, frame, towards);
    if (pile_) pile_->set_light(towards);
  }
  simulation_->flow(flow_over_frame(scene_, frame * scene_.frame_step));
  if (options_.replay.empty()) {
    *colliders = colliders_over_frame(scene_, frame);
    add_rigid_shapes(scene_, simulation_->handle(), scene_.frame_step, colliders);
    return simulation_->frame(scene_.frame_step, static_cast<uint64_t>(scene_.budget_ms * 1e6), *colliders, nullptr,
                              shadows_->handles());
  }
  const RecordedFrame& recorded = recording_.frames[frame];
  *colliders = recorded.colliders;
  // A recording names only the shapes. The fields behind them come from the scene.
  for (size_t i = 0; i < colliders->size() && i < scene_.colliders.size(); ++i)
    (*colliders)[i].field = scene_.colliders[i].field;
  return simulation_->frame(static_cast<double>(recorded.time_step), recorded.budget_ns, *colliders, &recorded.plan,
                            shadows_->handles());
}

void Run::take_snapshot(uint32_t frame, std::vector<sandglass_collider> colliders) {
  Snapshot snapshot;
  snapshot.frame = frame, snapshot.time = frame * scene_.frame_step;
  snapshot.grains = present(simulation_->grain_positions()),
  snapshot.particles = present(simulation_->particle_positions());
  snapshot.shadows = shadows_->drawn(colliders);
  if (pile_) snapshot.pile = {pile_->drawn(false)}, snapshot.pile_surface = {pile_->drawn(true)};
  snapshot.colliders = std::move(colliders);
  if (scene_.light) snapshot.to_light = scene_.light->towards(static_cast<double>(frame) / scene_.frames);
  if (shot_) snapshot.to_light = shot_->light(frame).towards;
  snapshots_.push_back(std::move(snapshot));
}

void Run::execute() {
  const uint32_t particles = static_cast<uint32_t>(simulation_->particle_positions().size() / 3);
  const uint32_t grains = static_cast<uint32_t>(simulation_->grain_positions().size() / 3);
  const uint32_t step = snapshot_step(scene_.frames, scene_.frame_step, particles, grains);
  const sandglass_clock cpu = clock_thread_cpu();
  Progress progress("simulating " + scene_.name, scene_.frames);
  for (uint32_t frame = 0; frame < scene_.frames && !interrupted(); ++frame) {
    std::vector<sandglass_collider> colliders;
    FrameRow row = {};
    if (shot_) shot_->begin(frame);  // makes the camera's image, which a real app gets from its camera
    row.begin_ns = recorder_.now_ns();
    const uint64_t cpu_from = cpu.now_ns(cpu.user);
    row.report = advance(frame, &colliders);
    row.cpu_ms = static_cast<double>(cpu.now_ns(cpu.user) - cpu_from) * 1e-6;
    row.wall_ms = static_cast<double>(recorder_.now_ns() - row.begin_ns) * 1e-6;
    row.light = light_of(frame);
    report_.frames.push_back(row);
    if (!options_.record.empty())
      recording_.frames.push_back(
          {static_cast<float>(scene_.frame_step), row.report.budget_ns, colliders, row.report.plan});
    if (!options_.dump.empty()) dump_frame(options_.dump, frame + 1, scene_.particle_radius, &*simulation_);
    if (!options_.out.empty() && ((frame + 1) % step == 0 || frame + 1 == scene_.frames))
      take_snapshot(frame + 1, colliders);
    progress.done(frame + 1);
  }
  report_.interrupted = interrupted();
  if (report_.interrupted && !options_.out.empty())
    std::fprintf(stderr, "sandglass: interrupted; reports and sheet of %zu frames follow. Ctrl-C again ends at once.\n",
                 report_.frames.size());
  report_.units = std::move(recorder_.events);
}

}  // namespace sandglass::host
