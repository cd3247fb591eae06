// What the shaders are given, seen from both sides.
#pragma once
#include <simd/simd.h>

enum { ShaderBufferFrame = 0, ShaderBufferGrains = 1 };

struct ShaderFrame {
  simd_float4x4 clip_from_world;
  simd_float4x4 view_from_world;
  simd_float4 image_from_view[2];  // rows of the affine map from the view, 0..1 downward, to the camera image
  simd_float4 to_light;            // unit vector, world
  simd_float4 sun;                 // what a white surface that faces the light gives back of it, linear RGB
  simd_float4 ambient;             // and of all the rest
  simd_float4 origin;              // of the sand's scene, in the session's world
  float point_size;                // pixels at a distance of 1
};

// As ShadowPlace of ShadowCatcher.metal.
struct ShaderShadow {
  simd_float4x4 clip_from_object;
  simd_float4 rectangle;
  float plane;
  float strength;
};
