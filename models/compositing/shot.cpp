#include "models/compositing/shot.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numbers>

#include "models/files/failure.h"
#include "models/lighting/lit_view.h"
#include "models/mesh/generated.h"
#include "models/rooms/panorama_file.h"
#include "models/simulation/scene_meshes.h"
#include "models/simulation/scene_shadows.h"
#include "models/work/random.h"
#include "runtime/light/harmonics.h"
#include "sandglass/pile_shadow.h"
#include "sandglass/shadow.h"

namespace sandglass::host {

namespace {

constexpr int k_compared_width = 640, k_compared_height = 480, k_compared_paths = 96;
constexpr uint64_t k_noise_stream = 71;

Surroundings captured(const SceneFile& scene, const std::string& file, Vec3 standing, double insertion,
                      const Camera& camera) {
  RadianceMap map = read_panorama(file);
  fill_tripod(&map);
  return panorama_surroundings(std::move(map), file, camera, scene.shot->azimuth_deg, standing, insertion);
}

Surroundings surroundings_of(const SceneFile& scene, const ShotOptions& options, Vec3 standing, Camera* camera) {
  const ShotTrack& track = *scene.shot;
  if (!options.photo.empty()) return photo_surroundings(options.photo, options.photo_fov_deg, camera);
  if (options.panorama.empty() && !track.kept.empty())
    return panorama_surroundings(kept_room(track.kept), track.kept, *camera, track.azimuth_deg, standing,
                                 k_object_insertion);
  if (options.panorama.empty())
    return room_surroundings(track.room, options.folder, options.threads, *camera, track.azimuth_deg, standing);
  return captured(scene, options.panorama, standing, k_object_insertion, *camera);
}

// This runs before anything is traced, so a mistake is reported at once.
LightSource source_of(const ShotOptions& options) {
  if (options.light == LightSource::truth && !options.photo.empty())
    throw Failure("cannot use \"--light truth\": a photograph has none. Take another --light, or a --panorama.");
  if (options.light == LightSource::estimate && shipped_light_network().empty())
    throw Failure("cannot estimate light: no lighting network is shipped here. Take --light room.");
  return options.light;
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
  options.width = k_compared_width;
  options.height = k_compared_height;
  options.paths = k_compared_paths;
  options.threads = threads;
  return options;
}

// sandglass_shadow_transfer of every corner of every triangle, by its own normal: creases stay sharp.
std::vector<float> surface_of(const ColliderTrack& track, const Mesh& mesh) {
  const std::string path = find_shadow(track.shadow);
  const AlignedBytes file = read_aligned(path, "baked shadow");
  const sandglass_shadow_info info = inspect_shadow(file, path);
  if (info.surface_vertices == 0) return {};
  const double scale = static_cast<double>(info.height) / track.size.y;
  std::vector<float> places, normals, transfer;
  for (size_t t = 0; t < mesh.indices.size(); t += 3) {
    Vec3 corners[3];
    for (size_t k = 0; k < 3; ++k)
      corners[k] = from_floats(mesh.vertices.data() + 3 * static_cast<size_t>(mesh.indices[t + k])) * scale +
                   from_floats(info.origin);
    const Vec3 across = cross(corners[1] - corners[0], corners[2] - corners[0]);
    const Vec3 normal = length(across) > 0.0 ? normalised(across) : Vec3{0, 1, 0};
    for (const Vec3 corner : corners)
      for (const auto& [array, v] : {std::pair(&places, corner), std::pair(&normals, normal)})
        for (const double x : {v.x, v.y, v.z}) array->push_back(static_cast<float>(x));
  }
  const sandglass_shadow_desc asset = cpp::shadow_desc(file.data(), file.size());
  if (const cpp::Status read = cpp::shadow_transfer(asset, places, normals, &transfer); !read)
    throw cannot("read", path, read.reason);
  return transfer;
}

// Of the three corners of each triangle: the mean, by area, of the triangles there that are turned by less than 40 degrees.
void add_smooth_normals(const Mesh& mesh, const Quaternion& rotation, std::vector<float>* normals) {
  constexpr double k_crease = 0.766;
  std::vector<Vec3> faces;
  std::vector<std::vector<size_t>> at(mesh.vertex_count());
  const auto corner = [&](size_t i) { return from_floats(mesh.vertices.data() + 3 * size_t{mesh.indices[i]}); };
  for (size_t i = 0; i < mesh.indices.size(); ++i) at[mesh.indices[i]].push_back(i / 3);
  for (size_t i = 0; i < mesh.indices.size(); i += 3)
    faces.push_back(cross(corner(i + 1) - corner(i), corner(i + 2) - corner(i)));
  for (size_t i = 0; i < mesh.indices.size(); ++i) {
    const Vec3 own = faces[i / 3];
    Vec3 sum = own;
    for (const size_t other : at[mesh.indices[i]])
      if (other != i / 3 && dot(own, faces[other]) > k_crease * length(own) * length(faces[other]))
        sum = sum + faces[other];
    const Vec3 n = rotate(rotation, normalised(sum));
    for (const double x : {n.x, n.y, n.z}) normals->push_back(static_cast<float>(x));
  }
}

// An object without a bake, beside the standing one: each point is lit by its normal, less what the object as a whole hides
// from itself. In the frame of the standing object.
// Metal comes after all that is painted.
void add_casting(const ColliderTrack& track, const Quaternion& frame, LitObject* object) {
  MeshResult made = make_named(track.mesh);
  stand_mesh(&made.mesh, track.size.y, track.mesh);
  sandglass_cast_desc desc = cpp::cast_desc();
  desc.texels = 0;
  desc.triangle_capacity = made.mesh.triangle_count();
  cpp::Cast cast;
  if (const cpp::Status status = cast.create(desc); !status) throw cannot("cast", track.mesh, status.reason);
  sandglass_cast_mesh casting = cpp::cast_mesh();
  casting.positions = made.mesh.vertices.data();
  casting.vertex_count = made.mesh.vertex_count();
  casting.indices = made.mesh.indices.data();
  casting.triangle_count = made.mesh.triangle_count();
  casting.closed = 1;
  if (const cpp::Status status = cast.set_meshes(&casting, 1); !status) throw cannot("cast", track.mesh, status.reason);
  cast.run();
  const auto open = static_cast<double>(cast.report().open);
  const auto first = static_cast<uint32_t>(object->mesh.vertices.size() / 3);
  if (track.metal) {
    if (object->metal_from == UINT32_MAX) object->metal_from = object->mesh.triangle_count();
    add_smooth_normals(made.mesh, track.rotation, &object->metal_normals);
  }
  std::vector<float>& v = made.mesh.vertices;
  for (size_t i = 0; i < v.size(); i += 3)
    to_floats(rotate(track.rotation, from_floats(v.data() + i)) + track.position, v.data() + i);
  object->mesh.vertices.insert(object->mesh.vertices.end(), v.begin(), v.end());
  for (size_t t = 0; t < made.mesh.indices.size(); t += 3) {
    Vec3 corners[3];
    for (size_t k = 0; k < 3; ++k) {
      object->mesh.indices.push_back(first + made.mesh.indices[t + k]);
      corners[k] = from_floats(v.data() + 3 * static_cast<size_t>(made.mesh.indices[t + k]));
    }
    const Vec3 across = cross(corners[1] - corners[0], corners[2] - corners[0]);
    const Vec3 n = rotate(conjugate(frame), length(across) > 0.0 ? normalised(across) : Vec3{0, 1, 0});
    const double normal[3] = {n.x, n.y, n.z};
    double polynomials[k_harmonics];
    harmonic_polynomials(normal, polynomials);
    for (size_t k = 0; k < 3 && !object->transfer.empty(); ++k)
      for (uint32_t j = 0; j < k_harmonics; ++j)
        object->transfer.push_back(
            static_cast<float>(open * k_cosine_factors[j] * k_harmonic_factors[j] * polynomials[j]));
  }
}

constexpr uint32_t k_sky_share = 2;  // the texture of the room's light on sand is coarser by this

}  // namespace

const char* name_of(LightSource source) {
  constexpr const char* k_names[] = {"room", "truth", "estimate", "nothing"};
  return k_names[static_cast<int>(source)];
}

ShotErrors shot_errors(const RadianceMap& truth, const RadianceMap& picture) {
  return {root_mean_square_error(truth, picture), structural_similarity(truth, picture), flip(truth, picture)};
}

std::string shot_errors_text(const ShotErrors& e) {
  char text[100];
  std::snprintf(text, sizeof text, "RMSE %.4f  SSIM %.4f  FLIP %.4f", e.rmse, e.similarity, e.flip);
  return text;
}

namespace {

// From one pose to another.
void place(LitObject* object, const Quaternion& from, Vec3 at, const Quaternion& to, Vec3 there) {
  const Quaternion turn = multiply(to, conjugate(from));
  std::vector<float>& v = object->mesh.vertices;
  for (size_t i = 0; i < 3 * size_t{object->moving}; i += 3)
    to_floats(rotate(turn, from_floats(v.data() + i) - at) + there, v.data() + i);
  object->rotation = to;
}

}  // namespace

LitObject standing_object(const SceneFile& scene, const MeshFile& mesh_file) {
  const std::string& file = mesh_file.path;
  const ColliderTrack& track = standing_track(scene);
  MeshResult loaded = file.empty() ? make_named(track.mesh) : load_mesh(mesh_file);
  if (!loaded) throw Failure(loaded.error);
  stand_mesh(&loaded.mesh, track.size.y, file);
  require_baked_of(track, loaded.mesh, file.empty() ? track.mesh : file);
  constexpr double k_longest = 1.0 / 16;  // of the height
  // What is interpolated between corners is then not straight over a whole leg.
  LitObject object;
  object.mesh = with_short_edges(loaded.mesh, k_longest * track.size.y);
  object.rotation = track.rotation;
  object.transfer = surface_of(track, object.mesh);
  object.moving = object.mesh.vertex_count();
  place(&object, k_no_rotation, {}, track.rotation, track.position);
  for (const bool metal : {false, true})
    for (const ColliderTrack& other : scene.colliders)
      if (other.casts && other.metal == metal) add_casting(other, track.rotation, &object);
  return object;
}

SceneShadows complete_shadows(const SceneFile& scene, sandglass_isa isa, uint32_t frame,
                              const std::vector<sandglass_collider>& colliders, std::span<const float> particles,
                              const PlacedLight& light) {
  StandingShadows standing(scene, isa);
  standing.set_light(scene, frame, main_direction_of(light.object));
  standing.set_cells(scene, frame, light.object.ambient_cells);
  standing.complete();
  SceneShadows shadows;
  standing.draw(colliders, &shadows);
  if (!scene.pile_shadow) return shadows;
  PileShadow pile(*scene.pile_shadow, isa, scene.pile_shadow->texels / k_sky_share);
  pile.set_light(main_direction_of(light.sand));
  pile.set_cells(light.sand.ambient_cells);
  SandShaper().shape({particles, {}, colliders, static_cast<float>(scene.particle_radius)}, pile.handle());
  pile.draw(&shadows);
  return shadows;
}

namespace {

// A Gaussian along one axis; the border continues outside.
RadianceMap blurred(const RadianceMap& map, double deviation, int step_x, int step_y) {
  const int reach = static_cast<int>(std::ceil(3.0 * deviation));
  RadianceMap out(map.width, map.height);
  for (int y = 0; y < map.height; ++y)
    for (int x = 0; x < map.width; ++x) {
      Vec3 sum;
      double all = 0.0;
      for (int i = -reach; i <= reach; ++i) {
        const double weight = std::exp(-i * i / (2.0 * deviation * deviation));
        sum = sum +
              map.colour(std::clamp(x + i * step_x, 0, map.width - 1), std::clamp(y + i * step_y, 0, map.height - 1)) *
                  weight;
        all += weight;
      }
      out.set(x, y, sum * (1.0 / all));
    }
  return out;
}

}  // namespace

Picture developed(const RadianceMap& shown, double blur_pixels, uint64_t seed) {
  // Of a sensor: noise of the light itself, and of reading it out.
  constexpr double k_shot_noise = 4e-5, k_read_noise = 8e-4;
  const RadianceMap map = blur_pixels > 0.05 ? blurred(blurred(shown, blur_pixels, 1, 0), blur_pixels, 0, 1) : shown;
  Picture picture(map.width, map.height, {0, 0, 0});
  for (size_t i = 0; i < map.rgb.size(); ++i) {
    Random random = random_stream(i, k_noise_stream + seed);
    const double x = static_cast<double>(map.rgb[i]);
    const double normal = normal_deviate(&random);
    picture.rgb[i] = srgb_byte(x + normal * std::sqrt(k_shot_noise * std::max(x, 0.0) + k_read_noise * k_read_noise));
  }
  return picture;
}

Shot::Shot(const SceneFile& scene, const ShotOptions& options)
    : scene_(scene),
      camera_(*scene.camera),
      object_(standing_object(scene, options.mesh)),
      source_(source_of(options)),
      network_(shipped_light_network().empty() ? nullptr
                                               : std::make_unique<LightEstimate>(shipped_light_network(), options.isa)),
      surroundings_(surroundings_of(scene, options, standing_track(scene).position, &camera_)),
      isa_(options.isa) {
  if (surroundings_.has_truth()) {
    // The truth is that of the last frame. The farther the object is carried, the farther it is in the room.
    const Vec3 last = standing_at(scene.frames), eye = resting_camera(camera_).eye;
    const auto away = [eye](Vec3 p) { return length(Vec3{p.x - eye.x, 0, p.z - eye.z}); };
    const double insertion =
        std::min(k_farthest_insertion, surroundings_.insertion * away(last) / away(standing_track(scene).position));
    if (!options.later.empty()) {
      later_ = captured(scene, options.later, last, insertion, camera_);
      later_->exposure = surroundings_.exposure;
    } else if (length(last - standing_track(scene).position) > 0.0) {
      later_ = moved(surroundings_, camera_, last, insertion);
    }
    const Surroundings& room = around(scene.frames);
    truth_ = room.true_light();
    truth_->reflected = room.true_reflected();
    const Vec3 sand = sand_at(scene.frames);
    if (source_ == LightSource::truth)
      truth_->sand =
          moved(room, camera_, sand, std::min(k_farthest_insertion, insertion * away(sand) / away(last))).true_light();
  }
  if (source_ == LightSource::room || source_ == LightSource::nothing) {
    std::vector<SessionImage> images =
        session_images(source_ == LightSource::room ? Session::everything_shorter : Session::table, 1);
    const auto between =
        static_cast<uint64_t>(1e9 * scene.frames * scene.frame_step / static_cast<double>(images.size()));
    seen_ = std::make_unique<SeenLight>(surroundings_, resting_camera(camera_), standing_track(scene_).position,
                                        std::move(images), between);
    if (source_ == LightSource::room) seen_->look_around(surroundings_);
  }
  begin(0);  // what is shown before the first frame
}

Vec3 Shot::standing_at(uint32_t frame) const {
  return from_floats(
      collider_over_frame(standing_track(scene_), frame * scene_.frame_step, scene_.frame_step).position);
}

// The middle of what its shadow covers.
Vec3 Shot::sand_at(uint32_t frame) const {
  if (!scene_.pile_shadow) return standing_at(frame);
  const PileShadowTrack& t = *scene_.pile_shadow;
  return {0.5 * (t.low[0] + t.high[0]), 0.0, 0.5 * (t.low[1] + t.high[1])};
}

ShotCamera Shot::camera(uint32_t frame) const {
  if (!surroundings_.has_truth()) return resting_camera(camera_);  // a photograph has one view
  return held_camera(camera_, *scene_.shot, frame * scene_.frame_step, static_cast<double>(frame) / scene_.frames);
}

void Shot::begin(uint32_t frame) {
  const auto now = static_cast<uint64_t>(std::llround(1e9 * frame * scene_.frame_step));
  PlacedLight light;
  if (source_ == LightSource::truth) {
    light = *truth_;
  } else if (source_ == LightSource::estimate) {
    image_ = network_->take(around(frame), camera(frame), now);
    // Until there is an estimate, a light that an app makes up.
    light = network_->valid() ? network_->light() : arbitrary_light(resting_camera(camera_), {1, 1, 1});
  } else {
    image_ = seen_->take(around(frame), now);
    sandglass_estimator_light estimate = {};
    if (network_) estimate = network_->now();
    light = {seen_->follow(standing_at(frame), scene_.frame_step, &estimate, &shown_[0]),
             seen_->follow(sand_at(frame), scene_.frame_step, &estimate, &shown_[1])};
    for (const ColliderTrack& track : scene_.colliders)
      if (track.metal)
        light.reflected =
            seen_->reflected(track.position + Vec3{0, 0.5 * track.size.y, 0}, 0.5 * track.size.y, shown_[0]);
  }
  lights_.resize(frame);
  lights_.push_back(light);
}

const PlacedLight& Shot::light(uint32_t frame) const { return lights_[std::min<size_t>(frame, lights_.size() - 1)]; }

double Shot::angle_deg(uint32_t frame) const {
  if (!truth_) return -1.0;
  const double cosine = dot(mean_direction_of(light(frame).object), mean_direction_of(truth_->object));
  return std::acos(std::clamp(cosine, -1.0, 1.0)) * 180.0 / std::numbers::pi;
}

ShotPicture Shot::drawing_of(const Snapshot& snapshot) const {
  LitObject object = object_;
  const ColliderTrack& track = standing_track(scene_);
  // As the snapshot has it, at the end of its frame.
  if (!track.motion.empty()) {
    const auto index = static_cast<size_t>(&track - scene_.colliders.data());
    const sandglass_collider& now = snapshot.colliders[index];
    const Quaternion rotation = {now.rotation[0], now.rotation[1], now.rotation[2], now.rotation[3]};
    place(&object, track.rotation, track.position, rotation, from_floats(now.position));
  }
  return {object, snapshot.sand};
}

Picture Shot::developed_as_seen(const RadianceMap& shown, uint64_t seed) const {
  // A panorama's pixels are no smaller than they are.
  constexpr double k_blur = 0.45;
  const ShotCamera rest = resting_camera(camera_);
  const double per_radian = rest.focal * shown.height;
  const double of_room =
      surroundings_.has_truth() ? surroundings_.panorama.width / (2.0 * std::numbers::pi) : surroundings_.photo_focal;
  return developed(shown, k_blur * std::max(1.0, per_radian / of_room), seed);
}

Picture Shot::paint(const Snapshot& snapshot, int width, int height, uint32_t threads) const {
  ShotPictureOptions options;
  options.width = width;
  options.height = height;
  options.threads = threads;
  const RadianceMap shown =
      drawing_of(snapshot).composite(around(snapshot.frame), camera(snapshot.frame), light(snapshot.frame),
                                     snapshot.shadows, CastShadow::textures, options);
  return developed_as_seen(shown, snapshot.frame);
}

RadianceMap Shot::traced(const Snapshot& snapshot, uint32_t threads) const {
  return drawing_of(snapshot).truth(around(snapshot.frame), camera(snapshot.frame), compared(threads));
}

Shot::Drawn Shot::drawn(const Snapshot& snapshot, std::string name, const PlacedLight& light, CastShadow cast,
                        uint32_t threads) const {
  const bool own = &light == &this->light(snapshot.frame);
  const SceneShadows other =
      own ? SceneShadows{}
          : complete_shadows(scene_, isa_, snapshot.frame, snapshot.colliders, snapshot.particles, light);
  return {std::move(name), drawing_of(snapshot).composite(around(snapshot.frame), camera(snapshot.frame), light,
                                                          own ? snapshot.shadows : other, cast, compared(threads))};
}

std::vector<Shot::Drawn> Shot::alternatives(const Snapshot& snapshot, uint32_t threads) const {
  std::vector<Drawn> all;
  SeenLight start(surroundings_, resting_camera(camera_), standing_track(scene_).position,
                  session_images(Session::table, 1), 0);
  start.take(around(snapshot.frame), 0);
  sandglass_room_light shown = {};
  const ShotLight usual = start.follow(standing_at(snapshot.frame), 0.0, nullptr, &shown);
  all.push_back(drawn(snapshot, "no shadow", usual, CastShadow::none, threads));
  if (network_) {
    LightEstimate& network = *network_;
    network.take(around(snapshot.frame), camera(snapshot.frame), 1'000'000'000'000);
    network.finish();
    all.push_back(drawn(snapshot, "one light", network.light(), CastShadow::textures, threads));
  }
  return all;
}

}  // namespace sandglass::host
