// A loose grain: a square or a piece of a line. Needs sand.glsl, and `hidden` as surface.frag does.
flat in vec3 colour, stands_at;
flat in float across;
in vec2 at;
out vec4 pixel;
void main() {
  float lit = grain_lit(at, across);
  if (lit <= 0.0) discard;
  pixel = vec4(encoded(colour * lit).rgb, 1.0 - hidden(stands_at));
}
