// A grain: a round point with the shading of a sphere. And the table as the camera shows it, with what is real upon it, darkened by
// shadows (runtime/shadow/README.md). The attachment encodes to sRGB, so colours are linear.
#include <metal_stdlib>
#include "shader_types.h"
using namespace metal;

struct Corner {
  float4 position [[position]];
  float size [[point_size]];
};

vertex Corner grain_vertex(uint index [[vertex_id]], constant ShaderFrame& frame [[buffer(0)]],
                           constant float4* older_grains [[buffer(1)]], constant float4* newer_grains [[buffer(2)]]) {
  const float4 older = older_grains[index], newer = newer_grains[index];  // position and speed
  // One that went further than its speeds explain is new, removed, or another of that number.
  const float share = distance(older.xyz, newer.xyz) < frame.span * (older.w + newer.w) + 0.01f ? frame.share : 1.0f;
  Corner out;
  out.position = frame.clip_from_world * float4(mix(older.xyz, newer.xyz, share) + frame.origin.xyz, 1.0f);
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

struct TableCorner {
  float4 position [[position]];
  float2 place;  // from the sand's origin
  float depth;   // along the camera's axis
};

vertex TableCorner table_vertex(uint index [[vertex_id]], constant ShaderFrame& frame [[buffer(0)]]) {
  TableCorner out;
  out.place = frame.half_side * float2(2.0f * float(index & 1) - 1.0f, 2.0f * float(index >> 1) - 1.0f);
  out.position = frame.clip_from_world * float4(frame.origin.xyz + float3(out.place.x, 0.0f, out.place.y), 1.0f);
  out.depth = out.position.w;
  return out;
}

// 0: the object's shadow of the main light; 1: of the room's; 2, 3: the sand's.
static float shadow(texture2d<float> map, float4 box, float2 place, float layer, float outside) {  // sandglass/cast.h
  constexpr sampler linear(filter::linear, address::clamp_to_edge);
  const float2 p = (place - box.xy) * box.zw;
  const float number = float(map.get_height() / map.get_width()), lower = floor(layer), half_texel = 0.5f / float(map.get_width());
  const float row = clamp(p.y, half_texel, 1.0f - half_texel);
  const float low = map.sample(linear, float2(p.x, (lower + row) / number)).r;
  const float high = map.sample(linear, float2(p.x, (min(lower + 1.0f, number - 1.0f) + row) / number)).r;
  return all(p == saturate(p)) ? mix(low, high, layer - lower) : outside;
}

// Metres that what is real stands above the table; an eye below that sees nothing of what lies on it.
static float stands(texture2d<float> depth, constant ShaderFrame& frame, float2 pixel, float drawn) {
  const float2 size = float2(depth.get_width(), depth.get_height());
  const float2 p = (frame.depth_from_screen * float3(pixel / frame.viewport, 1.0f)).xy * size - 0.5f;
  const float2 part = fract(p);
  float sum = 0.0f;
  for (int i = 0; i < 4; ++i) {
    const float2 corner = float2(i & 1, i >> 1);
    const float real = depth.read(uint2(clamp(floor(p) + corner, float2(0.0f), size - 1.0f))).r;
    const float2 weight = mix(1.0f - part, part, corner);
    float before = drawn - real, above = 2.0f * frame.height;
    if (frame.eye_height > 0.0f) above = before = frame.eye_height * (1.0f - real / drawn);
    sum += weight.x * weight.y * (real > 0.0f ? above * smoothstep(frame.depth_bias, 2.0f * frame.depth_bias, before) : 0.0f);
  }
  return sum;
}

fragment float4 table_fragment(TableCorner in [[stage_in]], constant ShaderFrame& frame [[buffer(0)]],
                               array<texture2d<float>, 4> shadows [[texture(0)]],
                               texture2d<float> depth [[texture(4)]]) {
  const float s = frame.main_share, up = stands(depth, frame, in.position.xy, in.depth);
  const float2 from = frame.eye_height > 0.0f ? mix(in.place, frame.eye, up / frame.eye_height) : in.place;
  const float share = saturate(up / frame.height);  // of the layers' height
  const float sharp = (1.0f - shadow(shadows[0], frame.boxes[0], from - up * frame.slide, share * frame.layers[0], 0.0f)) *
                      (1.0f - frame.sand_opacity * shadow(shadows[2], frame.boxes[2], from, 0.0f, 0.0f));
  const float rest = max(shadow(shadows[1], frame.boxes[1], from, share * frame.layers[1], 1.0f) - s, 0.0f) *
                     max(shadow(shadows[3], frame.boxes[3], from, 0.0f, 1.0f) - s, 0.0f);
  const float left = s * sharp + (s < 1.0f ? rest / (1.0f - s) : 0.0f);
  // What stands higher, as a hand does, gets none.
  return float4(0.0f, 0.0f, 0.0f, (1.0f - left) * (1.0f - smoothstep(frame.height, 2.0f * frame.height, up)));
}
