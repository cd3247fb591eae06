// A loose grain: a point or a piece of a line. Needs `hidden`, as surface.frag does.
flat in vec3 colour, stands_at;
flat in float across;  // pixels
out vec4 pixel;
void main() {
  float lit = 1.0;
  if (flies < 0.5 && across >= 2.5) {
    vec2 at = gl_PointCoord * 2.0 - 1.0;
    if (dot(at, at) > 1.0) discard;
    lit = 1.05 - 0.3 * dot(at, at) * smoothstep(-0.6, 0.8, at.y);
  }
  pixel = vec4(colour * lit, 1.0 - hidden(stands_at));
}
