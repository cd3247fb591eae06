#include "models/compositing/light_estimate.h"

#include <cmath>
#include <filesystem>

#include "models/files/failure.h"
#include "models/files/image.h"

namespace sandglass::host {

namespace fs = std::filesystem;

namespace {

// The camera's own image is wider than the picture: as wide as the network looks.
constexpr int k_width = SANDGLASS_LIGHT_WIDTH, k_height = SANDGLASS_LIGHT_HEIGHT;
constexpr double k_focal = 174.60936017108344;  // pixels: 85 degrees across the diagonal

// A reference: the call that writes the reason is another argument.
void require(sandglass_status status, const std::string& what, const char* const& reason) {
  if (status != SANDGLASS_OK) throw cannot("read", what, reason != nullptr ? reason : sandglass_status_name(status));
}

}  // namespace

LightEstimate::LightEstimate(const std::string& file, sandglass_isa isa)
    : file_(read_aligned(file, "lighting network")) {
  sandglass_light_desc desc;
  sandglass_light_desc_default(&desc);
  desc.isa = isa, desc.asset = file_.data(), desc.asset_bytes = file_.size();
  const char* reason = nullptr;
  require(sandglass_light_bytes(&desc, &bytes_, &reason), file, reason);
  block_ = new_block(bytes_, "the lighting network", "close other programs");
  require(sandglass_light_create(&desc, block_.get(), bytes_, &light_, &reason), file, reason);
}

const sandglass_camera_image* LightEstimate::take(const Surroundings& room, const ShotCamera& camera,
                                                  uint64_t time_ns) {
  const bool photo = !room.has_truth();
  const int width = photo ? room.photo.width : k_width, height = photo ? room.photo.height : k_height;
  const double focal = photo ? room.photo_focal : k_focal;
  ShotCamera whole = camera;
  whole.focal = focal / height;
  pixels_.resize(3 * static_cast<size_t>(width) * static_cast<size_t>(height));
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      const Vec3 c = room.seen(whole, whole.ray(x + 0.5, y + 0.5, width, height));
      uint8_t* pixel =
          pixels_.data() + 3 * (static_cast<size_t>(y) * static_cast<size_t>(width) + static_cast<size_t>(x));
      pixel[0] = srgb_byte(c.x), pixel[1] = srgb_byte(c.y), pixel[2] = srgb_byte(c.z);
    }
  sandglass_camera_image_default(&image_);
  image_.format = SANDGLASS_CAMERA_RGB;
  image_.width = static_cast<uint32_t>(width), image_.height = static_cast<uint32_t>(height);
  image_.planes[0] = pixels_.data(), image_.strides[0] = 3 * image_.width;
  image_.focal_x = image_.focal_y = static_cast<float>(focal);
  image_.centre_x = static_cast<float>(0.5 * (width - 1)), image_.centre_y = static_cast<float>(0.5 * (height - 1));
  // Columns of a camera that looks along -z with y up.
  const Vec3 r = camera.right, u = camera.up, b = camera.forward * -1.0;
  const float matrix[16] = {static_cast<float>(r.x),
                            static_cast<float>(r.y),
                            static_cast<float>(r.z),
                            0,
                            static_cast<float>(u.x),
                            static_cast<float>(u.y),
                            static_cast<float>(u.z),
                            0,
                            static_cast<float>(b.x),
                            static_cast<float>(b.y),
                            static_cast<float>(b.z),
                            0,
                            0,
                            0,
                            0,
                            1};
  if (sandglass_camera_orientation(matrix, image_.orientation) == 0)
    throw cannot("read", "camera", "its pose is no rotation", "Correct \"eye\" and \"target\"");
  image_.timestamp_ns = time_ns;
  return &image_;
}

void LightEstimate::finish() {
  const char* reason = nullptr;
  require(sandglass_light_set_image(light_, &image_, nullptr, &reason), "camera image", reason);
  while (sandglass_light_run(light_, 1000) != 0) {
  }
}

bool LightEstimate::valid() const {
  sandglass_light_estimate e = {};
  e.struct_size = sizeof e;
  sandglass_light_get(light_, &e);
  return e.valid != 0;
}

ShotLight LightEstimate::light() const {
  sandglass_light_estimate e = {};
  e.struct_size = sizeof e;
  sandglass_light_get(light_, &e);
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
