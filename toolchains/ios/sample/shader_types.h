// What the shaders are given, seen from both sides.
#pragma once
#include <simd/simd.h>

enum { ShaderBufferFrame = 0, ShaderBufferGrains = 1 };

struct ShaderFrame {
  simd_float4x4 clip_from_world;
  simd_float4 image_from_view[2];  // rows of the affine map from the view, 0..1 downward, to the camera image
  simd_float4 origin;              // of the sand's scene, in the session's world
  float point_size;                // pixels at a distance of 1
};
