#pragma once
typedef float simd_float4 __attribute__((ext_vector_type(4)));
typedef struct {
  simd_float4 columns[4];
} simd_float4x4;
static inline simd_float4 simd_make_float4(float x, float y, float z, float w) { return (simd_float4){x, y, z, w}; }
#ifdef __cplusplus
extern "C"
#endif
    simd_float4x4
    simd_mul(simd_float4x4 a, simd_float4x4 b);
