// A fragment of the surface. Needs surface.glsl, and of the app float hidden(vec3 world): how much something real hides of
// what is drawn there.
in vec3 world, smooth_normal;
in vec2 dent_and_height;
flat in vec3 begins;
out vec4 pixel;
void main() {
  vec3 lit = sand_surface(world, smooth_normal, dent_and_height.x, dent_and_height.y, begins);
  pixel = vec4(encoded(lit).rgb, 1.0 - hidden(world));
}
