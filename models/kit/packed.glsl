// As levels.glsl, where a texture of three dimensions has no levels of its own: all lie in one, each with a border of a texel, the
// finest first and the others above it side by side (packed_block.mjs).
vec4 packed_level(sampler3D image, vec3 at, float level) {
  float side = exp2(6.0 - level), along = level < 0.5 ? 0.0 : 62.0 + 2.0 * level - 2.0 * side;
  vec3 texel = fract(at) * side + vec3(1.0 + along, 1.0, level < 0.5 ? 1.0 : 67.0);
  return textureLod(image, texel / vec3(75, 66, 100), 0.0);
}
vec4 block_level(sampler3D image, vec3 at, float level) {
  float within = clamp(level, 0.0, 6.0), fine = floor(within);
  return mix(packed_level(image, at, fine), packed_level(image, at, min(fine + 1.0, 6.0)), within - fine);
}
vec4 block_mean(sampler3D image) { return packed_level(image, vec3(0), 6.0); }
