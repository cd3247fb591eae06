// What is read at the corners of a grain's cell, where a set has no shorter way (neon.h has one). Sets include it inside
// their namespaces.

// The sums over eight corners: each adds its share of the quad that is `offsets` of it behind the lane's pointer, in
// their order.
SANDGLASS_INLINE void blend_quads(const float* const* lanes, const uint32_t offsets[8], const Float share[8],
                                  Float out[4]) {
  for (int k = 0; k < 8; ++k) {
    Float quad[4];
    load_quads(lanes, offsets[k], quad);
    for (int c = 0; c < 4; ++c) out[c] = k == 0 ? share[k] * quad[c] : out[c] + share[k] * quad[c];
  }
}

// Two bytes `offset` behind each lane's pointer, and the two that are a row of bytes behind those. 16 bytes may be read.
template <uint32_t k_row>
SANDGLASS_INLINE Int load_byte_squares(const uint8_t* const* lanes, int32_t offset) {
  alignas(64) uint32_t squares[k_width];
  for (uint32_t l = 0; l < k_width; ++l) {
    uint16_t low, high;
    __builtin_memcpy(&low, lanes[l] + offset, 2);
    __builtin_memcpy(&high, lanes[l] + offset + k_row, 2);
    squares[l] = low | static_cast<uint32_t>(high) << 16;
  }
  return load(squares);
}
