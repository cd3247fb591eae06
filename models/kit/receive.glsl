// For a surface of the app's own material: what shadows leave at a place, x of the main light, y of the room's. It has its own
// uniforms: textures and boxes as in uniforms.glsl; numbers: opacity of pile and object, sky_known, the floor's height.
uniform sampler2D sandglass_pile, sandglass_shadow, sandglass_occlusion, sandglass_sky;
#ifndef SANDGLASS_VECTORS_DECLARED  // by the engine, in a block
uniform vec4 sandglass_pile_box, sandglass_shadow_box, sandglass_occlusion_box, sandglass_numbers, sandglass_to_light;
#endif
float sandglass_at(sampler2D image, vec2 at, float outside) {
  return all(greaterThan(at, vec2(0))) && all(lessThan(at, vec2(1))) ? texture(image, at).r : outside;
}
vec2 sandglass_left(vec3 world) {
  vec3 l = sandglass_to_light.xyz;
  vec2 lies = (world.xz - sandglass_pile_box.xy) * sandglass_pile_box.zw, around = (world.xz - sandglass_occlusion_box.xy) * sandglass_occlusion_box.zw;
  vec2 behind = (world.xz - l.xz * ((world.y - sandglass_numbers.w) / max(l.y, 0.05)) - sandglass_shadow_box.xy) * sandglass_shadow_box.zw;
  float direct = (1.0 - sandglass_numbers.x * sandglass_at(sandglass_pile, lies, 0.0)) * (1.0 - sandglass_numbers.y * sandglass_at(sandglass_shadow, behind, 0.0));
  return vec2(direct, sandglass_at(sandglass_occlusion, around, 1.0) * (sandglass_numbers.z > 0.5 ? sandglass_at(sandglass_sky, lies, 1.0) : 1.0));
}
