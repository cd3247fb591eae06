#include "models/compositing/surroundings.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <numbers>

#include "models/compositing/phone.h"
#include "models/files/failure.h"
#include "models/files/image.h"
#include "models/files/shipped_file.h"
#include "models/rooms/excerpt.h"
#include "models/rooms/panorama_file.h"
#include "models/rooms/room_render.h"

namespace sandglass::host {

namespace fs = std::filesystem;

namespace {

constexpr double k_pi = std::numbers::pi;
constexpr int k_room_width = 1024, k_room_samples = 48;
constexpr double k_picture_aspect = 4.0 / 3.0;
constexpr int k_metered_width = 60, k_metered_height = 45;
constexpr double k_metered_part = 0.5;    // of the picture's width: a photographer exposes for what is put there
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
  if (has_truth()) return limited(look_up(panorama, direction) * exposure);
  const Vec3 d = camera.to_camera(direction);
  const double scale = photo_focal / d.z;
  return photo_at(photo, 0.5 * photo.width + d.x * scale, 0.5 * photo.height + d.y * scale);
}

namespace {

// The mean radiance of the floor around a foot. Stitched panoramas show floors that are brighter than their light can
// make them.
Vec3 floor_around(const RadianceMap& panorama, Vec3 foot, Vec3 irradiance) {
  constexpr int k_places = 256;
  constexpr double k_around = 1.0, k_golden = 2.399963229728653, k_brightest = 0.9 / k_pi;  // metres; of the irradiance
  Vec3 sum;
  for (int i = 0; i < k_places; ++i) {
    const double r = k_around * std::sqrt((i + 0.5) / k_places);
    const Vec3 place = foot + Vec3{r * std::cos(k_golden * i), 0, r * std::sin(k_golden * i)};
    sum = sum + look_up(panorama, place) * (1.0 / k_places);
  }
  return {std::min(sum.x, k_brightest * irradiance.x), std::min(sum.y, k_brightest * irradiance.y),
          std::min(sum.z, k_brightest * irradiance.z)};
}

void look_from(Surroundings* s, const Camera& camera, Vec3 standing) {
  const Vec3 to = standing - camera.eye;
  s->foot = to * (s->insertion / std::hypot(to.x, to.z));
  const double away = length(s->foot);
  if (away > k_farthest_insertion) s->foot = s->foot * (k_farthest_insertion / away);
  s->view = {std::acos(to.y / length(to)), std::atan2(to.z, to.x)};
  s->warped = warp(s->panorama, s->view, length(s->foot));
  s->floor = floor_around(s->panorama, to, irradiance_of(light_of(above_horizon(s->warped, s->view), s->view)));
}

}  // namespace

Surroundings moved(const Surroundings& surroundings, const Camera& camera, Vec3 standing, double insertion) {
  Surroundings s = surroundings;
  s.insertion = insertion;
  look_from(&s, camera, standing);
  return s;
}

Reflected Surroundings::true_reflected() const {
  return [this, rotation = ViewRotation(view)](Vec3 direction) {
    return look_up(warped, rotation.to_rotated(direction)) * exposure;
  };
}

Surroundings panorama_surroundings(RadianceMap panorama, const std::string& name, const Camera& camera,
                                   double azimuth_deg, Vec3 standing, double insertion) {
  Surroundings s;
  s.name = name;
  s.insertion = insertion;
  const Vec3 ahead = camera.target - camera.eye;
  const double turn = azimuth_deg * k_pi / 180.0 - std::atan2(ahead.z, ahead.x);
  const int w = panorama.width, shift = static_cast<int>(std::lround(turn / (2.0 * k_pi) * w));
  s.panorama = RadianceMap(w, panorama.height);
  for (int v = 0; v < panorama.height; ++v)
    for (int u = 0; u < w; ++u) s.panorama.set(u, v, panorama.colour(((u + shift) % w + w) % w, v));
  look_from(&s, camera, standing);
  ShotCamera meter = resting_camera(camera);
  meter.focal /= k_metered_part;
  s.exposure = exposed_by_itself(view_of(s.panorama, meter, k_metered_width, k_metered_height));
  return s;
}

namespace {

RadianceMap traced_room(uint32_t seed, const std::string& folder, uint32_t threads) {
  const std::string path =
      folder.empty() ? std::string() : (fs::path(folder) / ("room_" + std::to_string(seed) + ".hdr")).string();
  std::error_code ignored;
  if (!path.empty() && fs::is_regular_file(path, ignored))
    if (RadianceMap map = read_panorama(path); map.width == k_room_width) return map;
  const Room room = make_room(seed);
  RoomRenderOptions options;
  options.width = k_room_width;
  options.samples = k_room_samples;
  options.threads = threads;
  RadianceMap map = trace_room(room, options).radiance;
  expose(&map, room.key);
  if (path.empty()) return map;
  // The map is read back from the file, so a later run draws with the same bits.
  write_hdr(path, map);
  return read_panorama(path);
}

}  // namespace

RadianceMap kept_room(const std::string& name) {
  if (const std::string path = shipped_file("kept_rooms", name + ".jpg"); !path.empty()) return read_kept_room(path);
  throw cannot("find", name, "no room of that name ships", "Take \"lebombo\", a seed as \"room\", or --panorama");
}

Surroundings room_surroundings(uint32_t seed, const std::string& folder, uint32_t threads, const Camera& camera,
                               double azimuth_deg, Vec3 standing) {
  return panorama_surroundings(traced_room(seed, folder, threads), "room " + std::to_string(seed), camera, azimuth_deg,
                               standing, k_room_insertion);
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

ShotLight arbitrary_light(const ShotCamera& camera, Vec3 irradiance) {
  const Vec3 back = normalised(Vec3{-camera.forward.x, 0, -camera.forward.z});
  return one_light(Vec3{0, 1, 0} + back * 0.5 - camera.right * 0.7, 0.7, irradiance);
}

}  // namespace sandglass::host
