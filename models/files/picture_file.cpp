// See picture_file.h.
#include "models/files/picture_file.h"

#include <cstdlib>

#include "models/files/atomic_file.h"
#include "models/files/failure.h"

#define STBI_ONLY_PNG
#define STBI_ONLY_JPEG
#define STBI_NO_STDIO
#define STBI_MAX_DIMENSIONS 16384
#define STB_IMAGE_STATIC
#define STB_IMAGE_IMPLEMENTATION
#if defined(__GNUC__)
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wunused-function"
#endif
#include <stb_image.h>
#if defined(__GNUC__)
#pragma GCC diagnostic pop
#endif

namespace sandglass::host {

Picture read_picture(const std::string& path) {
  const std::string content = read_file(path, "picture");
  int channels = 0;
  Picture picture;
  uint8_t* pixels =
      stbi_load_from_memory(reinterpret_cast<const uint8_t*>(content.data()), static_cast<int>(content.size()),
                            &picture.width, &picture.height, &channels, 3);
  if (pixels == nullptr) throw cannot("read", path, "it is no PNG or JPEG picture", "Convert it");
  const size_t bytes = 3 * static_cast<size_t>(picture.width) * static_cast<size_t>(picture.height);
  picture.rgb.assign(pixels, pixels + bytes);
  std::free(pixels);
  return picture;
}

Picture read_excerpt(const std::string& path) {
  Picture picture = read_picture(path);
  if (picture.width != 256 || picture.height != 192)
    throw cannot(
        "read", path,
        "it has " + std::to_string(picture.width) + " x " + std::to_string(picture.height) + " pixels, not 256 x 192",
        "Name a folder that sandglass dataset made");
  return picture;
}

}  // namespace sandglass::host
