// A grain: a round point with the shading of a sphere. The attachment encodes to sRGB, so colours are linear.
#include <metal_stdlib>
#include "shader_types.h"
using namespace metal;

struct Grain {
  packed_float3 position;
  float speed;
};

struct Corner {
  float4 position [[position]];
  float size [[point_size]];
};

vertex Corner grain_vertex(uint index [[vertex_id]], constant ShaderFrame& frame [[buffer(0)]],
                           constant Grain* grains [[buffer(1)]]) {
  Corner out;
  out.position = frame.clip_from_world * float4(float3(grains[index].position) + frame.origin.xyz, 1.0f);
  out.size = frame.pixels_at_one_metre / out.position.w;
  return out;
}

fragment float4 grain_fragment(float2 at [[point_coord]], constant ShaderFrame& frame [[buffer(0)]]) {
  const float2 p = float2(2.0f * at.x - 1.0f, 1.0f - 2.0f * at.y);
  const float r2 = dot(p, p);
  if (r2 > 1.0f) discard_fragment();
  const float3 to_light = (frame.view_from_world * float4(frame.to_light.xyz, 0.0f)).xyz;
  const float facing = saturate(dot(float3(p, sqrt(1.0f - r2)), to_light));
  return float4(float3(0.53f, 0.34f, 0.13f) * (frame.ambient.rgb + frame.sun.rgb * facing), 1.0f);
}
