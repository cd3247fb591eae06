// Photographs as files: JPEG and PNG, sRGB to linear.
#pragma once

#include <string>

#include "models/lighting/panorama.h"

namespace sandglass::host {

// A Failure names the file and what is wrong with it.
RadianceMap read_photo(const std::string& path);

}  // namespace sandglass::host
