// Behind receive.glsl, for what is drawn already, the camera's picture, splats, any material: what shadows leave of its light, by which
// it is multiplied. It stands where a depth texture says; where that is silent, on heights over a plane (relief.h), or on the plane.
// What is real is taken to face up.
//
// A texel d is (x d + y) / (z d + w) metres along the camera's axis, by sandglass_metres, and silent at 0 and from known.x up. to_depth
// leads to its place in the texture from that in the picture, whose upper left corner is 0, 0; where the texture has a camera of its own
// (known.y 1), from a place in the world, as (u m, v m, 1, m) of its metres m, and from_depth back. to_heights: from the world
// to x and z in the texture of heights and, as y, metres above their plane; known.z: the highest of them. numbers: the share of the
// main light in a floor's, and the height up to which all shadow is drawn; none is at twice as much.
uniform sampler2D sandglass_depth, sandglass_heights;
#ifndef SANDGLASS_VECTORS_DECLARED
uniform mat4 sandglass_to_depth, sandglass_from_depth, sandglass_to_heights;
uniform vec4 sandglass_metres, sandglass_known, sandglass_depth_numbers;
#endif
// Metres along a ray until it meets the heights; 0 and less: it meets none, or leaves where the plane ends.
float sandglass_by_heights(vec3 eye, vec3 ray) {
  vec3 start = (sandglass_to_heights * vec4(eye, 1.0)).xyz, way = (sandglass_to_heights * vec4(ray, 0.0)).xyz;
  float down = min(way.y, -0.000001), last = start.y / -down;
  float first = clamp((sandglass_known.z - start.y) / down, 0.0, max(last, 0.0)), part = (last - first) / 24.0;
  float before = 0.0, met = -1.0;
  for (int i = 0; i < 25; ++i) {
    vec3 place = start + way * (first + part * float(i));
    float over = place.y - sandglass_at(sandglass_heights, place.xz, 0.0);
    if (met < 0.0 && over < 0.0) { met = first + part * (float(i) - clamp(over / min(over - before, -0.000001), 0.0, 1.0)); }
    before = over;
  }
  met = met < 0.0 ? last : met;
  vec3 end = start + way * met;
  return way.y < 0.0 && sandglass_at(sandglass_heights, end.xz, 0.0) > -1.0 ? met : 0.0;
}
// At a place of the picture, that is seen from `eye` along `ray`, which is a metre long along the view's axis.
float sandglass_left_by_depth(vec2 at, vec3 eye, vec3 ray) {
  float metres = ray.y < -0.0001 ? max((sandglass_numbers.w - eye.y) / ray.y, 0.1) : 2.0, known = 0.0;
  vec3 seen = eye;
  for (int i = 0; i < 3; ++i) {
    vec4 to = sandglass_to_depth * (sandglass_known.y > 0.5 ? vec4(eye + ray * metres, 1.0) : vec4(at, 0.0, 1.0));
    vec2 on = to.xy / to.w;
    float texel = texture(sandglass_depth, on).r;
    float deep = abs((sandglass_metres.x * texel + sandglass_metres.y) / (sandglass_metres.z * texel + sandglass_metres.w));
    bool is_on = all(greaterThan(on, vec2(0))) && all(lessThan(on, vec2(1))) && to.w > 0.0;
    known = is_on && deep > 0.0 && deep < sandglass_known.x ? 1.0 : 0.0;
    seen = sandglass_known.y > 0.5 ? (sandglass_from_depth * vec4(on * deep, 1.0, deep)).xyz : eye + ray * deep;
    metres = known > 0.5 ? dot(seen - eye, ray) / dot(ray, ray) : metres;
  }
  // What the other camera sees beside the ray, is not what is seen here.
  if (known < 0.5 || length(seen - eye - ray * metres) > 0.02 * metres) { metres = sandglass_by_heights(eye, ray); }
  vec3 place = eye + ray * metres;
  vec2 left = sandglass_left(place);
  float drawn = metres > 0.0 ? clamp(2.0 - abs(place.y - sandglass_numbers.w) / sandglass_depth_numbers.y, 0.0, 1.0) : 0.0;
  return mix(1.0, mix(left.y, left.x, sandglass_depth_numbers.x), drawn);
}
