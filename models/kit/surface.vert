// A vertex of sandglass_skin_mesh. Attributes as in sandglass_skin_vertex: normal, hollow, origin and over normalised.
layout(location = 0) in vec3 position;
layout(location = 1) in vec3 normal;
layout(location = 2) in float hollow;
layout(location = 3) in vec3 origin;
layout(location = 4) in float over;
out vec3 world, smooth_normal;
out vec2 dent_and_height;  // how hollow it is, -1 to 1; metres over what the sand lies on
flat out vec3 begins;      // where the block of grains does, in sides of it
void main() {
  world = position, smooth_normal = normal;
  dent_and_height = vec2(hollow * (255.0 / 127.0) - 128.0 / 127.0, over * 0.032767);
  begins = origin * (65535.0 / 65536.0);
  gl_Position = projection * (view * vec4(position, 1));
}
