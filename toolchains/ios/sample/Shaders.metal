// Draws the camera image over the whole view, and each grain as a round point with the shading of a sphere. The
// attachment encodes to sRGB, so colours are linear here. The shadow between the two is drawn by ShadowCatcher.metal.
#include <metal_stdlib>
#include "shader_types.h"
using namespace metal;

struct ImageVertex {
  float4 position [[position]];
  float2 uv;
};

vertex ImageVertex image_vertex(uint index [[vertex_id]], constant ShaderFrame& frame [[buffer(ShaderBufferFrame)]]) {
  const float2 corner = float2(index & 1, index >> 1);
  ImageVertex out;
  out.position = float4(2.0f * corner.x - 1.0f, 1.0f - 2.0f * corner.y, 1.0f, 1.0f);
  const float4 view = float4(corner, 1.0f, 0.0f);
  out.uv = float2(dot(frame.image_from_view[0], view), dot(frame.image_from_view[1], view));
  return out;
}

float3 to_linear(float3 c) { return select(pow((c + 0.055f) / 1.055f, 2.4f), c / 12.92f, c <= 0.04045f); }

// Full-range BT.601, as ARKit captures.
fragment float4 image_fragment(ImageVertex in [[stage_in]], texture2d<float> luma [[texture(0)]], texture2d<float> chroma [[texture(1)]]) {
  constexpr sampler linear(filter::linear);
  const float y = luma.sample(linear, in.uv).r;
  const float2 c = chroma.sample(linear, in.uv).rg - 0.5f;
  const float3 encoded = float3(y + 1.402f * c.y, y - 0.344f * c.x - 0.714f * c.y, y + 1.772f * c.x);
  return float4(to_linear(saturate(encoded)), 1.0f);
}

struct Grain {
  packed_float3 position;
  float speed;
};

struct SandVertex {
  float4 position [[position]];
  float size [[point_size]];
  float visibility;  // of all light but the main one
};

vertex SandVertex sand_vertex(uint index [[vertex_id]], constant ShaderFrame& frame [[buffer(ShaderBufferFrame)]],
                              constant Grain* grains [[buffer(ShaderBufferGrains)]],
                              texture2d<float> sky_on_sand [[texture(0)]]) {
  constexpr sampler linear(filter::linear, address::clamp_to_edge);
  const float2 low = frame.rectangle.xy, high = frame.rectangle.zw;
  SandVertex out;
  out.visibility = sky_on_sand.sample(linear, (float3(grains[index].position).xz - low) / (high - low), level(0)).r;
  out.position = frame.clip_from_world * float4(float3(grains[index].position) + frame.origin.xyz, 1.0f);
  out.size = frame.point_size / out.position.w;
  return out;
}

fragment float4 sand_fragment(SandVertex in [[stage_in]], float2 at [[point_coord]],
                              constant ShaderFrame& frame [[buffer(ShaderBufferFrame)]]) {
  const float2 p = float2(2.0f * at.x - 1.0f, 1.0f - 2.0f * at.y);
  const float r2 = dot(p, p);
  if (r2 > 1.0f) discard_fragment();
  const float3 normal = float3(p, sqrt(1.0f - r2));
  const float3 to_light = (frame.view_from_world * float4(frame.to_light.xyz, 0.0f)).xyz;
  const float3 light = in.visibility * frame.ambient.rgb + frame.sun.rgb * saturate(dot(normal, to_light));
  return float4(float3(0.53f, 0.34f, 0.13f) * light, 1.0f);
}
