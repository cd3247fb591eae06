#include "models/compositing/light_estimate.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>

#include "models/files/failure.h"
#include "models/files/image.h"
#include "runtime/light/cube_map.h"
#include "runtime/math/half.h"

namespace sandglass::host {

namespace {

// The picture's camera sees more than the picture shows. Its image has the size and the field of view that the network
// expects.
constexpr int k_width = SANDGLASS_ESTIMATOR_WIDTH, k_height = SANDGLASS_ESTIMATOR_HEIGHT;
constexpr double k_focal = 174.60936017108344;  // in pixels; the image's diagonal spans 85 degrees

// A photograph is seen as it is.
PhoneImage photographed(const Surroundings& room, ShotCamera camera) {
  PhoneImage taken = {picture_of(room.photo), 1.0, {}};
  taken.image = camera_image_of(taken.picture, k_excerpt_fov_deg);
  taken.image.focal_x = taken.image.focal_y = static_cast<float>(room.photo_focal);
  camera.pose(&taken.image);
  return taken;
}

// As a sampler reads it, but for the edges of faces.
struct CubeOfHalves {
  static constexpr int k_size = SANDGLASS_ROOM_CUBE_SIZE;
  std::array<std::array<uint16_t, size_t{4} * k_size * k_size>, 6> texels;

  Vec3 sample(Vec3 direction) const {
    const double d[3] = {direction.x, direction.y, direction.z};
    const CubePoint at = cube_point(d);
    const double x = (at.s + 1) / 2 * k_size - 0.5, y = (at.t + 1) / 2 * k_size - 0.5;
    const double left = std::floor(x), top = std::floor(y);
    Vec3 sum;
    for (int i = 0; i < 4; ++i) {
      const double u = left + i % 2, v = top + i / 2;
      const int column = std::clamp(static_cast<int>(u), 0, k_size - 1);
      const int row = std::clamp(static_cast<int>(v), 0, k_size - 1);
      const uint16_t* texel = texels[at.face].data() + 4 * (row * k_size + column);
      sum = sum + Vec3{from_half(texel[0]), from_half(texel[1]), from_half(texel[2])} *
                      ((1 - std::fabs(x - u)) * (1 - std::fabs(y - v)));
    }
    return sum;
  }
};

// `reason` is a reference because the call that sets it is an argument too.
void require(sandglass_status status, const char* const& reason) {
  if (status != SANDGLASS_OK) throw cannot("see", "room", reason != nullptr ? reason : sandglass_status_name(status));
}

}  // namespace

const sandglass_camera_image* LightEstimate::take(const Surroundings& room, const ShotCamera& camera,
                                                  uint64_t time_ns) {
  ShotCamera whole = camera;
  whole.focal = k_focal / k_height;
  taken_ = room.has_truth() ? take_image(room.panorama, whole, k_width, k_height) : photographed(room, camera);
  taken_.image.timestamp_ns = time_ns;
  scale_ = room.exposure / taken_.exposure;
  return &taken_.image;
}

SeenLight::SeenLight(const Surroundings& room, const ShotCamera& at_rest, Vec3 standing,
                     std::vector<SessionImage> images, uint64_t between_ns)
    : camera_(at_rest),
      azimuth_(std::atan2(at_rest.forward.z, at_rest.forward.x)),
      exposure_(room.exposure),
      images_(std::move(images)),
      between_ns_(between_ns) {
  sandglass_room_desc desc;
  sandglass_room_desc_default(&desc);
  desc.interval = 0.0f;
  desc.reflections = 1;
  if (room.insertion > 0.0)
    desc.radius =
        static_cast<float>(std::hypot(standing.x - at_rest.eye.x, standing.z - at_rest.eye.z) / room.insertion);
  const char* reason = nullptr;
  uint64_t bytes = 0;
  require(sandglass_room_bytes(&desc, &bytes, &reason), reason);
  block_ = new_block(bytes, "the room", "");
  require(sandglass_room_create(&desc, block_.get(), bytes, &room_, &reason), reason);
}

void SeenLight::look_around(const Surroundings& room) {
  if (!room.has_truth()) return;
  constexpr uint64_t k_between_ns = 200'000'000;
  for (const SessionImage& look : images_) {
    image_ = take_image(room.panorama, session_camera(azimuth_, look, camera_.eye), k_session_width, k_session_height,
                        look.exposure);
    image_.image.timestamp_ns = before_ns_ += k_between_ns;
    image_.image.exposure = static_cast<float>(image_.exposure);
    const char* reason = nullptr;
    require(sandglass_room_set_image(room_, &image_.image, nullptr, &reason), reason);
  }
}

const sandglass_camera_image* SeenLight::take(const Surroundings& room, uint64_t time_ns) {
  const bool photo = !room.has_truth();
  const bool once = photo || images_.size() == 1;
  if (time_ns < next_ * between_ns_ || (once && next_ == 1)) return nullptr;
  const SessionImage& look = images_[next_ % images_.size()];
  if (photo) image_ = photographed(room, camera_);
  else
    image_ = take_image(room.panorama, session_camera(azimuth_, look, camera_.eye), k_session_width, k_session_height,
                        look.exposure);
  ++next_;
  image_.image.timestamp_ns = before_ns_ + time_ns + 1'000'000;
  image_.image.exposure = static_cast<float>(image_.exposure);
  // Nothing is drawn before the first image, so it does not wait for a frame.
  const char* reason = nullptr;
  if (next_ == 1) require(sandglass_room_set_image(room_, &image_.image, nullptr, &reason), reason);
  return &image_.image;
}

ShotLight SeenLight::follow(Vec3 standing, double seconds, const sandglass_estimator_light* estimate,
                            sandglass_room_light* shown) {
  sandglass_room_place place;
  sandglass_room_place_default(&place);
  to_floats(standing, place.position);
  place.network = estimate;
  place.shown = shown;
  sandglass_room_light now = {};
  now.struct_size = sizeof now;
  const char* reason = nullptr;
  require(sandglass_room_get(room_, &place, &now, &reason), reason);
  sandglass_room_fade(shown, &now, static_cast<float>(seconds));
  return scaled(*shown, static_cast<double>(shown->white) * exposure_);
}

Reflected SeenLight::reflected(Vec3 place, double height, const sandglass_room_light& shown) const {
  float position[3];
  to_floats(place, position);
  auto faces = std::make_shared<CubeOfHalves>();
  for (uint32_t face = 0; face < 6; ++face) {
    const char* reason = nullptr;
    require(sandglass_room_get_cube(room_, position, static_cast<float>(height), face, 0, faces->texels[face].data(),
                                    &reason),
            reason);
  }
  // The cube is in the last image's scale, and so is shown.white.
  const double scale = static_cast<double>(shown.white) * exposure_;
  return [faces, scale](Vec3 direction) { return faces->sample(direction) * scale; };
}

}  // namespace sandglass::host
