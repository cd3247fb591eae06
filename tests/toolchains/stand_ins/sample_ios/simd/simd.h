#pragma once
typedef float simd_float4 __attribute__((ext_vector_type(4)));
typedef float simd_float3 __attribute__((ext_vector_type(3)));
typedef struct {
  simd_float3 columns[3];
} simd_float3x3;
typedef struct {
  simd_float4 columns[4];
} simd_float4x4;
static const simd_float4x4 matrix_identity_float4x4 = {
    {{1.0f, 0.0f, 0.0f, 0.0f}, {0.0f, 1.0f, 0.0f, 0.0f}, {0.0f, 0.0f, 1.0f, 0.0f}, {0.0f, 0.0f, 0.0f, 1.0f}}};
static inline simd_float4 simd_make_float4(float x, float y, float z, float w) { return (simd_float4){x, y, z, w}; }
#ifdef __cplusplus
extern "C"
#endif
    simd_float4x4
    simd_mul(simd_float4x4 a, simd_float4x4 b);
