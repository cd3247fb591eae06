// A picture, a panorama or an array of any bytes: it is refused by a sentence, or it is whole.
#include "models/files/image.h"
#include "models/files/npy.h"
#include "models/rooms/panorama_file.h"
#include "tests/fuzz/read_file.h"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  using namespace sandglass;
  constexpr const char* k_extensions[] = {".png", ".jpg", ".hdr", ".npy", ".exr"};
  fuzz::read_as_file(data, size, k_extensions, [](const std::string& path) {
    if (path.ends_with(".hdr") || path.ends_with(".exr")) {
      const host::RadianceMap map = host::read_panorama(path);
      fuzz::expect(map.rgb.size() == 3 * static_cast<size_t>(map.width) * static_cast<size_t>(map.height));
      for (const float value : map.rgb) fuzz::expect(std::isfinite(value));
    } else if (path.ends_with(".npy")) {
      (void)host::read_npy(path);
    } else {
      const host::Picture picture = host::read_picture(path);
      fuzz::expect(picture.rgb.size() == 3 * static_cast<size_t>(picture.width) * static_cast<size_t>(picture.height));
    }
  });
  return 0;
}
