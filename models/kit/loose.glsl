// Loose sand (sandglass_skin_loose, one instance each): squares of what lies, lines of what flies, as far as it comes while
// a picture is exposed. A particle becomes as many grains as are seen from there, at places that follow from its number.
// A grain is a square of four vertices: draw indices 0, 1, 2, 2, 1, 3 and so on, of k_points squares an instance where
// `flies` is 0, of k_lines where it is 1; of fewer when all are far. Needs sand.glsl.
const uint k_clouds = 16u;       // of a particle: it flies apart into so many
const float k_points = 256.0, k_lines = 384.0;
const float k_point_pixels = 1.5, k_line_pixels = 1.2;  // no grain is drawn thinner
const float k_exposure = 0.0025; // seconds
const float k_beside = 2.4;      // nozzle radii that a stream bursts out to
uint hashed(uint v) {
  uint first = (v ^ (v >> 16u)) * 0x7feb352du, second = (first ^ (first >> 15u)) * 0x846ca68bu;
  return second ^ (second >> 16u);
}
float drawn(inout uint state) {
  state = hashed(state + 0x9e3779b9u);
  return float(state >> 8u) / 16777216.0;
}
vec3 ball(inout uint state) {
  float h = 2.0 * drawn(state) - 1.0, turn = 6.2831853 * drawn(state), r = pow(drawn(state), 1.0 / 3.0), a = sqrt(1.0 - h * h);
  return r * vec3(a * cos(turn), h, a * sin(turn));
}
// Of a grain: where its corner is drawn, and lies in the square, from -1 to 1 (of a line x along it); how wide its ball is, pixels,
// or 0; its middle; the normal of what it lies on; how much of it is its own, not the mean of many; and what chance has for it.
vec4 grain_position;
vec2 grain_at;
float grain_across, grain_own;
vec3 grain_stands, grain_up;
uint grain_seed;
// For vertices.
void loose_grain(uint vertex, vec4 place, vec3 way, uint number) {
  grain_position = vec4(2, 2, 2, 1), grain_at = vec2(0), grain_across = grain_own = 0.0;
  grain_stands = grain_up = vec3(0), grain_seed = 0u;
  bool line = flies > 0.5;
  uint which = vertex >> 2u, cloud = hashed(number * k_clouds + (which & (k_clouds - 1u))), state = hashed(cloud + which);
  float finest = block_side / 28.0, most = line ? k_lines : k_points, least = line ? k_line_pixels : k_point_pixels;  // a grain's radius
  vec4 middle = projection * (view * vec4(place.xyz, 1));
  float away = max(middle.w, 0.0001), thick = 2.0 * finest * pixels / away;
  float n = clamp(most * thick * thick / (least * least), 1.0, most), there = clamp(n * place.w - float(which), 0.0, 1.0);
  if (away < 0.02) there = 0.0;
  if (there > 0.0) {
    float stands = most / n, size = finest * sqrt(stands * there) * mix(0.7, 1.25, drawn(state)), speed = length(way), poured = 0.0;
    vec3 off = ball(cloud) * 1.19 * particle_radius, spread = ball(state) * 0.5 * particle_radius, up = vec3(0, 1, 0), world = place.xyz + off + spread;
    if (line) {
      // A stream bursts out of its nozzle sideways, in pulses; it is drawn as narrow as sand falls, and even.
      float pulse = 0.01;
      vec4 nozzle = vec4(0), flows = vec4(0, 0, 0, 1);
      for (int s = 0; s < 3; ++s) {
        vec3 along = stream_ways[s].xyz, reached = place.xyz - streams[s].xyz, beside = reached - dot(reached, along) * along;
        float inside = streams[s].w > 0.0 ? (1.0 - smoothstep(k_beside, k_beside + 0.4, length(beside) / streams[s].w)) *
          smoothstep(0.5, 0.9, dot(way, along) / max(speed, 0.01)) * step(0.0, dot(reached, along)) : 0.0;
        if (inside > poured) {
          poured = inside, nozzle = streams[s], flows = stream_ways[s];
        }
      }
      if (poured > 0.0) {
        vec3 reached = world - nozzle.xyz, beside = reached - dot(reached, flows.xyz) * flows.xyz;
        pulse = 1.65 * particle_radius / flows.w, up = beside - 0.15 * nozzle.w * flows.xyz;
        world -= beside * (1.0 - mix(1.0, stream_narrow * sqrt(clamp(flows.w / max(speed, 0.1), 0.0, 1.0)), poured));
        there *= mix(1.0, smoothstep(1.02, 1.25, speed / flows.w), poured);  // no lid on its upper end
      }
      world += way * ((drawn(state) - 0.5) * frame_seconds + (drawn(state) - 0.5) * pulse);
      up = normalize(up);
    } else {
      up = normalize(way + vec3(0, 0.0001, 0));
      off += spread * (1.0 - 2.0 * log(max(drawn(state), 0.02)));
      world = place.xyz + off - (0.85 * dot(off, up) + 0.85 * particle_radius - 0.8 * size) * up;
    }
    if (there > 0.0) {
      float wide = 2.0 * size * pixels / away;
      grain_across = line ? 0.0 : wide, grain_stands = world, middle = projection * (view * vec4(world, 1));
      vec2 pixel = vec2(projection[0][0], projection[1][1]) / pixels;                      // of the picture's half sides
      vec2 right = vec2(0.5 * max(wide, 1.0), 0), over = vec2(0, right.x);  // half the square's sides, pixels
      if (line) {
        vec4 end = projection * (view * vec4(world + way * (0.5 * k_exposure * mix(0.2, 1.0, poured)), 1));
        right = (end.xy / end.w - middle.xy / middle.w) / pixel;
        over = vec2(-right.y, right.x) * (0.5 / max(length(right), 0.0001));
      }
      grain_at = vec2(float(vertex & 1u), float((vertex >> 1u) & 1u)) * 2.0 - 1.0;
      grain_position = middle + vec4((grain_at.x * right + grain_at.y * over) * pixel * middle.w, 0, 0);
      grain_own = clamp(wide / least, 0.0, 1.0) * inversesqrt(stands) * (line ? 0.3 : 1.0), grain_up = up, grain_seed = state;
    }
  }
}
// For fragments: the light that leaves it, linear.
vec3 grain_shown(vec2 at, float across, vec3 stands, vec3 up, float own, uint seed) {
  uint state = seed;
  float kind = drawn(state), light = drawn(state);
  vec4 mineral = minerals[3];
  vec3 mean = minerals[0].rgb * minerals[0].a;
  for (int m = 2; m >= 0; --m) {
    mean += minerals[m + 1].rgb * (minerals[m + 1].a - minerals[m].a);
    if (kind < minerals[m].a) mineral = minerals[m];
  }
  vec3 facet = normalize(up + 0.7 * own * ball(state)), albedo = sand_albedo(mix(mean, mineral.rgb * (0.8 + 0.4 * light), own), mean);
  float shaded = mix(0.8, 0.55 + 0.5 * drawn(state), own);
  // What flies is lit before it shades the pile.
  float direct = (flies > 0.5 ? 1.0 : pile_passed(stands)) * object_passed(stands) * shaded;
  return grain_lit(at, across) * sand_lit(albedo, up, facet, normalize(eye - stands), direct, 0.9 * under_sky(stands));
}
