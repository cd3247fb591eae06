// The arguments of the shaders, as the app and the shaders see them.
#pragma once
#include <simd/simd.h>

enum { ShaderBufferFrame = 0, ShaderBufferGrains = 1 };

struct ShaderFrame {
  simd_float4x4 clip_from_world;
  simd_float4x4 view_from_world;
  // The rows of the affine map from the view (0..1, y downward) to the camera image.
  simd_float4 image_from_view[2];
  simd_float4 to_light;  // unit vector in the world
  // Linear RGB that a white surface facing the main light reflects of it, and that one facing up reflects of all other
  // light.
  simd_float4 sun, ambient;
  simd_float4 rectangle;  // of the texture of what the sand leaves of that other light
  simd_float4 origin;     // the origin of the sand's scene in the session's world
  float point_size;       // a grain's diameter in pixels at a distance of 1 m
};

// The same as ShadowPlace in ShadowCatcher.metal; its strength is not read.
struct ShaderShadow {
  simd_float4x4 clip_from_object;
  simd_float4 rectangle;
  float plane;
  float strength;
};

// The same as RoomShadowPlace there.
struct ShaderRoomShadow {
  simd_float4 light_rectangle, ambient_rectangle;
  float strength;
};
