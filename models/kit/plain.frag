// Without the kit: what an engine's own material does with the mesh, to be put together from its nodes. The engine lights the
// outputs: base colour and ambient occlusion, of what is rough (1) and no metal. Attributes as in sandglass_skin_vertex.
in vec3 position, normal;
in float hollow;         // 0 to 1
flat in vec3 origin;     // 0 to 1; not interpolated. Without it the texture stays where it is while sand moves
uniform sampler2D sand;  // sand.png or any other that repeats; sRGB, with mipmaps
uniform float side;      // of the texture, metres: block_side of the skin's description
layout(location = 0) out vec3 colour;
layout(location = 1) out float occlusion;
void main() {
  vec3 at = position / side - origin * (65535.0 / 65536.0);
  vec3 share = pow(normal * normal, vec3(4.0));  // of what is seen along x, y and z, as the surface faces it
  share /= share.x + share.y + share.z;
  colour = share.x * texture(sand, at.zy).rgb + share.y * texture(sand, at.xz).rgb + share.z * texture(sand, at.xy).rgb;
  occlusion = 1.0 - 0.45 * max(2.0 * hollow - 1.0, 0.0);
}
