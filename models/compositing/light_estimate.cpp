#include "models/compositing/light_estimate.h"

#include <cmath>
#include <filesystem>

#include "models/files/failure.h"
#include "models/files/image.h"

namespace sandglass::host {

namespace fs = std::filesystem;

namespace {

// The camera's own image is wider than the picture. It has the size and the field of view that the network expects.
constexpr int k_width = SANDGLASS_LIGHT_WIDTH, k_height = SANDGLASS_LIGHT_HEIGHT;
constexpr double k_focal = 174.60936017108344;  // in pixels; the image's diagonal spans 85 degrees

}  // namespace

const sandglass_camera_image* LightEstimate::take(const Surroundings& room, const ShotCamera& camera,
                                                  uint64_t time_ns) {
  const bool photo = !room.has_truth();
  const int width = photo ? room.photo.width : k_width, height = photo ? room.photo.height : k_height;
  const double focal = photo ? room.photo_focal : k_focal;
  ShotCamera whole = camera;
  whole.focal = focal / height;
  picture_ = Picture(width, height, {0, 0, 0});
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      const Vec3 c = room.seen(whole, whole.ray(x + 0.5, y + 0.5, width, height));
      uint8_t* pixel = picture_.at(x, y);
      pixel[0] = srgb_byte(c.x), pixel[1] = srgb_byte(c.y), pixel[2] = srgb_byte(c.z);
    }
  image_ = camera_image_of(picture_, k_excerpt_fov_deg);
  image_.focal_x = image_.focal_y = static_cast<float>(focal);
  // The columns of the pose of a camera that looks along its own -z with y up.
  float matrix[16] = {};
  const Vec3 axes[4] = {camera.right, camera.up, camera.forward * -1.0, {}};
  for (int i = 0; i < 4; ++i) {
    matrix[4 * i] = static_cast<float>(axes[i].x), matrix[4 * i + 1] = static_cast<float>(axes[i].y);
    matrix[4 * i + 2] = static_cast<float>(axes[i].z), matrix[4 * i + 3] = i == 3 ? 1.0f : 0.0f;
  }
  if (sandglass_camera_orientation(matrix, image_.orientation) == 0)
    throw cannot("read", "camera", "its pose is no rotation", "Correct \"eye\" and \"target\"");
  image_.timestamp_ns = time_ns;
  return &image_;
}

ShotLight LightEstimate::light() const {
  const sandglass_light_estimate e = light_.now().filtered;
  const auto vector = [](const float* v) { return Vec3{v[0], v[1], v[2]}; };
  return {vector(e.direction),
          vector(e.light) * static_cast<double>(e.strength),
          vector(e.ambient),
          static_cast<double>(e.contrast),
          1.0,
          static_cast<double>(e.confidence)};
}

std::string shipped_light_network() {
  std::error_code error;
  const fs::path program = fs::read_symlink("/proc/self/exe", error);
  for (const fs::path& folder :
       {fs::path(SANDGLASS_LIGHTS_DIR), program.parent_path() / ".." / "share" / "sandglass" / "lights"})
    if (fs::is_regular_file(folder / "room.light", error)) return (folder / "room.light").string();
  return "";
}

}  // namespace sandglass::host
