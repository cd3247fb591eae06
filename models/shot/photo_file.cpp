#include "models/shot/photo_file.h"

#define STB_IMAGE_IMPLEMENTATION
#define STB_IMAGE_STATIC
#define STBI_ONLY_JPEG
#define STBI_ONLY_PNG
#define STBI_NO_STDIO
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wunused-function"
#include <stb_image.h>
#pragma GCC diagnostic pop

#include <array>
#include <cmath>

#include "models/host/atomic_file.h"
#include "models/host/failure.h"

namespace sandglass::host {

RadianceMap read_photo(const std::string& path) {
  const std::string content = read_file(path, "photograph");
  int width = 0, height = 0, channels = 0;
  uint8_t* pixels = stbi_load_from_memory(reinterpret_cast<const uint8_t*>(content.data()),
                                          static_cast<int>(content.size()), &width, &height, &channels, 3);
  if (pixels == nullptr)
    throw Failure("photograph '" + path + "' cannot be decoded: " + stbi_failure_reason() + "; give a JPEG or PNG");
  std::array<float, 256> linear;
  for (size_t i = 0; i < linear.size(); ++i) {
    const double v = static_cast<double>(i) / 255.0;
    linear[i] = static_cast<float>(v <= 0.04045 ? v / 12.92 : std::pow((v + 0.055) / 1.055, 2.4));
  }
  RadianceMap photo(width, height);
  for (size_t i = 0; i < photo.rgb.size(); ++i) photo.rgb[i] = linear[pixels[i]];
  stbi_image_free(pixels);
  return photo;
}

}  // namespace sandglass::host
