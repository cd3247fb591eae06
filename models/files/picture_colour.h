// What the numbers of a picture stand for, by what its file says about itself, and the picture as 8-bit sRGB. A PNG's
// statements count in the order of its specification: cICP, a profile, sRGB, gAMA and cHRM. Without any it is sRGB.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string_view>
#include <vector>

#include "models/files/picture_head.h"

namespace sandglass::host {

struct PictureColour {
  enum class Curve { srgb, power, bt709, pq, hlg } curve = Curve::srgb;
  double exponent = 1.0;  // of `power`: linear light is the number, in 0..1, to this power
  // Linear colours times this, row by row, are linear BT.709 colours, and white stays white.
  std::array<double, 9> to_bt709 = {1, 0, 0, 0, 1, 0, 0, 0, 1};
  const char* remark = nullptr;  // a sentence without its full stop: what was said and is not applied

  bool is_srgb() const { return curve == Curve::srgb && to_bt709 == PictureColour().to_bt709; }
};

// `icc`: the profile that `head` holds, unpacked; of one that could not be, nothing.
PictureColour picture_colour(const PictureHead& head, std::string_view icc);

// Of three numbers a pixel, of 16 bits each. The white of PQ is 203 cd/m2, that of HLG three quarters of its signal;
// what is brighter is clamped, as in any picture.
std::vector<uint8_t> srgb_bytes(std::span<const uint16_t> numbers, const PictureColour& colour);

}  // namespace sandglass::host
