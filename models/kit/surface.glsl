// The surface of the sand cuts the block of packed grains, which moves with the sand. For fragments; needs sand.glsl and
// levels.glsl or packed.glsl.
const float k_texels = 64.0;  // along a side of the block
const float k_sharper = 0.6;  // levels; more makes single pixels flicker
// The light that leaves it, linear. `dent` and `height` as in surface.vert.
vec3 sand_surface(vec3 world, vec3 smooth_normal, float dent, float height, vec3 begins) {
  // The level follows from the place in the world: the block's own jumps from patch to patch. What is looked at slantingly
  // stays crisp.
  vec3 at = world / block_side - begins, right = dFdx(world), upwards = dFdy(world);
  float side = mix(sqrt(length(cross(right, upwards))), max(length(right), length(upwards)), 0.35);
  float level = log2(max(side / block_side * k_texels, 0.5)) - k_sharper;
  vec4 grain = block_level(grains, at, level), face = block_level(facets, at, level);  // colour, depth in it; facet, its lot
  if (height < block_side * (0.143 * face.a - 0.024)) discard;             // the foot ends in single grains
  vec3 up = normalize(smooth_normal), bump = face.xyz * 2.0 - 1.0;
  float above = dot(bump, up);
  bump += (abs(above) - above) * up;  // of a grain that is cut below its middle the upper half is seen
  vec3 facet = normalize(up + 0.85 * (bump - 0.5 * up)), to_eye = normalize(eye - world);
  float deep = grain.a, gap = max(0.21 + 0.97 * deep, 0.1), sunny = max(1.0 + 2.45 * (deep - 0.657), 0.03);  // between grains it is dark
  float direct = pile_passed(world) * object_passed(world), open = under_sky(world) * (1.0 - 0.45 * clamp(dent, 0.0, 1.0));
  vec3 lit = sand_lit(sand_albedo(grain.rgb, block_mean(grains).rgb), up, facet, to_eye, direct * sunny, open * gap) + sand_gloss(normalize(mix(facet, up, 0.7)), to_eye, direct, open);
  // A few facets mirror the main light.
  vec3 mirror = normalize(up + 1.1 * (vec3(face.a, fract(face.a * 57.0), fract(face.a * 131.0)) * 2.0 - 1.0));
  float glint = smoothstep(0.993, 0.999, dot(mirror, normalize(to_eye + to_light))) * smoothstep(0.5, 0.9, deep) * (1.0 - smoothstep(0.6, 2.6, level));
  return lit + sun * direct * glint;
}
