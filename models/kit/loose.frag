// A loose grain: a square or a piece of a line. Needs loose.glsl, and `hidden` as surface.frag does.
flat in vec3 stands_at, up;
flat in float across, own;
flat in uint chance;
in vec2 at;
out vec4 pixel;
void main() {
  if (grain_lit(at, across) <= 0.0) discard;
  pixel = vec4(encoded(grain_shown(at, across, stands_at, up, own, chance)).rgb, 1.0 - hidden(stands_at));
}
