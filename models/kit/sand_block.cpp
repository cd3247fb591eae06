// Makes the block of packed grains (grain_block.h), or, where FILE ends in .png, the texture of plain.frag.
//
//   sand_block FILE [RED GREEN BLUE SHARE, up to 4 times]
//
// Minerals are linear albedos of single grains and their shares, as in uniforms.glsl; without them it is sand of a beach. In
// a page it is a module: sand_block_make(minerals) gives the address of what the file holds.
#include "models/kit/grain_block.h"

using namespace sandglass::kit;

#ifdef __wasm__
extern "C" __attribute__((export_name("sand_block_make"))) const uint8_t* sand_block_make(const float* minerals) {
  static std::vector<uint8_t> bytes;
  bytes = sand_block(minerals ? reinterpret_cast<const Mineral*>(minerals) : k_beach);
  return bytes.data();
}
#else
#include <cstdio>
#include <cstdlib>
#include <string_view>

#include "models/files/failure.h"
#include "models/files/image.h"

int main(int count, char** arguments) {
  Mineral minerals[4] = {};
  const int given = (count - 2) / 4;
  bool right = count >= 2 && count == 2 + 4 * given && given <= 4;
  for (int i = 0; right && i < 4 * given; ++i) {
    char* end = nullptr;
    const float value = std::strtof(arguments[2 + i], &end);
    right = *end == '\0' && end != arguments[2 + i] && value >= 0.0f && value <= 1.0f;
    (i % 4 < 3 ? minerals[i / 4].albedo[i % 4] : minerals[i / 4].share) = value;
  }
  if (!right) {
    std::fprintf(stderr, "sand_block FILE [RED GREEN BLUE SHARE, up to 4 times]: albedos and shares are 0 to 1.\n");
    return 2;
  }
  if (std::string_view(arguments[1]).ends_with(".png")) try {
      const std::vector<float> bed = bed_of_grains(given > 0 ? minerals : k_beach);
      sandglass::host::Picture picture(k_bed_side, k_bed_side, {});
      for (size_t i = 0; i < bed.size(); ++i) picture.rgb[i] = sandglass::host::srgb_byte(static_cast<double>(bed[i]));
      sandglass::host::write_png(arguments[1], picture);
      return 0;
    } catch (const sandglass::host::Failure& failure) {
      std::fprintf(stderr, "sand_block: %s\n", failure.what());
      return 1;
    }
  const std::vector<uint8_t> bytes = sand_block(given > 0 ? minerals : k_beach);
  std::FILE* file = std::fopen(arguments[1], "wb");
  const bool written = file && std::fwrite(bytes.data(), 1, bytes.size(), file) == bytes.size();
  if ((file && std::fclose(file) != 0) || !written) {
    std::fprintf(stderr, "sand_block: cannot write \"%s\". Choose a folder that exists and has room.\n", arguments[1]);
    return 1;
  }
  return 0;
}
#endif
