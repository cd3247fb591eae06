#include "models/laboratory/shot/verify_shot.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <memory>

#include "models/compositing/light_estimate.h"
#include "models/files/atomic_file.h"
#include "models/rooms/panorama_file.h"
#include "models/rooms/probe_scene.h"
#include "models/simulation/body_meshes.h"
#include "models/simulation/collision_fields.h"
#include "models/simulation/pile_shadow.h"
#include "models/simulation/simulation.h"
#include "models/simulation/standing_shadows.h"
#include "models/work/failure.h"
#include "runtime/core/hash.h"
#include "runtime/core/random.h"

namespace sandglass::host {

namespace fs = std::filesystem;

namespace {

constexpr uint32_t k_settling_frames = 75;  // 1.5 s: the knot has become a heap
constexpr uint64_t k_azimuth_stream = 61;
constexpr int k_points = 8;  // of a composite's pixel and axis: its own noise counts as little as the truth's

// The scene with its sand at rest; the light is set view by view.
struct Stage {
  SceneFile scene = load_scene("shot");
  std::vector<float> particles, grains;
  float grain_radius = 0.0f;
  Mesh object;

  Stage() {
    const LoadedMeshes meshes(scene, "");
    const Material material = fill_scene(&scene, meshes.bodies());
    const CollisionFields fields(&scene, "");
    Simulation simulation(describe_filled(scene, material));
    simulation.add(material);
    for (uint32_t frame = 0; frame < k_settling_frames; ++frame)
      simulation.frame(scene.frame_step, UINT64_MAX, colliders_over_frame(scene, frame));
    particles = simulation.particle_positions(), grains = simulation.grain_positions();
    grain_radius = drawn_grain_radius(scene.particle_radius, static_cast<uint32_t>(particles.size() / 3),
                                      static_cast<uint32_t>(grains.size() / 3));
    object = standing_object(scene, "");
  }

  enum class Sand { grains, particles };
  std::unique_ptr<PileShadow> pile_for(Vec3 towards, Sand of) const {
    auto pile = std::make_unique<PileShadow>(*scene.pile_shadow, SANDGLASS_ISA_AUTOMATIC);
    pile->set_light(towards);
    const std::vector<float>& spheres = of == Sand::grains ? grains : particles;
    sandglass_pile_shadow_run(pile->handle(), spheres.data(), static_cast<uint32_t>(spheres.size() / 3),
                              of == Sand::grains ? grain_radius : static_cast<float>(scene.particle_radius), ~0u);
    return pile;
  }

  ShotShadows shadows_for(Vec3 towards) const {
    StandingShadows standing(scene, SANDGLASS_ISA_AUTOMATIC);
    standing.set_light(scene, 0, towards);
    sandglass_shadow_run(standing.handles().data(), static_cast<uint32_t>(standing.handles().size()), ~0u);
    const std::unique_ptr<PileShadow> pile = pile_for(towards, Sand::grains);  // as in a frame
    const std::vector<sandglass_collider> colliders = colliders_over_frame(scene, 0);
    return {standing.drawn(colliders), {pile->drawn(false)}, {pile->drawn(true)}};
  }
};

void put(const ShotErrors& e, double (&row)[k_shot_metrics]) {
  const double values[k_shot_metrics] = {e.image.rmse,
                                         e.image.relative,
                                         e.image.scale_invariant,
                                         e.image.logarithmic,
                                         e.image.angle_deg,
                                         1.0 - e.similarity,
                                         e.flip};
  std::copy_n(values, k_shot_metrics, row);
}

// Names alone would take a retrained network's rows for those of the one before it.
uint64_t hash_of(const std::string& file, const std::string& kind) {
  const std::string bytes = read_file(file, kind);
  return hash_bytes(bytes.data(), bytes.size());
}

std::string key_of(const ShotStudyOptions& o) {
  const uint64_t network = o.network.empty() ? 0 : hash_of(o.network, "lighting network");
  return "shot study 8." + std::to_string(o.seed) + ": " + std::to_string(o.width) + " x " + std::to_string(o.height) +
         ", " + std::to_string(o.paths) + " paths, network " + std::to_string(network);
}

// The views that are asked for, none of them done: what is wrong with a file is said now, not after minutes.
std::vector<ShotView> planned_views(const ShotStudyOptions& options) {
  if (!options.network.empty()) LightEstimate(options.network, SANDGLASS_ISA_AUTOMATIC);
  std::vector<ShotView> views(std::min(options.views, options.panoramas.size()));
  for (size_t i = 0; i < views.size(); ++i) {
    read_panorama(options.panoramas[i]);
    views[i].panorama = fs::path(options.panoramas[i]).stem().string();
    views[i].panorama_hash = hash_of(options.panoramas[i], "panorama");
    views[i].azimuth_deg = 360.0 * random_stream(i, k_azimuth_stream + options.seed).uniform();
  }
  return views;
}

void study_view(const ShotStudyOptions& options, const Stage& stage, const ShotPicture& picture, size_t index,
                ShotView* view) {
  RadianceMap map = read_panorama(options.panoramas[index]);
  fill_tripod(&map);
  const Surroundings room = panorama_surroundings(std::move(map), view->panorama, *stage.scene.camera,
                                                  view->azimuth_deg, {}, k_unknown_depth_insertion);
  const ShotCamera camera = resting_camera(*stage.scene.camera);
  ShotPictureOptions o;
  o.width = options.width, o.height = options.height, o.paths = options.paths, o.threads = options.threads;
  o.samples = k_points;
  const RadianceMap truth = picture.truth(room, camera, o);
  const ShotLight labels = labelled_light(room), arbitrary = arbitrary_light(camera);
  std::vector<Picture> cells = {displayed_picture(truth)};
  const auto measure = [&](ShotVariant variant, const ShotLight& light, CastShadow cast) {
    const RadianceMap made = picture.composite(room, camera, light, stage.shadows_for(light.towards), cast, o);
    put(shot_errors(truth, made), view->errors[static_cast<int>(variant)]);
    cells.push_back(displayed_picture(made));
  };
  measure(ShotVariant::labels, labels, CastShadow::textures);
  measure(ShotVariant::no_shadow, labels, CastShadow::none);
  measure(ShotVariant::hard_shadow, labels, CastShadow::hard);
  measure(ShotVariant::arbitrary_light, arbitrary, CastShadow::textures);
  measure(ShotVariant::no_curve, labels, CastShadow::no_curve);
  if (!options.network.empty()) {
    LightEstimate estimate(options.network, SANDGLASS_ISA_AUTOMATIC);
    estimate.take(room, camera, 0);
    estimate.finish();
    const ShotLight light = estimate.light();
    measure(ShotVariant::estimate, light, CastShadow::textures);
    view->has_estimate = true;
    view->angle_deg = std::acos(std::clamp(dot(light.towards, labels.towards), -1.0, 1.0)) * 180.0 / 3.141592653589793;
  }
  if (!options.folder.empty())
    write_png((fs::path(options.folder) / ("view_" + std::to_string(index) + ".png")).string(),
              picture_grid(cells, static_cast<int>(cells.size()), 2));
  view->done = true;
}

using PilePart = PileShadowError::Part;

// What each texture shows of a place, or of some together: the shadow itself, then the controls.
constexpr size_t k_textures = 3;
constexpr double PilePart::*k_errors_of[k_textures] = {&PilePart::rmse, &PilePart::particles, &PilePart::mirrored};

void add_texel(PilePart* part, double truth, const double (&shown)[k_textures], double places) {
  const double real = truth / places;
  const auto square = [&](double seen) { return (seen - real) * (seen - real); };
  for (size_t t = 0; t < k_textures; ++t) part->*k_errors_of[t] += square(shown[t] / places);
  part->without += square(1.0), part->bias += shown[0] / places - real, ++part->texels;
}

void finish(PilePart* sums) {
  const double n = std::max(1, sums->texels);
  for (double PilePart::*sum : {&PilePart::rmse, &PilePart::particles, &PilePart::mirrored, &PilePart::without})
    sums->*sum = std::sqrt(sums->*sum / n);
  sums->bias /= n;
}

}  // namespace

std::vector<PileShadowError> study_pile_shadow() {
  constexpr double k_degree = 3.141592653589793 / 180.0, k_lit = 0.98;
  constexpr uint32_t k_stride = 3;         // texels
  constexpr int k_places = 3, k_rays = 4;  // a texel and axis; a place and axis
  const Stage stage;
  const ShotPicture picture(stage.object, stage.grains, stage.grain_radius);
  std::vector<PileShadowError> all;
  // Within what textures are made for, 70 degrees.
  for (const double polar : {20.0, 45.0, 65.0})
    for (const double azimuth : {30.0, 150.0, 270.0}) {
      const Vec3 towards = {std::sin(polar * k_degree) * std::cos(azimuth * k_degree), std::cos(polar * k_degree),
                            std::sin(polar * k_degree) * std::sin(azimuth * k_degree)};
      const std::unique_ptr<PileShadow> piles[k_textures] = {
          stage.pile_for(towards, Stage::Sand::grains), stage.pile_for(towards, Stage::Sand::particles),
          stage.pile_for({-towards.x, towards.y, -towards.z}, Stage::Sand::grains)};
      FloorShadow on_floor[k_textures], on_sand[k_textures];
      for (size_t t = 0; t < k_textures; ++t) on_floor[t] = piles[t]->drawn(false), on_sand[t] = piles[t]->drawn(true);
      const FloorShadow& texture = on_floor[0];
      PileShadowError e = {polar, azimuth, {}, {}, {}};
      for (uint32_t v = 0; v < texture.texels; v += k_stride)
        for (uint32_t u = 0; u < texture.texels; u += k_stride) {
          double truth = 0.0, seen = 0.0, lit = 0.0, facing = 0.0, shown[k_textures] = {}, drawn[k_textures] = {};
          for (int i = 0; i < k_places * k_places; ++i) {
            const double across = (u + (i % k_places + 0.5) / k_places) / texture.texels,
                         along = (v + (i / k_places + 0.5) / k_places) / texture.texels;
            const double x = texture.low[0] + across * (texture.high[0] - texture.low[0]);
            const double z = texture.low[1] + along * (texture.high[1] - texture.low[1]);
            if (picture.grains_leave(x, z, {0, 1, 0}, 0.0, 1) == 0.0) {  // under a grain
              double cosine = 0.0;
              const double open = picture.grain_lit(x, z, towards, k_light_half_angle_deg * k_degree, k_rays, &cosine);
              lit += cosine * open, facing += cosine;
              for (size_t t = 0; t < k_textures; ++t) drawn[t] += cosine * floor_transparency(on_sand[t], x, z);
              continue;
            }
            truth += picture.grains_leave(x, z, towards, k_light_half_angle_deg * k_degree, k_rays);
            seen += 1.0;
            for (size_t t = 0; t < k_textures; ++t) shown[t] += floor_transparency(on_floor[t], x, z);
          }
          if (facing > 0.0) add_texel(&e.on_sand, lit, drawn, facing);
          if (seen == 0.0 || (truth > k_lit * seen && shown[0] > k_lit * seen)) continue;
          add_texel(seen == k_places * k_places ? &e.clear : &e.among_grains, truth, shown, seen);
        }
      for (PilePart* part : {&e.clear, &e.among_grains, &e.on_sand}) finish(part);
      all.push_back(e);
    }
  return all;
}

ShotStudy study_shots(const ShotStudyOptions& options, const std::function<bool(size_t done)>& progress) {
  ShotStudy study;
  study.views = planned_views(options);
  if (study.views.empty()) return study;
  const std::string key = key_of(options);
  const std::string memory = options.folder.empty() ? "" : (fs::path(options.folder) / "views.txt").string();
  std::error_code ignored;
  if (!memory.empty() && fs::is_regular_file(memory, ignored)) remember(read_file(memory, "study"), key, &study.views);
  const Stage stage;
  const ShotPicture picture(stage.object, stage.grains, stage.grain_radius);
  size_t done = 0;
  for (size_t i = 0; i < study.views.size(); ++i) {
    if (!study.views[i].done) {
      study_view(options, stage, picture, i, &study.views[i]);
      std::string text = key + "\n";
      for (const ShotView& view : study.views)
        if (view.done) text += line_of(view);
      if (!memory.empty()) write_file(memory, text);
    }
    if (!progress(++done)) break;
  }
  take_means(&study);
  return study;
}

}  // namespace sandglass::host
