#include "models/compositing/surroundings.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <numbers>

#include "models/files/image.h"
#include "models/rooms/excerpt.h"
#include "models/rooms/panorama_file.h"
#include "models/rooms/room_render.h"

namespace sandglass::host {

namespace fs = std::filesystem;

namespace {

constexpr double k_pi = std::numbers::pi;
constexpr int k_room_width = 1024, k_room_samples = 48;
// Limits of the light's radiometry.
constexpr double k_most_contrast = 0.95, k_least_cosine = 0.1, k_most_strength = 64.0;
constexpr double k_picture_aspect = 4.0 / 3.0;
constexpr double k_room_insertion = 0.6;  // (5.22) for rooms like these, where the farthest surface is 4 m away

RadianceMap linear_photo(const Picture& picture) {
  RadianceMap photo(picture.width, picture.height);
  for (size_t i = 0; i < photo.rgb.size(); ++i) photo.rgb[i] = static_cast<float>(linear_of(picture.rgb[i]));
  return photo;
}

// The photograph's colour, interpolated bilinearly. Outside, the border's colour continues.
Vec3 photo_at(const RadianceMap& photo, double x, double y) {
  const double u = std::clamp(x - 0.5, 0.0, photo.width - 1.0), v = std::clamp(y - 0.5, 0.0, photo.height - 1.0);
  const int u0 = static_cast<int>(u), v0 = static_cast<int>(v);
  const int u1 = std::min(u0 + 1, photo.width - 1), v1 = std::min(v0 + 1, photo.height - 1);
  const double fu = u - u0, fv = v - v0;
  return (photo.colour(u0, v0) * (1 - fu) + photo.colour(u1, v0) * fu) * (1 - fv) +
         (photo.colour(u0, v1) * (1 - fu) + photo.colour(u1, v1) * fu) * fv;
}

}  // namespace

Vec3 Surroundings::seen(const ShotCamera& camera, Vec3 direction) const {
  if (has_truth()) return limited(tone_mapped(look_up(panorama, direction), white));
  const Vec3 d = camera.to_camera(direction);
  const double scale = photo_focal / d.z;
  return photo_at(photo, 0.5 * photo.width + d.x * scale, 0.5 * photo.height + d.y * scale);
}

Vec3 Surroundings::shown(Vec3 radiance) const { return limited(has_truth() ? tone_mapped(radiance, white) : radiance); }

Vec3 shadow_opacity(const ShotLight& light) {
  const double o = light.contrast, lit = luminance(light.light), rest = luminance(light.ambient);
  if (!(lit > 0.0) || !(rest > 0.0)) return {o, o, o};
  const auto of = [&](double c, double a) {
    const double direct = o * c / lit, left = (1.0 - o) * a / rest;
    return direct > 0.0 ? direct / (direct + left) : 0.0;
  };
  return {of(light.light.x, light.ambient.x), of(light.light.y, light.ambient.y), of(light.light.z, light.ambient.z)};
}

Surroundings panorama_surroundings(RadianceMap panorama, const std::string& name, const Camera& camera,
                                   double azimuth_deg, Vec3 standing, double insertion) {
  Surroundings s;
  s.name = name;
  s.white = greatest_luminance(panorama);
  const Vec3 ahead = camera.target - camera.eye;
  const double turn = azimuth_deg * k_pi / 180.0 - std::atan2(ahead.z, ahead.x);
  const int w = panorama.width, shift = static_cast<int>(std::lround(turn / (2.0 * k_pi) * w));
  s.panorama = RadianceMap(w, panorama.height);
  for (int v = 0; v < panorama.height; ++v)
    for (int u = 0; u < w; ++u) s.panorama.set(u, v, panorama.colour(((u + shift) % w + w) % w, v));
  // The view towards the object is level, as if the object stood at the height of the eye. From a place below the eye,
  // the upper half of the warped panorama would show a part of the floor.
  const Vec3 to = standing - camera.eye;
  s.view = {0.5 * k_pi, std::atan2(to.z, to.x)};
  s.warped = warp(s.panorama, s.view, insertion);
  return s;
}

Surroundings room_surroundings(uint32_t seed, const std::string& folder, uint32_t threads, const Camera& camera,
                               double azimuth_deg, Vec3 standing) {
  const std::string path =
      folder.empty() ? std::string() : (fs::path(folder) / ("room_" + std::to_string(seed) + ".hdr")).string();
  std::error_code ignored;
  RadianceMap map;
  if (!path.empty() && fs::is_regular_file(path, ignored)) map = read_panorama(path);
  if (map.width != k_room_width) {
    const Room room = make_room(seed);
    RoomRenderOptions options;
    options.width = k_room_width, options.samples = k_room_samples, options.threads = threads;
    map = trace_room(room, options).radiance;
    expose(&map, room.key);
    if (!path.empty()) {
      // The map is read back from the file, so a later run draws with the same bits.
      write_hdr(path, map);
      map = read_panorama(path);
    }
  }
  return panorama_surroundings(std::move(map), "room " + std::to_string(seed), camera, azimuth_deg, standing,
                               k_room_insertion);
}

Surroundings photo_surroundings(const std::string& path, double diagonal_fov_deg, Camera* camera) {
  Surroundings s;
  s.name = fs::path(path).stem().string();
  s.photo = linear_photo(read_picture(path));
  s.photo_focal = focal_length(s.photo.width, s.photo.height, diagonal_fov_deg);
  const double shown = std::min<double>(s.photo.height, s.photo.width / k_picture_aspect);
  camera->fov_deg = 360.0 / k_pi * std::atan(0.5 * shown / s.photo_focal);
  return s;
}

ShotLight labelled_light(const Surroundings& s) {
  const ViewRotation rotation(s.view);
  const LightLabels labels = labels_of(s.warped, rotation.to_rotated({0, 1, 0}), s.white);
  const Vec3 towards = rotation.to_panorama(labels.direction);
  // As in sandglass/light.h, the light is so strong that its share of what a level floor receives is the contrast.
  const double o = std::min(labels.contrast, k_most_contrast);
  const double wanted = luminance(labels.ambient) * o / (1.0 - o) / std::max(towards.y, k_least_cosine);
  const double strength =
      luminance(labels.light) > 0.0 ? std::min(wanted / luminance(labels.light), k_most_strength) : 0.0;
  return {
      towards, labels.light * strength, labels.ambient, labels.contrast * labels.concentration, labels.concentration,
      -1.0};
}

ShotLight arbitrary_light(const ShotCamera& camera) {
  ShotLight light;
  const Vec3 back = normalised(Vec3{-camera.forward.x, 0, -camera.forward.z});
  light.towards = normalised(Vec3{0, 1, 0} * 1.0 + back * 0.5 - camera.right * 0.7);
  light.light = {0.8, 0.8, 0.8}, light.ambient = {0.3, 0.3, 0.3};
  light.contrast = 0.7;
  return light;
}

}  // namespace sandglass::host
