// The arguments of the shaders, as the app and the shaders see them.
#pragma once
#include <simd/simd.h>

struct ShaderFrame {
  simd_float4x4 clip_from_world, view_from_world;
  simd_float4 to_light, sun, ambient;      // sample::Shading
  simd_float4 origin;                      // of the sand, in the session's world
  float pixels_at_one_metre, share, span;  // a grain's diameter; sample::Buffers
  // Of the table: sample::Shadows, and the depth of what is real.
  simd_float4 boxes[4];
  simd_float3x3 depth_from_screen;  // shares of the viewport, from its upper left corner, to shares of the depth image
  simd_float2 viewport, eye, slide, layers;  // eye: x and z; layers: of the object's two textures, less 1
  float half_side, main_share, sand_opacity, eye_height, depth_bias, height;  // metres, shares; height: of the layers
};
