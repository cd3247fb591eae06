// Light on what is drawn, from what the library tells of the room, and the library's shadows in it.
vec3 around(vec3 normal) {
  vec3 n = normal * table_of_room;
  return max(ambient[0] + ambient[1] * n.y + ambient[2] * n.z + ambient[3] * n.x + ambient[4] * n.x * n.y + ambient[5] * n.y * n.z +
    ambient[6] * (3.0 * n.z * n.z - 1.0) + ambient[7] * n.x * n.z + ambient[8] * (n.x * n.x - n.y * n.y), 0.0);
}
// The part of it that comes from the floor.
vec3 around_below(vec3 normal) { return below * (0.5 - 0.5 * (normal * table_of_room).y); }
vec3 shade(vec3 albedo, vec3 normal, float direct, float open) {
  return albedo * (sun * max(dot(normal, to_light), 0.0) * direct + around(normal) * open);
}
float passed(sampler2D image, vec2 at, float opacity) {
  bool on = all(greaterThan(at, vec2(0))) && all(lessThan(at, vec2(1)));
  return on ? 1.0 - texture(image, at).r * opacity : 1.0;
}
// What objects and sand leave of the room's light.
float opened(vec3 place) {
  vec2 at = ((on_plane * vec4(place, 1)).xz - occlusion_box.xy) * occlusion_box.zw;
  bool on = all(greaterThan(at, vec2(0))) && all(lessThan(at, vec2(1)));
  return on ? texture(occlusion, at).r : 1.0;
}
float under_sky(vec3 place) {
  vec2 at = (place.xz - pile_box.xy) * pile_box.zw;
  bool on = sky_known > 0.5 && all(greaterThan(at, vec2(0))) && all(lessThan(at, vec2(1)));
  return on ? texture(sky, at).r : 1.0;
}
// What they leave of the main light. Its ray through the place goes on to the plane, where the objects' shadows were made,
// between the two layers about its height.
float object_passed(vec3 place) {
  vec3 p = (on_plane * vec4(place, 1)).xyz, l = mat3(on_plane) * to_light;
  vec2 at = (p.xz - l.xz * (p.y / max(l.y, 0.05)) - shadow_box.xy) * shadow_box.zw;
  float number = max(shadow_layers.x, 1.0), layer = clamp(p.y * shadow_layers.y, 0.0, number - 1.0), lower = floor(layer);
  float row = clamp(at.y, shadow_layers.z, 1.0 - shadow_layers.z), hidden = texture(shadow, vec2(at.x, (lower + row) / number)).r;
  if (layer > lower) hidden = mix(hidden, texture(shadow, vec2(at.x, (lower + 1.0 + row) / number)).r, layer - lower);
  bool on = all(greaterThan(at, vec2(0))) && all(lessThan(at, vec2(1)));
  return on ? 1.0 - hidden * shadow_opacity : 1.0;
}
float pile_passed(vec3 place) { return passed(pile, (place.xz - pile_box.xy) * pile_box.zw, pile_opacity); }
// What is written, sRGB.
vec4 encoded(vec3 linear) {
  vec3 within = clamp(linear, 0.0, 1.0);
  return vec4(mix(12.92 * within, 1.055 * pow(within, vec3(1.0 / 2.4)) - 0.055, step(0.0031308, within)), 1);
}
