// Reads pictures from PNG and JPEG files.
#pragma once

#include <string>

#include "models/files/image.h"

namespace sandglass::host {

// Reads a picture as 8-bit sRGB. A Failure names the file.
Picture read_picture(const std::string& path);
// The same for an image of a data set, which has 256 x 192 pixels. Throws a Failure for any other size.
Picture read_excerpt(const std::string& path);

}  // namespace sandglass::host
