// Photographs from files: PNG and JPEG.
#pragma once

#include <string>

#include "models/files/image.h"

namespace sandglass::host {

// 8-bit sRGB; a Failure that names the file.
Picture read_picture(const std::string& path);
// The same for an image of a data set, 256 x 192; a Failure for any other size.
Picture read_excerpt(const std::string& path);

}  // namespace sandglass::host
