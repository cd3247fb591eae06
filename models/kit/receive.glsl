// For a surface of the app's own material: what shadows leave at a place, x of the main light, y of the room's. It has its own
// uniforms: textures and boxes as in uniforms.glsl; numbers: opacity of pile and object, sky_known, the floor's height. The objects'
// textures hold a cast's layers (cast.h), one after the other. slide: x and z of the shadow's; half a texel, of one layer, of
// shadow and of occlusion. layers: their number; that less 1, over their height.
uniform sampler2D sandglass_pile, sandglass_shadow, sandglass_occlusion, sandglass_sky;
#ifndef SANDGLASS_VECTORS_DECLARED  // by the engine, in a block
uniform vec4 sandglass_pile_box, sandglass_shadow_box, sandglass_occlusion_box, sandglass_numbers, sandglass_slide, sandglass_layers;
#endif
float sandglass_at(sampler2D image, vec2 at, float outside) {
  return all(greaterThan(at, vec2(0))) && all(lessThan(at, vec2(1))) ? texture(image, at).r : outside;
}
// The rule of the slide, of a place so many metres above the plane, that has slid to it.
float sandglass_between(sampler2D image, vec2 at, float half_texel, float above, float outside) {
  float number = max(sandglass_layers.x, 1.0), layer = clamp(above * sandglass_layers.y, 0.0, number - 1.0), lower = floor(layer);
  float row = clamp(at.y, half_texel, 1.0 - half_texel);  // no other layer's texels
  float low = texture(image, vec2(at.x, (lower + row) / number)).r;
  float high = texture(image, vec2(at.x, (min(lower + 1.0, number - 1.0) + row) / number)).r;
  return all(greaterThan(at, vec2(0))) && all(lessThan(at, vec2(1))) ? mix(low, high, layer - lower) : outside;
}
vec2 sandglass_left(vec3 world) {
  float above = world.y - sandglass_numbers.w;
  vec2 lies = (world.xz - sandglass_pile_box.xy) * sandglass_pile_box.zw, around = (world.xz - sandglass_occlusion_box.xy) * sandglass_occlusion_box.zw;
  vec2 behind = (world.xz - sandglass_slide.xy * above - sandglass_shadow_box.xy) * sandglass_shadow_box.zw;
  float object = sandglass_between(sandglass_shadow, behind, sandglass_slide.z, above, 0.0), open = sandglass_between(sandglass_occlusion, around, sandglass_slide.w, above, 1.0);
  float direct = (1.0 - sandglass_numbers.x * sandglass_at(sandglass_pile, lies, 0.0)) * (1.0 - sandglass_numbers.y * object);
  return vec2(direct, open * (sandglass_numbers.z > 0.5 ? sandglass_at(sandglass_sky, lies, 1.0) : 1.0));
}
