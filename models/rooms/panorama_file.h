// Panoramas as files: Radiance .hdr and, where OpenEXR was found, .exr. A panorama must be twice as wide as high,
// finite and not all black. Negative radiance becomes 0.
#pragma once

#include <string>

#include "models/rooms/panorama.h"

namespace sandglass::host {

// A Failure names the file and what is wrong with it.
RadianceMap read_panorama(const std::string& path);

// Writes Radiance .hdr with run lengths: 8 bits of mantissa for each channel and one shared exponent.
void write_hdr(const std::string& path, const RadianceMap& map);

// A made-up room to ship: a JPEG that is tone mapped (5.3) with the same white for all, a tenth of the size of an .hdr.
// Radiance comes back to a few per cent; what is brighter than white is white.
constexpr double k_kept_white = 64.0;
void write_kept_room(const std::string& path, const RadianceMap& map);
RadianceMap read_kept_room(const std::string& path);

bool reads_exr();

}  // namespace sandglass::host
