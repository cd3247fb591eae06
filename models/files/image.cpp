// Pixels, letters and files. stb makes and reads PNG and JPEG.
#include "models/files/image.h"

#include <stb_image_write.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>

#include "models/files/atomic_file.h"
#include "models/files/failure.h"
#include "models/files/picture_colour.h"
#include "models/files/picture_head.h"

// Zeros, so that what a damaged file leaves out is the same every time, and nothing that the program had in memory.
#define STBI_MALLOC(bytes) std::calloc(1, bytes)
#define STBI_REALLOC(block, bytes) std::realloc(block, bytes)
#define STBI_FREE(block) std::free(block)
#define STBI_ONLY_PNG
#define STBI_ONLY_JPEG
#define STBI_NO_STDIO
#define STBI_MAX_DIMENSIONS 16384
#define STB_IMAGE_STATIC
#define STB_IMAGE_IMPLEMENTATION
#if defined(__GNUC__)
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wunused-function"
#endif
// stb copies nothing to nowhere, and shifts and adds what may overflow. Compilers give that the meaning that it expects;
// the sanitizers need not stop there. They do watch its arrays.
#if defined(__clang__)
#pragma clang attribute push(__attribute__((no_sanitize("nonnull-attribute", "shift", "signed-integer-overflow"))), \
                             apply_to = function)
#endif
#include <stb_image.h>
#if defined(__clang__)
#pragma clang attribute pop
#endif
#if defined(__GNUC__)
#pragma GCC diagnostic pop
#endif

namespace sandglass::host {

namespace {

constexpr int k_glyph_width = 5, k_glyph_height = 7, k_glyph_step = 6;  // font pixels

struct Glyph {
  char character;
  uint8_t rows[k_glyph_height];  // bit 4 is the left pixel
};

constexpr Glyph k_glyphs[] = {
    {'0', {14, 17, 19, 21, 25, 17, 14}}, {'1', {4, 12, 4, 4, 4, 4, 14}},      {'2', {14, 17, 1, 2, 4, 8, 31}},
    {'3', {31, 2, 4, 2, 1, 17, 14}},     {'4', {2, 6, 10, 18, 31, 2, 2}},     {'5', {31, 16, 30, 1, 1, 17, 14}},
    {'6', {6, 8, 16, 30, 17, 17, 14}},   {'7', {31, 1, 2, 4, 8, 8, 8}},       {'8', {14, 17, 17, 14, 17, 17, 14}},
    {'9', {14, 17, 17, 15, 1, 2, 12}},   {'A', {14, 17, 17, 31, 17, 17, 17}}, {'B', {30, 17, 17, 30, 17, 17, 30}},
    {'C', {14, 17, 16, 16, 16, 17, 14}}, {'D', {28, 18, 17, 17, 17, 18, 28}}, {'E', {31, 16, 16, 30, 16, 16, 31}},
    {'F', {31, 16, 16, 30, 16, 16, 16}}, {'G', {14, 17, 16, 23, 17, 17, 15}}, {'H', {17, 17, 17, 31, 17, 17, 17}},
    {'I', {14, 4, 4, 4, 4, 4, 14}},      {'J', {7, 2, 2, 2, 2, 18, 12}},      {'K', {17, 18, 20, 24, 20, 18, 17}},
    {'L', {16, 16, 16, 16, 16, 16, 31}}, {'M', {17, 27, 21, 21, 17, 17, 17}}, {'N', {17, 17, 25, 21, 19, 17, 17}},
    {'O', {14, 17, 17, 17, 17, 17, 14}}, {'P', {30, 17, 17, 30, 16, 16, 16}}, {'Q', {14, 17, 17, 17, 21, 18, 13}},
    {'R', {30, 17, 17, 30, 20, 18, 17}}, {'S', {15, 16, 16, 14, 1, 1, 30}},   {'T', {31, 4, 4, 4, 4, 4, 4}},
    {'U', {17, 17, 17, 17, 17, 17, 14}}, {'V', {17, 17, 17, 17, 17, 10, 4}},  {'W', {17, 17, 17, 21, 21, 21, 10}},
    {'X', {17, 17, 10, 4, 10, 17, 17}},  {'Y', {17, 17, 17, 10, 4, 4, 4}},    {'Z', {31, 1, 2, 4, 8, 16, 31}},
    {'.', {0, 0, 0, 0, 0, 12, 12}},      {',', {0, 0, 0, 0, 12, 4, 8}},       {':', {0, 12, 12, 0, 12, 12, 0}},
    {'-', {0, 0, 0, 31, 0, 0, 0}},       {'+', {0, 4, 4, 31, 4, 4, 0}},       {'/', {0, 1, 2, 4, 8, 16, 0}},
    {'%', {24, 25, 2, 4, 8, 19, 3}},     {'=', {0, 0, 31, 0, 31, 0, 0}},      {'(', {2, 4, 8, 8, 8, 4, 2}},
    {')', {8, 4, 2, 2, 2, 4, 8}},        {'_', {0, 0, 0, 0, 0, 0, 31}},
};

const Glyph* find_glyph(char character) {
  if (character >= 'a' && character <= 'z') character = static_cast<char>(character - 'a' + 'A');
  for (const Glyph& glyph : k_glyphs)
    if (glyph.character == character) return &glyph;
  return nullptr;
}

void set_pixel(Picture* picture, int x, int y, Colour colour) {
  if (x < 0 || y < 0 || x >= picture->width || y >= picture->height) return;
  uint8_t* pixel = picture->at(x, y);
  pixel[0] = colour.r;
  pixel[1] = colour.g;
  pixel[2] = colour.b;
}

}  // namespace

uint8_t srgb_byte(double linear) {
  // The least value of each byte above 0: a search among them costs a fifth of the power.
  static const std::array<double, 255> k_minima = [] {
    std::array<double, 255> minima;
    for (size_t i = 0; i < minima.size(); ++i) {
      const double encoded = (static_cast<double>(i) + 0.5) / 255.0;
      minima[i] = encoded <= 0.04045 ? encoded / 12.92 : std::pow((encoded + 0.055) / 1.055, 2.4);
    }
    return minima;
  }();
  return static_cast<uint8_t>(std::upper_bound(k_minima.begin(), k_minima.end(), linear) - k_minima.begin());
}

double srgb_of(double linear) {
  const double x = std::clamp(linear, 0.0, 1.0);
  return x <= 0.0031308 ? 12.92 * x : 1.055 * std::pow(x, 1.0 / 2.4) - 0.055;
}

double linear_of(uint8_t srgb) {
  const double x = srgb / 255.0;
  return x <= 0.04045 ? x / 12.92 : std::pow((x + 0.055) / 1.055, 2.4);
}

void fill_rectangle(Picture* picture, int x, int y, int width, int height, Colour colour) {
  for (int j = 0; j < height; ++j)
    for (int i = 0; i < width; ++i) set_pixel(picture, x + i, y + j, colour);
}

void draw_text(Picture* picture, int x, int y, int scale, std::string_view text, Colour colour) {
  for (const char character : text) {
    if (const Glyph* glyph = find_glyph(character))
      for (int row = 0; row < k_glyph_height; ++row)
        for (int column = 0; column < k_glyph_width; ++column)
          if ((glyph->rows[row] >> (k_glyph_width - 1 - column) & 1) != 0)
            fill_rectangle(picture, x + column * scale, y + row * scale, scale, scale, colour);
    x += k_glyph_step * scale;
  }
}

void paste(Picture* onto, const Picture& picture, int left, int top) {
  for (int y = 0; y < picture.height; ++y)
    std::copy_n(picture.at(0, y), 3 * static_cast<size_t>(picture.width), onto->at(left, top + y));
}

Picture scaled(const Picture& picture, int width, int height) {
  Picture out(width, height, {0, 0, 0});
  const auto from = [](int at, int of, int to) { return static_cast<int>(static_cast<int64_t>(at) * of / to); };
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      const int x0 = from(x, picture.width, width), x1 = std::max(x0 + 1, from(x + 1, picture.width, width));
      const int y0 = from(y, picture.height, height), y1 = std::max(y0 + 1, from(y + 1, picture.height, height));
      const int64_t count = static_cast<int64_t>(x1 - x0) * (y1 - y0);
      for (int c = 0; c < 3; ++c) {
        int64_t sum = 0;
        for (int v = y0; v < y1; ++v)
          for (int u = x0; u < x1; ++u) sum += picture.at(u, v)[c];
        out.at(x, y)[c] = static_cast<uint8_t>((sum + count / 2) / count);
      }
    }
  return out;
}

Picture picture_grid(std::span<const Picture> pictures, int columns, int gap) {
  if (pictures.empty()) return {};
  const int width = pictures[0].width, height = pictures[0].height;
  const int rows = (static_cast<int>(pictures.size()) + columns - 1) / columns;
  Picture grid(columns * width + (columns + 1) * gap, rows * height + (rows + 1) * gap, {255, 255, 255});
  for (int i = 0; i < static_cast<int>(pictures.size()); ++i) {
    const int left = gap + i % columns * (width + gap), top = gap + i / columns * (height + gap);
    paste(&grid, pictures[static_cast<size_t>(i)], left, top);
  }
  return grid;
}

void append_bytes(void* to, void* data, int size) {
  auto* bytes = static_cast<std::vector<uint8_t>*>(to);
  const auto* begin = static_cast<const uint8_t*>(data);
  bytes->insert(bytes->end(), begin, begin + size);
}

// Refuses what would be decoded wrongly or not at all, by its name.
static void expect_readable(const PictureHead& head, const std::string& path) {
  constexpr unsigned k_pixels = 1u << 27;  // of all rows together
  using Kind = PictureHead::Kind;
  if (head.kind == Kind::other)
    throw cannot("read", path, std::string("it is a ") + head.name + " picture", "Convert it to PNG or JPEG");
  if (head.kind == Kind::unknown) throw cannot("read", path, "it is no PNG or JPEG picture", "Convert it");
  if (head.damage != nullptr)
    throw cannot("read", path, std::string("it is damaged: ") + head.damage, "Export it again");
  if (head.kind == Kind::jpeg && head.components == 4)
    throw cannot("read", path, "its colours are for print (CMYK)", "Convert it to RGB");
  if (head.kind == Kind::jpeg && head.bits > 8)
    throw cannot("read", path, "it has " + std::to_string(head.bits) + " bits a colour", "Convert it to 8 bits");
  if (head.width > STBI_MAX_DIMENSIONS || head.height > STBI_MAX_DIMENSIONS ||
      uint64_t{head.width} * head.height > k_pixels)
    throw cannot("read", path,
                 "it has " + std::to_string(head.width) + " x " + std::to_string(head.height) +
                     " pixels, and at most " + std::to_string(STBI_MAX_DIMENSIONS) + " a side and 134 million are read",
                 "Scale it down");
}

// As it is seen where EXIF gives this orientation, 1 to 8.
static Picture upright(Picture stored, int orientation) {
  if (orientation == 1) return stored;
  const bool across = orientation >= 5;  // rows become columns
  const bool from_right = orientation == 2 || orientation == 3 || orientation == 7 || orientation == 8;
  const bool from_below = orientation == 3 || orientation == 4 || orientation == 6 || orientation == 7;
  Picture seen(across ? stored.height : stored.width, across ? stored.width : stored.height, {0, 0, 0});
  for (int y = 0; y < seen.height; ++y)
    for (int x = 0; x < seen.width; ++x) {
      const int u = across ? y : x, v = across ? x : y;
      const uint8_t* from = stored.at(from_right ? stored.width - 1 - u : u, from_below ? stored.height - 1 - v : v);
      std::copy_n(from, 3, seen.at(x, y));
    }
  return seen;
}

// A pixel may name a colour that its PNG's palette does not have. stb then reads memory that nothing wrote; here the
// palette gets all the colours that a pixel can name, and those are black.
static void fill_palette(const PictureHead& head, std::string* file) {
  constexpr size_t k_colours = 256;
  if (head.colours == 0 || head.colours >= k_colours) return;
  const size_t length = 3 * k_colours;
  file->insert(head.palette + 3 * head.colours, length - 3 * head.colours, '\0');
  for (size_t i = 0; i < 4; ++i) (*file)[head.palette - 8 + i] = static_cast<char>(length >> (24 - 8 * i));
}

// Cameras leave bytes between a picture's data and its end, and stb stops at the first 0xFF among them. They are made
// zeros, up to the next marker that a picture may have there, and it reads again. PNGs that Xcode made have red and blue
// exchanged and colours multiplied by their alpha, unless stb is asked to look. `deep`: with 16 bits a number.
static void* decoded(const PictureHead& head, bool deep, std::string* content, int* width, int* height) {
  constexpr uint64_t k_attempts = 16, k_pixels = 1u << 27;  // of all attempts but the first: as many as one picture has
  const uint64_t pixels_of_frame = uint64_t{head.width} * head.height;
  constexpr std::string_view k_markers = "\xC4\xD9\xDA\xDB\xDD\xFE";  // tables, end, scan, tables, interval, comment
  stbi_convert_iphone_png_to_rgb(1);
  stbi_set_unpremultiply_on_load(1);
  for (uint64_t attempt = 0; attempt < k_attempts && attempt * pixels_of_frame <= k_pixels; ++attempt) {
    int channels = 0;
    stbi__context context;
    stbi__start_mem(&context, reinterpret_cast<const uint8_t*>(content->data()), static_cast<int>(content->size()));
    void* pixels = deep ? static_cast<void*>(stbi__load_and_postprocess_16bit(&context, width, height, &channels, 3))
                        : stbi__load_and_postprocess_8bit(&context, width, height, &channels, 3);
    if (pixels != nullptr || std::strcmp(stbi_failure_reason(), "unknown marker") != 0) return pixels;
    const size_t at = static_cast<size_t>(context.img_buffer - context.img_buffer_original) - 2;
    size_t next = at + 2;
    const auto is_marker = [&] {
      return (*content)[next] == '\xFF' && k_markers.find((*content)[next + 1]) != std::string_view::npos;
    };
    while (next + 1 < content->size() && !is_marker()) ++next;
    if (next + 1 >= content->size()) return nullptr;
    std::fill(content->begin() + static_cast<std::ptrdiff_t>(at), content->begin() + static_cast<std::ptrdiff_t>(next),
              '\0');
    if (picture_head(*content).damage != nullptr) return nullptr;  // what was skipped before may be a table
  }
  return nullptr;
}

// A PNG packs its profile, behind a name, a zero and the number of the method. Those that picture_colour() knows are
// far smaller than what is unpacked here at most.
static PictureColour colour_of(const PictureHead& head) {
  constexpr size_t k_longest = 1 << 16;
  if (head.kind != PictureHead::Kind::png || head.icc.empty()) return picture_colour(head, head.icc);
  const std::string_view packed = head.icc.substr(std::min(head.icc.find('\0') + 2, head.icc.size()));
  std::string icc(k_longest, '\0');
  const int size =
      stbi_zlib_decode_buffer(icc.data(), static_cast<int>(icc.size()), packed.data(), static_cast<int>(packed.size()));
  return picture_colour(head, std::string_view(icc).substr(0, static_cast<size_t>(std::max(size, 0))));
}

Picture read_picture(const std::string& path) {
  std::string content = read_file(path, "picture", k_asset_limit);
  const PictureHead head = picture_head(content);
  expect_readable(head, path);
  const PictureColour colour = colour_of(head);
  fill_palette(head, &content);
  Picture picture;
  void* pixels = decoded(head, !colour.is_srgb(), &content, &picture.width, &picture.height);
  if (pixels == nullptr) throw cannot("read", path, "it is cut off or damaged", "Copy or export it again");
  const size_t numbers = 3 * static_cast<size_t>(picture.width) * static_cast<size_t>(picture.height);
  if (colour.is_srgb()) picture.rgb.assign(static_cast<uint8_t*>(pixels), static_cast<uint8_t*>(pixels) + numbers);
  else picture.rgb = srgb_bytes({static_cast<uint16_t*>(pixels), numbers}, colour);
  std::free(pixels);
  if (colour.remark != nullptr) std::fprintf(stderr, "sandglass: note: \"%s\": %s.\n", path.c_str(), colour.remark);
  return upright(std::move(picture), head.orientation);
}

Picture read_excerpt(const std::string& path) {
  Picture picture = read_picture(path);
  if (picture.width != 256 || picture.height != 192)
    throw cannot(
        "read", path,
        "it has " + std::to_string(picture.width) + " x " + std::to_string(picture.height) + " pixels, not 256 x 192",
        "Name a folder that sandglass dataset made");
  return picture;
}

void write_png(const std::string& path, const Picture& picture) {
  std::vector<uint8_t> file;
  if (picture.width <= 0 || picture.height <= 0 ||
      stbi_write_png_to_func(append_bytes, &file, picture.width, picture.height, 3, picture.rgb.data(),
                             picture.width * 3) == 0)
    throw cannot("write", path, "the picture has no pixel", "Make it larger");
  write_file(path, file);
}

std::vector<uint8_t> jpeg_file(const Picture& picture, int quality) {
  std::vector<uint8_t> file;
  if (picture.width <= 0 || picture.height <= 0 ||
      stbi_write_jpg_to_func(append_bytes, &file, picture.width, picture.height, 3, picture.rgb.data(), quality) == 0)
    throw cannot("encode", "JPEG", "the picture has no pixel", "Make it larger");
  return file;
}

}  // namespace sandglass::host
