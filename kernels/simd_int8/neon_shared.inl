// What the three ARM sets have in common, included in the namespace of each. Activations become signed bytes when they
// are loaded (their value less 128), because the byte products used here (SMULL, SDOT, SMMLA) take signed bytes only.

constexpr bool k_signed = true;
constexpr uint32_t k_sum_lanes = 4;
constexpr uint32_t k_row_texels = 4;
constexpr uint32_t k_bytes = 16;

struct Sum {
  int32x4_t v;
};

SANDGLASS_INT8_INLINE Sum load_bias(const int32_t* p) { return {vld1q_s32(p)}; }

SANDGLASS_INT8_INLINE int8x16_t load_signed(const uint8_t* p) {
  return vreinterpretq_s8_u8(veorq_u8(vld1q_u8(p), vdupq_n_u8(0x80)));
}

SANDGLASS_INT8_INLINE uint32x4_t round_sums(int32x4_t sum, const float* multiplier) {
  float32x4_t x = vmulq_f32(vcvtq_f32_s32(sum), vld1q_f32(multiplier));
  x = vminq_f32(vmaxq_f32(x, vdupq_n_f32(0.0f)), vdupq_n_f32(255.0f));
  return vcvtnq_u32_f32(x);
}
// Writes 16 neighbouring channels.
SANDGLASS_INT8_INLINE void requantise(const Sum* sums, const float* multiplier, uint8_t* out) {
  const uint16x8_t low =
      vcombine_u16(vmovn_u32(round_sums(sums[0].v, multiplier)), vmovn_u32(round_sums(sums[1].v, multiplier + 4)));
  const uint16x8_t high =
      vcombine_u16(vmovn_u32(round_sums(sums[2].v, multiplier + 8)), vmovn_u32(round_sums(sums[3].v, multiplier + 12)));
  vst1q_u8(out, vcombine_u8(vmovn_u16(low), vmovn_u16(high)));
}

SANDGLASS_INT8_INLINE void first_layer(const int16_t* columns, const int16_t* rows, uint32_t width, uint32_t shift,
                                       uint8_t* out) {
  const int16x8_t by = vdupq_n_s16(static_cast<int16_t>(-static_cast<int32_t>(shift)));
  for (uint32_t c = 0; c < width; c += 16) {
    const int16x8_t low = vshlq_s16(vqaddq_s16(vld1q_s16(columns + c), vld1q_s16(rows + c)), by);
    const int16x8_t high = vshlq_s16(vqaddq_s16(vld1q_s16(columns + c + 8), vld1q_s16(rows + c + 8)), by);
    vst1q_u8(out + c, vcombine_u8(vqmovun_s16(low), vqmovun_s16(high)));
  }
}

struct Bytes {
  uint8x16_t v;
};
SANDGLASS_INT8_INLINE Bytes load_bytes(const uint8_t* p) { return {vld1q_u8(p)}; }
SANDGLASS_INT8_INLINE void store_bytes(uint8_t* p, Bytes b) { vst1q_u8(p, b.v); }
SANDGLASS_INT8_INLINE Bytes maximum(Bytes a, Bytes b) { return {vmaxq_u8(a.v, b.v)}; }
SANDGLASS_INT8_INLINE Bytes minimum(Bytes a, Bytes b) { return {vminq_u8(a.v, b.v)}; }
SANDGLASS_INT8_INLINE Bytes average(const Bytes (&four)[4]) {
  uint16x8_t low = vaddl_u8(vget_low_u8(four[0].v), vget_low_u8(four[1].v));
  uint16x8_t high = vaddl_high_u8(four[0].v, four[1].v);
  for (uint32_t i = 2; i < 4; ++i) {
    low = vaddw_u8(low, vget_low_u8(four[i].v));
    high = vaddw_high_u8(high, four[i].v);
  }
  return {vcombine_u8(vrshrn_n_u16(low, 2), vrshrn_n_u16(high, 2))};
}

struct Mixture {
  int32x4_t v[4];
};
SANDGLASS_INT8_INLINE Mixture mixture_of(int32_t start) {
  const int32x4_t all = vdupq_n_s32(start);
  return {{all, all, all, all}};
}
SANDGLASS_INT8_INLINE void mix_one(Mixture* sums, const int8_t* p, int16_t weight) {
  const int8x16_t bytes = vld1q_s8(p);
  const int16x8_t low = vmovl_s8(vget_low_s8(bytes)), high = vmovl_high_s8(bytes), all = vdupq_n_s16(weight);
  sums->v[0] = vmlal_s16(sums->v[0], vget_low_s16(low), vget_low_s16(all));
  sums->v[1] = vmlal_high_s16(sums->v[1], low, all);
  sums->v[2] = vmlal_s16(sums->v[2], vget_low_s16(high), vget_low_s16(all));
  sums->v[3] = vmlal_high_s16(sums->v[3], high, all);
}
SANDGLASS_INT8_INLINE void mix(Mixture* sums, const int8_t* first, const int8_t* second, int16_t a, int16_t b) {
  mix_one(sums, first, a);
  mix_one(sums, second, b);
}
SANDGLASS_INT8_INLINE Bytes visibility_of(const Mixture& sums, uint32_t shift) {
  const int32x4_t by = vdupq_n_s32(-static_cast<int32_t>(shift));
  const int16x8_t low = vqmovn_high_s32(vqmovn_s32(vshlq_s32(sums.v[0], by)), vshlq_s32(sums.v[1], by));
  const int16x8_t high = vqmovn_high_s32(vqmovn_s32(vshlq_s32(sums.v[2], by)), vshlq_s32(sums.v[3], by));
  return {vmvnq_u8(vqmovun_high_s16(vqmovun_s16(low), high))};
}

SANDGLASS_INT8_INLINE int32_t dot_row(const uint8_t* a, const int8_t* w, uint32_t width) {
  int32x4_t sum = vdupq_n_s32(0);
  for (uint32_t c = 0; c < width; c += 16) {
    const uint8x16_t x = vld1q_u8(a + c);
    const int8x16_t y = vld1q_s8(w + c);
    const int16x8_t low = vreinterpretq_s16_u16(vmovl_u8(vget_low_u8(x)));
    const int16x8_t high = vreinterpretq_s16_u16(vmovl_u8(vget_high_u8(x)));
    const int16x8_t low_weights = vmovl_s8(vget_low_s8(y)), high_weights = vmovl_s8(vget_high_s8(y));
    sum = vmlal_s16(sum, vget_low_s16(low), vget_low_s16(low_weights));
    sum = vmlal_s16(sum, vget_high_s16(low), vget_high_s16(low_weights));
    sum = vmlal_s16(sum, vget_low_s16(high), vget_low_s16(high_weights));
    sum = vmlal_s16(sum, vget_high_s16(high), vget_high_s16(high_weights));
  }
  return vaddvq_s32(sum);
}
