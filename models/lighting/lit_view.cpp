#include "models/lighting/lit_view.h"

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "models/files/failure.h"
#include "models/rooms/panorama_file.h"
#include "runtime/math/random.h"

namespace sandglass::host {

namespace fs = std::filesystem;

constexpr int k_warped_width_min = 256;

uint64_t hash_of_name(const std::string& name, uint64_t seed) {
  uint64_t hash = mix_bits(seed);
  for (const char c : name) hash = mix_bits(hash ^ static_cast<uint64_t>(static_cast<unsigned char>(c)));
  return hash;
}

std::string stem_of(const std::string& path) { return fs::path(path).stem().string(); }

std::array<View, k_excerpts> views_of(const std::string& path, uint64_t seed) {
  return choose_views(hash_of_name(stem_of(path), seed));
}

LitPanorama::LitPanorama(const std::string& path) : radiance_(read_panorama(path)) {
  fill_tripod(&radiance_);
  white_ = greatest_luminance(radiance_);
  const std::string depth_path = (fs::path(path).parent_path() / (stem_of(path) + "_depth.npy")).string();
  if (fs::exists(depth_path)) {
    depth_ = read_npy(depth_path);
    if (depth_.shape.size() != 2 || depth_.shape[1] != 2 * depth_.shape[0])
      throw cannot("read", depth_path, "the depth map is not twice as wide as high", "Make the room again");
  }
  mapped_ = RadianceMap(radiance_.width, radiance_.height);
  for (int v = 0; v < mapped_.height; ++v)
    for (int u = 0; u < mapped_.width; ++u) mapped_.set(u, v, tone_mapped(radiance_.colour(u, v), white_));
}

LitView LitPanorama::cut(View view) const {
  LitView cut;
  cut.radius = insertion_radius(depth_.values, depth_.shape.empty() ? 0 : static_cast<int>(depth_.shape[1]), view);
  // More pixels than the panorama has would not add information.
  const int width = std::clamp(radiance_.width, k_warped_width_min, k_warped_width);
  const RadianceMap warped = warp(radiance_, view, cut.radius, width, width / 2);
  cut.labels = labels_of(warped, ViewRotation(view).to_rotated({0, 1, 0}), white_);
  cut.labels.direction = rotated_to_camera(cut.labels.direction);
  cut.image = picture_of(cut_excerpt(mapped_, view));
  return cut;
}

}  // namespace sandglass::host
