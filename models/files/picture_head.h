// What a picture's file says about itself before it is decoded: its kind, size and colours, and how the camera was held.
#pragma once

#include <cstddef>
#include <string_view>

namespace sandglass::host {

struct PictureHead {
  enum class Kind { unknown, png, jpeg, other };
  Kind kind = Kind::unknown;
  const char* name = "";              // of another kind: "HEIC"
  unsigned width = 0, height = 0;     // pixels as they are stored; 0: not found
  unsigned components = 0, bits = 0;  // colours of a pixel, and bits of each
  // EXIF's number for where the first row and column are: 1 upright, 6 to be turned clockwise by a quarter, 3 by a half,
  // 8 by three quarters; 2, 4, 5 and 7 are mirrored.
  int orientation = 1;
  size_t palette = 0, colours = 0;  // of a PNG: where its palette begins in the file, and how many colours that names
  // What the file says of its colours, as parts of its bytes; of a PNG the contents of cICP, iCCP, gAMA and cHRM. Of a
  // JPEG's profile it is the first segment, which holds all of one that picture_colour() knows.
  std::string_view cicp, icc, gamma, chromaticities;
  bool says_srgb = false;
  // Null, or what is wrong with a JPEG that stb_image would read: tables of codes that it would write behind its own, or
  // that a scan names and nothing defines; no scan at all.
  const char* damage = nullptr;
};

// Never fails: what is damaged or missing stays as it is above.
PictureHead picture_head(std::string_view bytes);

}  // namespace sandglass::host
