#include "models/lighting/room_light.h"

#include "models/files/failure.h"

namespace sandglass::host {

RoomLight::RoomLight(const std::string& path, bool filter, sandglass_isa isa)
    : file_(read_aligned(path, "lighting network")) {
  sandglass_estimator_desc desc;
  sandglass_estimator_desc_default(&desc);
  desc.isa = isa;
  desc.asset = file_.data();
  desc.asset_bytes = file_.size();
  if (!filter) desc.interval = desc.smoothing = 0.0f;
  const char* reason = nullptr;
  uint64_t need = 0;
  if (sandglass_estimator_bytes(&desc, &need, &reason) != SANDGLASS_OK) throw cannot("read", path, reason);
  block_ = new_block(need, "the lighting network", "close other programs");
  if (sandglass_estimator_create(&desc, block_.get(), need, &light_, &reason) != SANDGLASS_OK)
    throw cannot("read", path, reason);
}

sandglass_estimator_light RoomLight::estimate(const sandglass_camera_image& image) {
  sandglass_estimator_reset(light_);
  return follow(image).filtered;
}

FollowedLight RoomLight::follow(const sandglass_camera_image& image) {
  const char* reason = nullptr;
  if (sandglass_estimator_set_image(light_, &image, nullptr, &reason) != SANDGLASS_OK)
    throw cannot("read", "camera image", reason);
  while (sandglass_estimator_run(light_, 1000) != 0) {
  }
  return now();
}

FollowedLight RoomLight::now() const {
  FollowedLight light = {};
  light.filtered.struct_size = light.latest.struct_size = sizeof(sandglass_estimator_light);
  sandglass_estimator_get(light_, &light.filtered);
  sandglass_estimator_get_latest(light_, &light.latest);
  return light;
}

sandglass_camera_image camera_image_of(const Picture& picture, double diagonal_deg) {
  sandglass_camera_image image;
  sandglass_camera_image_default(&image);
  image.format = SANDGLASS_CAMERA_RGB;
  image.width = static_cast<uint32_t>(picture.width);
  image.height = static_cast<uint32_t>(picture.height);
  image.planes[0] = picture.rgb.data();
  image.strides[0] = 3 * image.width;
  image.focal_x = image.focal_y = sandglass_camera_focal(image.width, image.height, static_cast<float>(diagonal_deg));
  image.centre_x = 0.5f * static_cast<float>(picture.width - 1);
  image.centre_y = 0.5f * static_cast<float>(picture.height - 1);
  return image;
}

sandglass_estimator_light in_camera_frame(sandglass_estimator_light estimate) {
  estimate.direction[1] = -estimate.direction[1];
  estimate.direction[2] = -estimate.direction[2];
  return estimate;
}

}  // namespace sandglass::host
