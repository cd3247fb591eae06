// 8-bit sRGB pictures: a pixel array, a 5x7 bitmap font to label it, a grid of pictures, and PNG and animated GIF
// files.
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
  std::vector<uint8_t> rgb;  // row by row from the top, three bytes a pixel

  Picture() = default;
  Picture(int w, int h, Colour fill) : width(w), height(h), rgb(static_cast<size_t>(w) * static_cast<size_t>(h) * 3) {
    for (size_t i = 0; i < rgb.size(); i += 3) rgb[i] = fill.r, rgb[i + 1] = fill.g, rgb[i + 2] = fill.b;
  }
  uint8_t* at(int x, int y) {
    return rgb.data() + (static_cast<size_t>(y) * static_cast<size_t>(width) + static_cast<size_t>(x)) * 3;
  }
  const uint8_t* at(int x, int y) const { return const_cast<Picture*>(this)->at(x, y); }
};

// Linear 0..1 to an sRGB byte; values outside are clamped.
uint8_t srgb_byte(double linear);
// Linear 0..1 of an sRGB byte.
double linear_of(uint8_t srgb);

// Draws with the upper left corner at (x, y), `scale` pixels a font pixel; parts outside the picture are left out.
void draw_text(Picture* picture, int x, int y, int scale, std::string_view text, Colour colour);
int text_width(int scale, std::string_view text);

void fill_rectangle(Picture* picture, int x, int y, int width, int height, Colour colour);

// Pictures of equal size in rows of `columns`, with `gap` pixels of white between them.
Picture picture_grid(std::span<const Picture> pictures, int columns, int gap);

void write_png(const std::string& path, const Picture& picture);

// The bytes of a JPEG file; quality 1..100. A tenth of the PNG where a page carries photographs of sand.
std::vector<uint8_t> jpeg_file(const Picture& picture, int quality);

// Animated GIF with a fixed 6x6x6 palette and ordered dither: coarse, but it plays wherever ffmpeg is missing.
void write_gif(const std::string& path, std::span<const Picture> frames, int centiseconds_per_frame);

}  // namespace sandglass::host
