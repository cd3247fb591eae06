// How sand looks: its colour, and how it is lit. Needs light.glsl.
const float k_own = 1.45;        // how much of what a grain's own facet gets differs from what the ground gets
const float k_refraction = 1.33; // of water

// A heap is darker than its grains, of which `mean` is the mean, and redder, because light is scattered often in it. Water
// between grains throws part of what would leave back into the sand (Lekner and Dorf 1988).
vec3 sand_albedo(vec3 grain, vec3 mean) {
  vec3 dry = 0.77 * grain * pow(mean, vec3(0.28));
  const float in_at_all = 0.933, thrown_back = 1.0 - in_at_all / (k_refraction * k_refraction);
  return mix(dry, in_at_all * (1.0 - thrown_back) * dry / (1.0 - thrown_back * dry), wet);
}
// What packed grains send to the eye of the main light, for an albedo of 1: much more where it comes from behind the eye,
// where no shadow of a grain is seen, and little where it comes towards it. Lommel and Seeliger's law with a phase that was
// fitted to path traced balls (RMS 5 % over 120 directions; of Lambert's law 36 %).
float sand_ground(vec3 up, vec3 to_eye) {
  float over = dot(up, to_light), in_at = 0.5 * (over + sqrt(over * over + 0.007)), out_at = max(dot(up, to_eye), 0.0), behind = dot(to_light, to_eye), lit = max(behind, 0.0);
  return in_at / (in_at + out_at + 0.35) * (1.06 + 0.83 * behind + 0.46 * lit * lit * lit * lit);
}
// `up`: the ground's normal; `facet`: a grain's. Shares of the main light and of the room's that reach it.
vec3 sand_lit(vec3 albedo, vec3 up, vec3 facet, vec3 to_eye, float direct, float open) {
  float level = dot(up, to_light), own = dot(facet, to_light) - dot(facet, up) * level, slant = 1.0 - max(dot(up, to_eye), 0.0);
  float ground = sand_ground(up, to_eye) * max(1.0 + k_own * own / (max(level, 0.0) + 0.1), 0.0);
  // A facet that looks down sees sand; the ground as a whole sees the floor. At a slant the light upper sides hide the gaps.
  vec3 room = max(around(facet) - around_below(facet) + around_below(up), 0.0) * (1.0 + 0.4 * slant * slant);
  return albedo * (sun * direct * ground + room * open / (1.0 - albedo * (1.0 - open)));
}
// What a film of water mirrors, of Schlick's share; highlights are as wide as wet grains are rough.
vec3 sand_gloss(vec3 up, vec3 to_eye, float direct, float open) {
  vec3 between = normalize(to_eye + to_light);
  float rim = 0.02 + 0.98 * pow(1.0 - max(dot(up, to_eye), 0.0), 5.0), lobe = 8.0 * pow(max(dot(up, between), 0.0), 60.0);
  vec3 mirrored = around(reflect(-to_eye, up)) * open + sun * direct * lobe * max(dot(up, to_light), 0.0);
  return wet > 0.0 ? wet * rim * mirrored : vec3(0);
}
// How light a loose grain is at a place of its square, which is a ball where that is seen; 0 beside it. `across`: of the ball,
// pixels; 0 of what flies.
float grain_lit(vec2 at, float across) {
  float square = dot(at, at), lit = 1.05 - 0.3 * square * smoothstep(-0.6, 0.8, -at.y);
  return across < 2.5 ? 1.0 : square > 1.0 ? 0.0 : pow(lit, 2.3);
}
