// How sand looks: its colour, and how it is lit. Needs light.glsl.
const float k_flat = 0.45;       // rough ground is flatter than Lambert: normals lean so far towards the light
const float k_own = 0.8;         // share of the light by which each grain's own facet differs from the ground's
const float k_refraction = 1.33; // of water

// A heap is darker than one of its grains, and redder, because light is scattered often in it. Water between grains
// throws part of what would leave back into the sand (Lekner and Dorf 1988).
vec3 sand_albedo(vec3 grain) {
  vec3 dry = 0.77 * pow(grain, vec3(1.28));
  const float in_at_all = 0.933, thrown_back = 1.0 - in_at_all / (k_refraction * k_refraction);
  return mix(dry, in_at_all * (1.0 - thrown_back) * dry / (1.0 - thrown_back * dry), wet);
}
// What the pile leaves of the main light on itself. There what flies over it counts as standing on it: a slope that faces
// the light cannot be far in such a shadow.
float sand_passed(vec3 place, vec3 up) { return mix(pile_passed(place), 1.0, 0.85 * smoothstep(-0.05, 0.2, dot(up, to_light))); }
// `up`: the ground's normal; `facet`: a grain's. Shares of the main light and of the room's that reach it.
vec3 sand_lit(vec3 albedo, vec3 up, vec3 facet, float direct, float open) {
  float ground = max(dot(normalize(up + k_flat * to_light), to_light), 0.0) * smoothstep(-0.12, 0.22, dot(up, to_light));
  float own = max(dot(facet, to_light), 0.0) - max(dot(up, to_light), 0.0);
  // A facet that looks down sees sand; the ground as a whole sees the floor.
  vec3 room = max(around(facet) - around_below(facet) + around_below(up), 0.0);
  return albedo * (sun * direct * (ground + k_own * own) + room * open / (1.0 - albedo * (1.0 - open)));
}
// What a film of water mirrors, of Schlick's share; highlights are as wide as wet grains are rough.
vec3 sand_gloss(vec3 up, vec3 to_eye, float direct, float open) {
  if (wet <= 0.0) return vec3(0);
  vec3 between = normalize(to_eye + to_light);
  float rim = 0.02 + 0.98 * pow(1.0 - max(dot(up, to_eye), 0.0), 5.0), lobe = 8.0 * pow(max(dot(up, between), 0.0), 60.0);
  return wet * rim * (around(reflect(-to_eye, up)) * open + sun * direct * lobe * max(dot(up, to_light), 0.0));
}
