// The arguments of the shaders, as the app and the shaders see them.
#pragma once
#include <simd/simd.h>

struct ShaderFrame {
  simd_float4x4 clip_from_world, view_from_world;
  simd_float4 to_light, sun, ambient;  // sample::Shading
  simd_float4 origin;                  // of the sand, in the session's world
  float pixels_at_one_metre;           // a grain's diameter
};
