// Photographs as people have them: held in any way, in grey, with 16 bits, for print, too wide, or of another kind.
#include <gtest/gtest.h>

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

// A PNG without compression; readers do not look at its checksums.
std::string png_of(uint32_t width, uint32_t height, int bits, int colour_type, const std::string& rows,
                   const std::string& palette = "") {
  const auto chunk = [](const std::string& kind, const std::string& content) {
    return big_endian(static_cast<uint32_t>(content.size()), 4) + kind + content + big_endian(0, 4);
  };
  const uint32_t size = static_cast<uint32_t>(rows.size());
  const std::string lengths = {static_cast<char>(size & 255), static_cast<char>(size >> 8),
                               static_cast<char>(~size & 255), static_cast<char>(~size >> 8 & 255)};
  return "\x89PNG\r\n\x1a\n" +
         chunk("IHDR", big_endian(width, 4) + big_endian(height, 4) + static_cast<char>(bits) +
                           static_cast<char>(colour_type) + std::string(3, '\0')) +
         (palette.empty() ? "" : chunk("PLTE", palette)) +
         chunk("IDAT", std::string("\x78\x01\x01", 3) + lengths + rows + big_endian(0, 4)) + chunk("IEND", "");
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
  print[frame + 9] = 3, print[frame + 4] = 12;  // bits
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
  EXPECT_NE(said_of("text").find("no PNG or JPEG"), std::string::npos);
  // stb_image would write 16 x 255 codes into 257 places.
  EXPECT_NE(said_of(jpeg_with("\xFF\xC4" + big_endian(2 + 17, 2) + '\0' + std::string(16, '\xFF'))).find("table"),
            std::string::npos);
  EXPECT_NE(said_of(jpeg_with("").substr(0, 300)).find("damaged"), std::string::npos);
}

}  // namespace
}  // namespace sandglass::host
