#include "models/compositing/shot.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "models/files/failure.h"
#include "models/lighting/lit_view.h"
#include "models/rooms/panorama_file.h"
#include "models/simulation/scene_meshes.h"
#include "models/simulation/scene_shadows.h"
#include "sandglass/pile_shadow.h"
#include "sandglass/shadow.h"

namespace sandglass::host {

namespace {

constexpr int k_compared_width = 640, k_compared_height = 480, k_compared_paths = 96;

Surroundings surroundings_of(const SceneFile& scene, const ShotOptions& options, Vec3 standing, Camera* camera) {
  const ShotTrack& track = *scene.shot;
  if (!options.photo.empty()) return photo_surroundings(options.photo, options.photo_fov_deg, camera);
  if (options.panorama.empty())
    return room_surroundings(track.room, options.folder, options.threads, *camera, track.azimuth_deg, standing);
  RadianceMap map = read_panorama(options.panorama);
  fill_tripod(&map);
  return panorama_surroundings(std::move(map), options.panorama, *camera, track.azimuth_deg, standing,
                               k_unknown_depth_insertion);
}

std::string network_of(const ShotOptions& options) {
  return options.network.empty() ? shipped_light_network() : options.network;
}

// The source of light that the options ask for. This runs before anything is traced, so a mistake is reported at once.
LightSource source_of(const ShotOptions& options) {
  const bool network = !network_of(options).empty(), photo = !options.photo.empty();
  const LightSource source = options.light.value_or(network ? LightSource::estimate
                                                    : photo ? LightSource::arbitrary
                                                            : LightSource::labels);
  if (source == LightSource::labels && photo)
    throw Failure("cannot use \"--light labels\": a photograph has none. Take --light arbitrary, or a --panorama.");
  if (source == LightSource::estimate && !network)
    throw Failure(
        "cannot estimate light: no lighting network is shipped here. Name one with --network, or take --light labels "
        "or arbitrary.");
  return source;
}

const ColliderTrack& standing_track(const SceneFile& scene) {
  for (const ColliderTrack& track : scene.colliders)
    if (!track.shadow.empty()) return track;
  throw cannot("read", scene.source, "a shot needs a collider with a \"shadow\", the object that stands in it",
               "Add one");
}

// The mesh as it stands must agree with the box of the baked shadow to within this share of the height.
constexpr double k_same_shape = 0.03;

void require_baked_of(const ColliderTrack& track, const Mesh& standing, const std::string& name) {
  const std::string path = find_shadow(track.shadow);
  const sandglass_shadow_info info = inspect_shadow(read_aligned(path, "baked shadow"), path);
  double half[2] = {};
  for (size_t i = 0; i < standing.vertices.size(); i += 3)
    for (size_t axis = 0; axis < 2; ++axis)
      half[axis] = std::max(half[axis], std::fabs(static_cast<double>(standing.vertices[i + 2 * axis])));
  const double scale = track.size.y / static_cast<double>(info.height);
  if (std::fabs(half[0] - scale * static_cast<double>(info.half_x)) > k_same_shape * track.size.y ||
      std::fabs(half[1] - scale * static_cast<double>(info.half_z)) > k_same_shape * track.size.y)
    throw cannot("use", path, "it is the shadow of another object than \"" + name + "\"",
                 "Name the file that sandglass bake wrote for this one");
}

ShotPictureOptions compared(uint32_t threads) {
  ShotPictureOptions options;
  options.width = k_compared_width, options.height = k_compared_height;
  options.paths = k_compared_paths, options.threads = threads;
  return options;
}

Picture labelled(Picture picture, const char* label) {
  draw_text(&picture, 9, 9, 2, label, {0, 0, 0});
  draw_text(&picture, 8, 8, 2, label, {255, 255, 255});
  return picture;
}

}  // namespace

const char* name_of(LightSource source) {
  constexpr const char* k_names[] = {"labels", "estimate", "arbitrary"};
  return k_names[static_cast<int>(source)];
}

ShotErrors shot_errors(const RadianceMap& truth, const RadianceMap& picture) {
  return {compare(truth, picture), structural_similarity(truth, picture), flip(truth, picture)};
}

std::string shot_errors_text(const ShotErrors& e) {
  char text[200];
  std::snprintf(text, sizeof text, "RMSE %.4f  nRMSE %.4f  siRMSE %.4f  RMLE %.4f  RGB %.2f deg  SSIM %.4f  FLIP %.4f",
                e.image.rmse, e.image.relative, e.image.scale_invariant, e.image.logarithmic, e.image.angle_deg,
                e.similarity, e.flip);
  return text;
}

Mesh standing_object(const SceneFile& scene, const std::string& file) {
  const ColliderTrack& track = standing_track(scene);
  MeshResult loaded = file.empty() ? make_named(track.mesh) : load_mesh(file);
  if (!loaded) throw Failure(loaded.error);
  stand_mesh(&loaded.mesh, track.size.y, file);
  require_baked_of(track, loaded.mesh, file.empty() ? track.mesh : file);
  std::vector<float>& v = loaded.mesh.vertices;
  for (size_t i = 0; i < v.size(); i += 3) {
    const Vec3 at = rotate(track.rotation, Vec3{v[i], v[i + 1], v[i + 2]}) + track.position;
    v[i] = static_cast<float>(at.x), v[i + 1] = static_cast<float>(at.y), v[i + 2] = static_cast<float>(at.z);
  }
  return loaded.mesh;
}

ShotShadows complete_shadows(const SceneFile& scene, sandglass_isa isa, uint32_t frame,
                             const std::vector<sandglass_collider>& colliders, std::span<const float> grains,
                             float grain_radius, Vec3 towards) {
  StandingShadows standing(scene, isa);
  standing.set_light(scene, frame, towards);
  sandglass_shadow_run(standing.handles().data(), static_cast<uint32_t>(standing.handles().size()), ~0u);
  ShotShadows shadows = {standing.drawn(colliders), {}, {}};
  if (!scene.pile_shadow) return shadows;
  PileShadow pile(*scene.pile_shadow, isa);
  pile.set_light(towards);
  sandglass_pile_shadow_run(pile.handle(), grains.data(), static_cast<uint32_t>(grains.size() / 3), grain_radius, ~0u);
  shadows.pile = {pile.drawn(false)}, shadows.pile_surface = {pile.drawn(true)};
  return shadows;
}

Shot::Shot(const SceneFile& scene, const ShotOptions& options)
    : scene_(scene),
      camera_(*scene.camera),
      object_(standing_object(scene, options.mesh)),
      source_(source_of(options)),
      estimate_(source_ == LightSource::estimate ? std::make_unique<LightEstimate>(network_of(options), options.isa)
                                                 : nullptr),
      surroundings_(surroundings_of(scene, options, standing_track(scene).position, &camera_)),
      isa_(options.isa) {
  if (surroundings_.has_truth()) labels_ = labelled_light(surroundings_);
}

ShotCamera Shot::camera(uint32_t frame) const {
  if (!surroundings_.has_truth()) return resting_camera(camera_);  // a photograph has one view
  return held_camera(camera_, *scene_.shot, frame * scene_.frame_step, static_cast<double>(frame) / scene_.frames);
}

void Shot::begin(uint32_t frame) {
  const ShotCamera held = camera(frame);
  ShotLight light = arbitrary_light(resting_camera(camera_));
  if (source_ == LightSource::labels) {
    // The labels take the way of an estimate: into the camera's axes, then back through its pose.
    light = labels_;
    light.towards = held.to_scene(held.to_camera(labels_.towards));
  } else if (source_ == LightSource::estimate) {
    const auto now = static_cast<uint64_t>(1e9 * frame * scene_.frame_step);
    image_ = estimate_->take(surroundings_, held, now);
    if (estimate_->valid()) light = estimate_->light();
  }
  lights_.resize(frame);
  lights_.push_back(light);
}

ShotLight Shot::light(uint32_t frame) const {
  if (lights_.empty()) return source_ == LightSource::labels ? labels_ : arbitrary_light(resting_camera(camera_));
  return lights_[std::min<size_t>(frame, lights_.size() - 1)];
}

double Shot::angle_deg(uint32_t frame) const {
  if (!surroundings_.has_truth()) return -1.0;
  return std::acos(std::clamp(dot(light(frame).towards, labels_.towards), -1.0, 1.0)) * 180.0 / 3.141592653589793;
}

float Shot::drawn_radius(const Snapshot& snapshot) const {
  return drawn_grain_radius(scene_.particle_radius, static_cast<uint32_t>(snapshot.particles.size() / 3),
                            static_cast<uint32_t>(snapshot.grains.size() / 3));
}

ShotPicture Shot::drawing_of(const Snapshot& snapshot) const {
  return {object_, snapshot.grains, drawn_radius(snapshot)};
}

RadianceMap Shot::composite(const Snapshot& snapshot, const ShotLight& light, const ShotPictureOptions& options) const {
  return drawing_of(snapshot).composite(surroundings_, camera(snapshot.frame), light,
                                        {snapshot.shadows, snapshot.pile, snapshot.pile_surface}, CastShadow::textures,
                                        options);
}

Picture Shot::paint(const Snapshot& snapshot, int width, int height, uint32_t threads) const {
  ShotPictureOptions options;
  options.width = width, options.height = height, options.threads = threads;
  return picture_of(composite(snapshot, light(snapshot.frame), options));
}

Snapshot Shot::relit(const Snapshot& snapshot, Vec3 towards) const {
  Snapshot now = snapshot;
  ShotShadows shadows =
      complete_shadows(scene_, isa_, now.frame, now.colliders, now.grains, drawn_radius(now), towards);
  now.to_light = towards, now.shadows = std::move(shadows.object);
  now.pile = std::move(shadows.pile), now.pile_surface = std::move(shadows.pile_surface);
  return now;
}

RadianceMap Shot::traced(const Snapshot& snapshot, const std::string& folder, uint32_t threads) const {
  RadianceMap real = drawing_of(snapshot).truth(surroundings_, camera(snapshot.frame), compared(threads));
  write_png(folder + "/truth.png", picture_of(real));
  return real;
}

ShotErrors Shot::compare(const Snapshot& snapshot, const ShotLight& light, const RadianceMap& real,
                         const std::string& folder, const std::string& name, uint32_t threads) const {
  const RadianceMap picture = composite(snapshot, light, compared(threads));
  RadianceMap difference(picture.width, picture.height), seen(picture.width, picture.height);
  const std::vector<double> flips = flip_map(real, picture);
  for (size_t i = 0; i < picture.rgb.size(); ++i) difference.rgb[i] = 4.0f * std::fabs(picture.rgb[i] - real.rgb[i]);
  for (size_t i = 0; i < flips.size(); ++i)
    for (size_t c = 0; c < 3; ++c) seen.rgb[3 * i + c] = static_cast<float>(flips[i]);
  const Picture cells[] = {labelled(picture_of(picture), "composite"), labelled(picture_of(real), "path traced"),
                           labelled(picture_of(difference), "difference x 4"), labelled(picture_of(seen), "FLIP")};
  write_png(folder + "/composite" + name + ".png", picture_of(picture));
  write_png(folder + "/beside_truth" + name + ".png", picture_grid(cells, 2, 4));
  return shot_errors(real, picture);
}

}  // namespace sandglass::host
