// Files of networks with random weights, on which the runtime's tests run without any baking.
#pragma once

#include <cstdint>
#include <vector>

#include "sandglass/shadow.h"

namespace sandglass::tests {

struct RandomShadow {
  uint32_t width = 32, layers = 2, texel_frequencies = 4, light_frequencies = 2;
  uint64_t seed = 1;
  float spread = 1;          // spread of the first layer's weights
  bool zero = false;         // all weights and biases 0
  bool extreme = false;      // hidden weights are -127 or 127
  int8_t forced_weight = 0;  // if not 0, put into the first hidden layer
  float forced_first = 0;    // if not 0 (NaN, for example), put into the first layer
  uint16_t version = 1;
  // An ambient shadow with random components, and a surface. Only files of version 2 have them.
  uint32_t ambient_side = 0, components = 0;
  uint32_t surface_vertices = 0;
  bool unsorted_surface = false;
  float forced_mixing = 0;      // if not 0, put into the first component
  uint32_t missing_texels = 0;  // that the file lacks
};

// A file with its checksum, in 8-byte words so that it is aligned.
struct AssetFile {
  std::vector<uint64_t> words;
  uint64_t bytes = 0;
  uint8_t* data() { return reinterpret_cast<uint8_t*>(words.data()); }
  const uint8_t* data() const { return reinterpret_cast<const uint8_t*>(words.data()); }
};

AssetFile make_shadow_file(const RandomShadow& what);
AssetFile copy_of(const uint8_t* bytes, uint64_t count);
void repair_checksum(AssetFile* file);

// The instruction sets that this CPU runs.
std::vector<sandglass_isa> available_sets();

// A block aligned as the library asks, with guard bytes behind it.
class Block {
 public:
  explicit Block(uint64_t bytes);
  ~Block();
  Block(const Block&) = delete;
  Block& operator=(const Block&) = delete;
  void* data() { return data_; }
  bool guards_intact() const;
  bool untouched() const;

 private:
  uint8_t* data_;
  uint64_t bytes_;
};

sandglass_shadow_desc describe(const AssetFile& file, sandglass_isa isa = SANDGLASS_ISA_AUTOMATIC,
                               sandglass_shadow_mode mode = SANDGLASS_SHADOW_ADAPTIVE);

// A shadow and its memory.
struct LiveShadow {
  explicit LiveShadow(const sandglass_shadow_desc& desc);
  void light(float x, float y, float z);
  void finish();
  void shade(float x, float y, float z) { light(x, y, z), finish(); }  // the whole texture of this light
  sandglass_shadow_texture texture(uint32_t light = 0) const;
  std::vector<uint8_t> coverage(uint32_t light = 0) const;

  Block block;
  sandglass_shadow* shadow = nullptr;
};

}  // namespace sandglass::tests
