// A picture, a panorama or an array of any bytes, as a file whose extension the first byte picks: it is refused by a
// sentence, or it is whole.
#include <unistd.h>

#include <cstdio>
#include <cstdlib>
#include <string>

#include "models/files/failure.h"
#include "models/files/image.h"
#include "models/files/npy.h"
#include "models/rooms/panorama_file.h"
#include "tests/fuzz/edits.h"

namespace {

using namespace sandglass;

void check(const std::string& path) {
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
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  constexpr const char* k_extensions[] = {".png", ".jpg", ".hdr", ".npy", ".exr"};
  if (size == 0) return 0;
  static const struct Folder {
    char name[32] = "/tmp/sandglass_fuzz_XXXXXX";
    Folder() { fuzz::expect(mkdtemp(name) != nullptr); }
    ~Folder() { rmdir(name); }
  } folder;
  const std::string path = folder.name + std::string("/x") + k_extensions[data[0] % std::size(k_extensions)];
  std::FILE* file = std::fopen(path.c_str(), "wb");
  fuzz::expect(file != nullptr && std::fwrite(data + 1, 1, size - 1, file) == size - 1 && std::fclose(file) == 0);
  try {
    check(path);
  } catch (const host::Failure& failure) {
    fuzz::expect(std::strlen(failure.what()) > 0);
  }
  unlink(path.c_str());
  return 0;
}
