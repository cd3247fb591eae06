// Four lanes of 32 bits have no compress instruction on ARM and in WebAssembly. For each of the sixteen masks a byte shuffle
// puts the kept lanes first.
#define SANDGLASS_LANE(l) 4 * (l), 4 * (l) + 1, 4 * (l) + 2, 4 * (l) + 3
#define SANDGLASS_SHUFFLE(a, b, c, d) \
  { SANDGLASS_LANE(a), SANDGLASS_LANE(b), SANDGLASS_LANE(c), SANDGLASS_LANE(d) }
alignas(16) constexpr uint8_t k_compress[16][16] = {
    SANDGLASS_SHUFFLE(0, 0, 0, 0), SANDGLASS_SHUFFLE(0, 0, 0, 0), SANDGLASS_SHUFFLE(1, 0, 0, 0),
    SANDGLASS_SHUFFLE(0, 1, 0, 0), SANDGLASS_SHUFFLE(2, 0, 0, 0), SANDGLASS_SHUFFLE(0, 2, 0, 0),
    SANDGLASS_SHUFFLE(1, 2, 0, 0), SANDGLASS_SHUFFLE(0, 1, 2, 0), SANDGLASS_SHUFFLE(3, 0, 0, 0),
    SANDGLASS_SHUFFLE(0, 3, 0, 0), SANDGLASS_SHUFFLE(1, 3, 0, 0), SANDGLASS_SHUFFLE(0, 1, 3, 0),
    SANDGLASS_SHUFFLE(2, 3, 0, 0), SANDGLASS_SHUFFLE(0, 2, 3, 0), SANDGLASS_SHUFFLE(1, 2, 3, 0),
    SANDGLASS_SHUFFLE(0, 1, 2, 3)};
#undef SANDGLASS_SHUFFLE
#undef SANDGLASS_LANE
