// A vertex of a loose grain. Needs loose.glsl.
#ifdef VULKAN
#define gl_VertexID gl_VertexIndex
#endif
layout(location = 0) in vec4 place;  // and weight
layout(location = 1) in vec3 way;
#ifdef FLOAT_NUMBER  // where all attributes are floats
layout(location = 2) in float seed;
#define number uint(seed)
#else
layout(location = 2) in uint number;
#endif
flat out vec3 stands_at, up;
flat out float across, own;
flat out uint chance;
out vec2 at;
void main() {
  loose_grain(uint(gl_VertexID), place, way, number);
  gl_Position = grain_position, at = grain_at, across = grain_across;
  stands_at = grain_stands, up = grain_up, own = grain_own, chance = grain_seed;
}
