// 8-bit sRGB pictures: an array of pixels, a 5x7 bitmap font for labels, a grid of pictures, and PNG and JPEG files.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace sandglass::host {

using Colour = struct Rgb8 { uint8_t r, g, b; };

struct Picture {
  int width = 0, height = 0;
  std::vector<uint8_t> rgb;  // row by row from the top, three bytes per pixel

  Picture() = default;
  Picture(int w, int h, Colour fill) : width(w), height(h), rgb(static_cast<size_t>(w) * static_cast<size_t>(h) * 3) {
    for (size_t i = 0; i < rgb.size(); i += 3) {
      rgb[i] = fill.r;
      rgb[i + 1] = fill.g;
      rgb[i + 2] = fill.b;
    }
  }
  uint8_t* at(int x, int y) {
    return rgb.data() + (static_cast<size_t>(y) * static_cast<size_t>(width) + static_cast<size_t>(x)) * 3;
  }
  const uint8_t* at(int x, int y) const { return const_cast<Picture*>(this)->at(x, y); }
};

// The sRGB byte of a linear value. Values outside 0..1 are clamped.
uint8_t srgb_byte(double linear);
double srgb_of(double linear);  // in 0..1
// The linear value in 0..1 of an sRGB byte.
double linear_of(uint8_t srgb);

// Draws text with its upper left corner at (x, y) and `scale` pixels per font pixel. Parts outside the picture are left
// out.
void draw_text(Picture* picture, int x, int y, int scale, std::string_view text, Colour colour);

void fill_rectangle(Picture* picture, int x, int y, int width, int height, Colour colour);

// Copies a picture into another, in which it must lie wholly.
void paste(Picture* onto, const Picture& picture, int left, int top);

// A grid of pictures of equal size, with `gap` white pixels between and around them.
Picture picture_grid(std::span<const Picture> pictures, int columns, int gap);

// The picture in another size: by means over boxes, or by the nearest pixel.
Picture scaled(const Picture& picture, int width, int height);

// Reads a PNG or JPEG picture as 8-bit sRGB, upright: EXIF says how the camera was held. Grey becomes colour, and 16 bits
// become 8. Display P3 and what a PNG says of its colours are converted; of another profile a note on stderr says that
// it is not. A Failure names the file and what it is instead.
Picture read_picture(const std::string& path);
// The same for an image of a data set, which has 256 x 192 pixels. Throws a Failure for any other size.
Picture read_excerpt(const std::string& path);

void write_png(const std::string& path, const Picture& picture);

// For stb_image_write: `to` is a vector of bytes.
void append_bytes(void* to, void* data, int size);

// The bytes of a JPEG file; quality 1..100. For pictures of sand it has a tenth of the PNG's size.
std::vector<uint8_t> jpeg_file(const Picture& picture, int quality);

}  // namespace sandglass::host
