// Photographs as people have them: held in any way, in grey, with 16 bits, for print, too wide, or of another kind.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <functional>
#include <string>

#include "models/files/atomic_file.h"
#include "models/files/failure.h"
#include "models/files/image.h"
#include "tests/temporary_folder.h"

namespace sandglass::host {
namespace {

std::string big_endian(uint32_t value, int bytes) {
  std::string text;
  for (int i = bytes - 1; i >= 0; --i) text += static_cast<char>(value >> 8 * i);
  return text;
}

// 64 x 32 pixels, green, with a red upper left corner and a blue upper right one; each a block of the JPEG.
std::string jpeg_with(const std::string& segment) {
  Picture picture(64, 32, {0, 200, 0});
  fill_rectangle(&picture, 0, 0, 16, 16, {250, 0, 0});
  fill_rectangle(&picture, 48, 0, 16, 16, {0, 0, 250});
  const std::vector<uint8_t> bytes = jpeg_file(picture, 95);
  std::string file(bytes.begin(), bytes.end());
  return file.insert(2, segment);
}

std::string exif(int orientation, bool little = false) {
  const auto number = [&](uint32_t value, int bytes) {
    std::string text = big_endian(value, bytes);
    return little ? std::string(text.rbegin(), text.rend()) : text;
  };
  const std::string tiff = (little ? "II" : "MM") + number(42, 2) + number(8, 4) + number(1, 2) + number(0x0112, 2) +
                           number(3, 2) + number(1, 4) + number(static_cast<uint32_t>(orientation), 2) + number(0, 2) +
                           number(0, 4);
  const std::string content = std::string("Exif\0\0", 6) + tiff;
  return "\xFF\xE1" + big_endian(static_cast<uint32_t>(content.size() + 2), 2) + content;
}

// Readers do not look at its checksum.
std::string chunk(const std::string& kind, const std::string& content) {
  return big_endian(static_cast<uint32_t>(content.size()), 4) + kind + content + big_endian(0, 4);
}

// As zlib holds bytes that it could not make fewer.
std::string stored(const std::string& bytes) {
  const uint32_t size = static_cast<uint32_t>(bytes.size());
  const std::string lengths = {static_cast<char>(size & 255), static_cast<char>(size >> 8),
                               static_cast<char>(~size & 255), static_cast<char>(~size >> 8 & 255)};
  return std::string("\x78\x01\x01", 3) + lengths + bytes + big_endian(0, 4);
}

// A PNG without compression; `before`: chunks before its rows.
std::string png_of(uint32_t width, uint32_t height, int bits, int colour_type, const std::string& rows,
                   const std::string& palette = "", const std::string& before = "") {
  return "\x89PNG\r\n\x1a\n" +
         chunk("IHDR", big_endian(width, 4) + big_endian(height, 4) + static_cast<char>(bits) +
                           static_cast<char>(colour_type) + std::string(3, '\0')) +
         before + (palette.empty() ? "" : chunk("PLTE", palette)) + chunk("IDAT", stored(rows)) + chunk("IEND", "");
}

std::string reason_of(const std::string& path) {
  try {
    (void)read_picture(path);
  } catch (const Failure& failure) {
    return failure.what();
  }
  return "read";
}

char colour_at(const Picture& picture, int x, int y) {
  const uint8_t* p = picture.at(x, y);
  return p[0] > 150 ? 'r' : p[2] > 150 ? 'b' : 'g';
}

TEST(Photograph, IsUprightHoweverTheCameraWasHeld) {
  const tests::TemporaryFolder folder;
  // The corners of the upright picture from the upper left, clockwise. By EXIF, the first row lies at the top, top,
  // bottom, bottom, left, right, right, left for 1 to 8, and the first column at left, right, right, left, top, top,
  // bottom, bottom.
  const std::string corners[] = {"rbgg", "brgg", "ggrb", "ggbr", "rggb", "grbg", "gbrg", "bggr"};
  for (int orientation = 1; orientation <= 8; ++orientation)
    for (const bool little : {false, true}) {
      write_file(folder / "p.jpg", std::string_view(jpeg_with(exif(orientation, little))));
      const Picture p = read_picture(folder / "p.jpg");
      EXPECT_EQ(p.width, orientation < 5 ? 64 : 32);
      EXPECT_EQ(p.height, orientation < 5 ? 32 : 64);
      const int right = p.width - 4, low = p.height - 4;
      const std::string found = {colour_at(p, 4, 4), colour_at(p, right, 4), colour_at(p, right, low),
                                 colour_at(p, 4, low)};
      EXPECT_EQ(found, corners[orientation - 1]) << orientation;
    }
}

TEST(Photograph, GreyAndSixteenBitsAreReadAsColour) {
  const tests::TemporaryFolder folder;
  write_file(folder / "grey.png", std::string_view(png_of(2, 1, 8, 0, std::string("\0\x28\xC8", 3))));
  const Picture grey = read_picture(folder / "grey.png");
  for (int c = 0; c < 3; ++c) EXPECT_TRUE(grey.at(0, 0)[c] == 0x28 && grey.at(1, 0)[c] == 0xC8);
  write_file(folder / "deep.png", std::string_view(png_of(1, 1, 16, 2, std::string("\0\x10\xFF\x80\x01\xF0\x00", 7))));
  const Picture deep = read_picture(folder / "deep.png");
  EXPECT_EQ(deep.at(0, 0)[0], 0x10);
  EXPECT_EQ(deep.at(0, 0)[1], 0x80);
  EXPECT_EQ(deep.at(0, 0)[2], 0xF0);
}

// Four pixels of a palette of two colours: the last two name what it does not have.
TEST(Photograph, AColourThatThePaletteLacksIsBlack) {
  const tests::TemporaryFolder folder;
  const std::string rows("\0\0\1\2\xFF", 5), palette("\x10\x20\x30\x40\x50\x60", 6);
  write_file(folder / "p.png", std::string_view(png_of(4, 1, 8, 3, rows, palette)));
  const Picture picture = read_picture(folder / "p.png");
  for (int c = 0; c < 3; ++c) {
    EXPECT_EQ(picture.at(0, 0)[c], 0x10 * (c + 1));
    EXPECT_EQ(picture.at(1, 0)[c], 0x40 + 0x10 * c);
    EXPECT_TRUE(picture.at(2, 0)[c] == 0 && picture.at(3, 0)[c] == 0);
  }
  write_file(folder / "p.png", std::string_view(png_of(4, 1, 8, 3, rows, palette.substr(1))));
  EXPECT_NE(reason_of(folder / "p.png").find("damaged"), std::string::npos) << "a palette of a colour and a half";
}

// What phones keep behind a picture's end, such as a film, looks like anything, tables of codes too.
TEST(Photograph, WhatLiesBehindItsEndChangesNothing) {
  const tests::TemporaryFolder folder;
  const std::string whole = jpeg_with(""), table = "\xFF\xC4" + big_endian(19, 2) + '\0' + std::string(16, '\xFF');
  write_file(folder / "film.jpg", std::string_view(whole + table + "\xFF\xDA" + big_endian(8, 2)));
  write_file(folder / "p.jpg", std::string_view(whole));
  EXPECT_EQ(read_picture(folder / "film.jpg").rgb, read_picture(folder / "p.jpg").rgb);
  write_file(folder / "before.jpg", std::string_view(jpeg_with(table)));  // the control
  EXPECT_NE(reason_of(folder / "before.jpg").find("a table of codes is too long"), std::string::npos);
}

// As cameras of drones leave them.
TEST(Photograph, BytesBeforeItsEndChangeNothing) {
  using namespace std::string_literals;
  const tests::TemporaryFolder folder;
  const std::string whole = jpeg_with("");
  write_file(folder / "p.jpg", std::string_view(whole));
  for (const std::string& between : {"\0\0\xFF\0\0\0\xFF\0"s, "\xFF\x55\x12\xFF\xFF\0"s, std::string(5000, '\0')}) {
    std::string longer = whole;
    write_file(folder / "longer.jpg", std::string_view(longer.insert(whole.size() - 2, between)));
    EXPECT_EQ(read_picture(folder / "longer.jpg").rgb, read_picture(folder / "p.jpg").rgb);
  }
}

// Xcode rewrites PNGs: a chunk more, no frame around the compressed data, blue before red, and colours times alpha.
TEST(Photograph, APngThatXcodeRewroteHasItsColours) {
  const tests::TemporaryFolder folder;
  std::string file = png_of(2, 1, 8, 6, std::string("\0\x0A\x14\x1E\xFF\x10\x20\x30\x80", 9));
  const size_t frame = file.find("\x78\x01\x01");
  file.erase(frame, 2);
  file[frame - 5] = static_cast<char>(file[frame - 5] - 6);  // the chunk has neither its head nor its checksum
  file.erase(file.find("IEND") - 12, 4);
  file.insert(8, big_endian(4, 4) + "CgBI" + big_endian(0x50002006, 4) + big_endian(0, 4));
  write_file(folder / "x.png", std::string_view(file));
  // The second pixel is half as opaque: its colours were twice as bright, to the rounding of a byte.
  EXPECT_EQ(read_picture(folder / "x.png").rgb,
            (std::vector<uint8_t>{30, 20, 10, (0x30 * 255 + 0x40) / 0x80, (0x20 * 255 + 0x40) / 0x80,
                                  (0x10 * 255 + 0x40) / 0x80}));
}

/* ---- what its numbers stand for ---- */

constexpr double k_srgb_seen[] = {.4361, .2225, .0139, .3851, .7169, .0971, .1431, .0606, .7141};
constexpr double k_p3_seen[] = {.5151, .2412, -.0011, .2920, .6922, .0419, .1571, .0666, .7841};

// A profile of three colours, as they are seen under D50, and one curve.
std::string icc(const double* seen, const std::string& curve) {
  const auto fixed = [](double x) { return big_endian(static_cast<uint32_t>(std::lround(65536 * x)), 4); };
  std::string tags = big_endian(6, 4), content;
  const auto add = [&](const char* name, const std::string& bytes) {
    tags += name + big_endian(static_cast<uint32_t>(128 + 4 + 6 * 12 + content.size()), 4) +
            big_endian(static_cast<uint32_t>(bytes.size()), 4);
    content += bytes;
  };
  for (const char* name : {"rXYZ", "gXYZ", "bXYZ"}) {
    std::string xyz = "XYZ " + big_endian(0, 4);
    for (int i = 0; i < 3; ++i) xyz += fixed(*seen++);
    add(name, xyz);
  }
  for (const char* name : {"rTRC", "gTRC", "bTRC"}) add(name, curve);
  return std::string(16, '\0') + "RGB XYZ " + std::string(104, '\0') + tags + content;
}
std::string srgb_curve() {  // ((x + .055) / 1.055)^2.4, and x / 12.92 below .04045
  std::string curve = "para" + big_endian(0, 4) + big_endian(3, 2) + big_endian(0, 2);
  for (const double x : {2.4, 1 / 1.055, .055 / 1.055, 1 / 12.92, .04045})
    curve += big_endian(static_cast<uint32_t>(std::lround(65536 * x)), 4);
  return curve;
}
std::string srgb_table() {
  std::string curve = "curv" + big_endian(0, 4) + big_endian(256, 4);
  for (int i = 0; i < 256; ++i)
    curve += big_endian(static_cast<uint32_t>(std::lround(65535 * linear_of(static_cast<uint8_t>(i)))), 2);
  return curve;
}
const std::string k_linear_curve = "curv" + big_endian(0, 8);

// The first pixel of a picture, and what was said on stderr.
struct Read {
  std::vector<int> pixel;
  std::string said;
};
Read read_first(const std::string& content) {
  const tests::TemporaryFolder folder;
  write_file(folder / "p", std::string_view(content));
  testing::internal::CaptureStderr();
  const Picture picture = read_picture(folder / "p");
  return {{picture.rgb[0], picture.rgb[1], picture.rgb[2]}, testing::internal::GetCapturedStderr()};
}
Read read_png(const std::string& pixel, const std::string& before) {
  return read_first(png_of(1, 1, pixel.size() == 6 ? 16 : 8, 2, '\0' + pixel, "", before));
}

int srgb_of_light(double light) { return static_cast<int>(std::lround(255 * srgb_of(light))); }

const std::string k_pixel = "\xC8\x64\x32";  // 200, 100, 50
const std::vector<int> k_as_stored = {200, 100, 50};
// Of Display P3: by the matrix that CSS Color 4 gives, from linear Display P3 to linear sRGB.
std::vector<int> k_from_p3() {
  constexpr double k_matrix[3][3] = {
      {1.2249401763, -.2249401763, 0}, {-.0420569547, 1.0420569547, 0}, {-.0196375546, -.0786360456, 1.0982736001}};
  std::vector<int> out;
  for (const auto& row : k_matrix)
    out.push_back(srgb_of_light(row[0] * linear_of(200) + row[1] * linear_of(100) + row[2] * linear_of(50)));
  return out;
}

TEST(PictureColour, APngIsReadByWhatItSaysOfItsNumbers) {
  const auto gamma = [](uint32_t hundred_thousandths) { return chunk("gAMA", big_endian(hundred_thousandths, 4)); };
  const auto cicp = [](const char* codes) { return chunk("cICP", std::string(codes, 4)); };
  std::vector<int> linear, power;
  for (const int byte : k_as_stored) {
    linear.push_back(srgb_of_light(byte / 255.0));
    power.push_back(srgb_of_light(std::pow(byte / 255.0, 1.8)));
  }
  EXPECT_EQ(read_png(k_pixel, "").pixel, k_as_stored);  // the control: without a word it is sRGB
  EXPECT_EQ(read_png(k_pixel, gamma(100000)).pixel, linear);
  EXPECT_EQ(read_png(k_pixel, gamma(55556)).pixel, power);
  EXPECT_EQ(read_png(k_pixel, gamma(0)).pixel, k_as_stored);
  EXPECT_EQ(read_png(k_pixel, gamma(100000) + chunk("sRGB", std::string(1, '\0'))).pixel, k_as_stored);
  EXPECT_EQ(read_png(k_pixel, cicp("\1\x8\0\1") + chunk("sRGB", std::string(1, '\0'))).pixel, linear);
  EXPECT_EQ(read_png(k_pixel, cicp("\xC\xD\0\1")).pixel, k_from_p3());
  // Primaries alone, of Display P3: x and y of white, red, green and blue.
  std::string primaries;
  for (const uint32_t x : {31270, 32900, 68000, 32000, 26500, 69000, 15000, 6000}) primaries += big_endian(x, 4);
  EXPECT_EQ(read_png(k_pixel, chunk("cHRM", primaries)).pixel, k_from_p3());
  EXPECT_EQ(read_png(k_pixel, chunk("cHRM", std::string(32, '\0'))).pixel, k_as_stored);
  // Dark light of 16 bits keeps its steps: as 8 bits it would be black.
  EXPECT_EQ(read_png(std::string("\0\x80\0\x80\0\x80", 6), gamma(100000)).pixel,
            std::vector<int>(3, srgb_of_light(128 / 65535.0)));
  // White of HLG, and of PQ, as BT.2408 puts it: 75 and 58 % of the signal. Half of that light is as in BT.2100.
  EXPECT_NEAR(read_png("\xBF\xBF\xBF", cicp("\x9\x12\0\1")).pixel[0], 255, 1);
  EXPECT_NEAR(read_png("\x94\x94\x94", cicp("\x9\x10\0\1")).pixel[0], 255, 1);
  EXPECT_NEAR(read_png("\x80\x80\x80", cicp("\x9\x12\0\1")).pixel[0], srgb_of_light(1.0 / 12 / .26496), 1);
  const Read unknown = read_png(k_pixel, cicp("\x2\x2\0\1"));
  EXPECT_EQ(unknown.pixel, k_as_stored);
  EXPECT_NE(unknown.said.find("cICP"), std::string::npos) << unknown.said;
}

TEST(PictureColour, AProfileIsHonouredOrNamed) {
  const auto in_png = [](const std::string& profile) {
    return read_png(k_pixel, chunk("iCCP", std::string("any name\0\0", 10) + stored(profile)));
  };
  for (const std::string& curve : {srgb_curve(), srgb_table()}) {
    EXPECT_EQ(in_png(icc(k_srgb_seen, curve)).pixel, k_as_stored);
    EXPECT_EQ(in_png(icc(k_srgb_seen, curve)).said, "");
    EXPECT_EQ(in_png(icc(k_p3_seen, curve)).pixel, k_from_p3());
    EXPECT_EQ(in_png(icc(k_p3_seen, curve)).said, "");
  }
  constexpr double k_adobe[] = {.6097, .3111, .0195, .2053, .6257, .0609, .1492, .0632, .7446};
  const std::string power = "curv" + big_endian(0, 4) + big_endian(1, 4) + big_endian(0x0233, 2);
  for (const std::string& profile : {icc(k_srgb_seen, k_linear_curve), icc(k_adobe, power), std::string("damaged")}) {
    const std::string said = in_png(profile).said, words = "its colour profile is neither sRGB nor Display P3";
    EXPECT_EQ(in_png(profile).pixel, k_as_stored);
    EXPECT_NE(said.find(words), std::string::npos) << said;
    EXPECT_EQ(std::count(said.begin(), said.end(), '\n'), 1) << said;
  }
  // In a JPEG: the first block is red.
  const auto in_jpeg = [](const std::string& profile) {
    const std::string content = std::string("ICC_PROFILE\0\1\1", 14) + profile;
    return read_first(jpeg_with("\xFF\xE2" + big_endian(static_cast<uint32_t>(content.size() + 2), 2) + content));
  };
  const int red = in_jpeg(icc(k_srgb_seen, srgb_curve())).pixel[0];
  EXPECT_NEAR(red, 250, 2);
  EXPECT_EQ(in_jpeg(icc(k_srgb_seen, srgb_curve())).said, "");
  EXPECT_EQ(in_jpeg(icc(k_p3_seen, srgb_curve())).pixel[0], 255);  // more red than sRGB can be
  EXPECT_NE(in_jpeg(icc(k_srgb_seen, k_linear_curve)).said.find("neither sRGB"), std::string::npos);
}

TEST(Photograph, WhatIsNotReadIsNamed) {
  const tests::TemporaryFolder folder;
  const auto said_of = [&](const std::string& content) {
    write_file(folder / "p", std::string_view(content));
    return reason_of(folder / "p");
  };
  EXPECT_NE(said_of(png_of(20000, 1, 8, 0, "")).find("20000 x 1 pixels"), std::string::npos);
  EXPECT_NE(said_of(png_of(16384, 16384, 8, 0, "")).find("16384 x 16384 pixels"), std::string::npos);
  std::string print = jpeg_with("");
  const size_t frame = print.find("\xFF\xC0");
  ASSERT_NE(frame, std::string::npos);
  print[frame + 9] = 4;  // colours
  EXPECT_NE(said_of(print).find("CMYK"), std::string::npos);
  print[frame + 9] = 3;
  print[frame + 4] = 12;  // bits
  EXPECT_NE(said_of(print).find("12 bits a colour"), std::string::npos);
  // Of two frames stb decodes the first.
  std::string two = jpeg_with("");
  const std::string small = two.substr(frame, 2 + 17);  // a frame of three colours has 17 bytes
  two.replace(frame + 5, 4, big_endian(16384, 2) + big_endian(16000, 2));
  EXPECT_NE(said_of(two.insert(two.size() - 2, small)).find("16000 x 16384 pixels"), std::string::npos);
  EXPECT_NE(said_of(std::string("\0\0\0\x18"
                                "ftypheic\0\0\0\0",
                                16))
                .find("HEIC"),
            std::string::npos);
  EXPECT_NE(said_of("RIFF....WEBPVP8 ").find("WebP"), std::string::npos);
  EXPECT_NE(said_of("GIF89a").find("GIF"), std::string::npos);
  EXPECT_NE(said_of("version https://git-lfs.github.com/spec/v1\noid sha256:0\nsize 9\n").find("Git LFS pointer"),
            std::string::npos);
  EXPECT_NE(said_of("text").find("no PNG or JPEG"), std::string::npos);
  // stb_image would write 16 x 255 codes into 257 places.
  EXPECT_NE(said_of(jpeg_with("\xFF\xC4" + big_endian(2 + 17, 2) + '\0' + std::string(16, '\xFF'))).find("table"),
            std::string::npos);
  EXPECT_NE(said_of(jpeg_with("").substr(0, 300)).find("damaged"), std::string::npos);
}

}  // namespace
}  // namespace sandglass::host
