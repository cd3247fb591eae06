// See ply.h.
#include "models/mesh/ply.h"

#include <bit>

#include "models/files/atomic_file.h"

namespace sandglass::host {

static_assert(std::endian::native == std::endian::little, "the file is little-endian and written as memory holds it");

void write_points_ply(const std::string& path, const std::vector<float>& points) {
  std::string file = "ply\nformat binary_little_endian 1.0\nelement vertex " + std::to_string(points.size() / 3) +
                     "\nproperty float x\nproperty float y\nproperty float z\nend_header\n";
  file.append(reinterpret_cast<const char*>(points.data()), points.size() * sizeof(float));
  write_file(path, file);
}

}  // namespace sandglass::host
