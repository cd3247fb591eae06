// Colours are linear until a shader's last line. Spheres are point sprites, and their fragments write the depth of the
// sphere. The same sprites, seen from the light, fill the shadow map. The map leaves out a solid with a baked shadow,
// and the sand when it has a shadow of its own. These shadows come from textures, on the floor and on the sand.
#include "models/view/painter.h"

#include <epoxy/gl.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <map>
#include <numbers>
#include <string>

#include "models/files/failure.h"
#include "models/view/surface.h"

namespace sandglass::host {

namespace {

constexpr int k_map_size = 1024;                  // texels a side of the shadow map
constexpr int k_shadows_at_most = 4;              // textures of baked shadows on the floor
constexpr double k_same_floor = 1e-3;             // metres
constexpr int k_floor_unit = 5, k_sand_unit = 6;  // texture units that hold the sand's shadow
constexpr double k_floor_reach = 40.0;            // box diagonals

using Matrix = std::array<float, 16>;  // column by column, as OpenGL wants it

Matrix product(const Matrix& a, const Matrix& b) {
  Matrix c = {};
  for (size_t column = 0; column < 4; ++column)
    for (size_t row = 0; row < 4; ++row)
      for (size_t k = 0; k < 4; ++k) c[4 * column + row] += a[4 * k + row] * b[4 * column + k];
  return c;
}

// The map of a point p to (rows . p) + offset.
Matrix of_rows(const Vec3 (&rows)[3], Vec3 offset) {
  const double add[3] = {offset.x, offset.y, offset.z};
  Matrix m = {};
  for (size_t row = 0; row < 3; ++row) {
    m[row] = static_cast<float>(rows[row].x), m[4 + row] = static_cast<float>(rows[row].y);
    m[8 + row] = static_cast<float>(rows[row].z), m[12 + row] = static_cast<float>(add[row]);
  }
  m[15] = 1.0f;
  return m;
}

Matrix looking(Vec3 eye, Vec3 target) {
  const Vec3 forward = normalised(target - eye);
  const Vec3 aside = std::fabs(forward.y) > 0.999 ? Vec3{1, 0, 0} : Vec3{0, 1, 0};
  const Vec3 right = normalised(cross(forward, aside)), up = cross(right, forward);
  return of_rows({right, up, forward * -1.0}, {-dot(right, eye), -dot(up, eye), dot(forward, eye)});
}

Matrix perspective(double fov_deg, double aspect, double near, double far) {
  const double focal = 1.0 / std::tan(fov_deg * std::numbers::pi / 360.0);
  Matrix m = {};
  m[0] = static_cast<float>(focal / aspect), m[5] = static_cast<float>(focal);
  m[10] = static_cast<float>((far + near) / (near - far)), m[11] = -1.0f;
  m[14] = static_cast<float>(2.0 * far * near / (near - far));
  return m;
}

Matrix orthographic(double half_width, double near, double far) {
  Matrix m = {};
  m[0] = m[5] = static_cast<float>(1.0 / half_width);
  m[10] = static_cast<float>(2.0 / (near - far)), m[14] = static_cast<float>((far + near) / (near - far));
  m[15] = 1.0f;
  return m;
}

Matrix pose(const sandglass_collider& c) {
  const Quaternion q = normalised(Quaternion{c.rotation[0], c.rotation[1], c.rotation[2], c.rotation[3]});
  const Quaternion back = conjugate(q);
  return of_rows({rotate(back, {1, 0, 0}), rotate(back, {0, 1, 0}), rotate(back, {0, 0, 1})}, from_floats(c.position));
}

// Its rows give x over the texture's rectangle, the height above its floor, and z over the rectangle.
Matrix to_square(const FloorShadow& shadow) {
  const double wide = 1.0 / (shadow.high[0] - shadow.low[0]), deep = 1.0 / (shadow.high[1] - shadow.low[1]);
  const Quaternion q = shadow.rotation;
  const Vec3 x = rotate(q, {wide, 0, 0}), y = rotate(q, {0, 1, 0}), z = rotate(q, {0, 0, deep}), at = shadow.position;
  return of_rows({x, y, z}, {-dot(x, at) - shadow.low[0] * wide, -dot(y, at), -dot(z, at) - shadow.low[1] * deep});
}

// What all shaders share that compute light.
constexpr const char* k_lighting = R"(
uniform vec3 to_light;
uniform mat4 light_clip;
uniform sampler2DShadow map;
const vec3 sun = vec3(0.98, 0.92, 0.80), sky = vec3(0.38, 0.43, 0.52), ground = vec3(0.20, 0.18, 0.16);
float lit(vec3 at) {  // 4 x 4 filtered comparisons of the shadow map
  vec3 p = (light_clip * vec4(at, 1)).xyz * 0.5 + 0.5;
  if (any(lessThan(p, vec3(0))) || any(greaterThan(p, vec3(1)))) return 1.0;
  float sum = 0.0;
  for (int i = 0; i < 16; ++i)
    sum += texture(map, vec3(p.xy + (vec2(i % 4, i / 4) - 1.5) * 1.2 / textureSize(map, 0).x, p.z));
  return sum / 16.0;
}
vec3 shade(vec3 albedo, vec3 normal, float direct) {
  return albedo * (sun * max(dot(normal, to_light), 0.0) * direct + mix(ground, sky, 0.5 + 0.5 * normal.y) * 0.8);
}
vec4 encoded(vec3 linear) {
  linear = clamp(linear, 0.0, 1.0);
  return vec4(mix(12.92 * linear, 1.055 * pow(linear, vec3(1.0 / 2.4)) - 0.055, step(0.0031308, linear)), 1);
}
)";

// What the shaders of floor and sand share: the library's shadows fall on both. A shader has it behind k_lighting.
constexpr const char* k_shadows = R"(
uniform int shadow_count;
uniform mat4 to_texture[4];  // world to the texture's square in x and z; y: metres above its floor
uniform float opacity[4];
uniform sampler2D coverage[4];
uniform bool has_pile;
uniform mat4 to_pile;
uniform float pile_opacity;
uniform sampler2D pile_coverage;  // on the floor, or on the sand
uniform float highest;  // a texture is drawn on what lies less than this from its floor, metres
float passed(vec3 at, sampler2D image, float opacity) {
  bool on = all(greaterThan(at.xz, vec2(0))) && all(lessThan(at.xz, vec2(1)));
  return on ? 1.0 - texture(image, at.xz).r * opacity : 1.0;
}
// The ray from the light through the place goes on to the texture's floor. The shadow at that point is that of the
// place.
float shadowed_by(mat4 frame, sampler2D image, float opacity, vec3 place) {
  vec3 at = (frame * vec4(place, 1)).xyz, along = (frame * vec4(to_light, 0)).xyz;
  return abs(at.y) < highest ? passed(at - along * (at.y / max(along.y, 0.05)), image, opacity) : 1.0;
}
float shadowed(vec3 place) {
  float share = 1.0;
  if (shadow_count > 0) share *= shadowed_by(to_texture[0], coverage[0], opacity[0], place);
  if (shadow_count > 1) share *= shadowed_by(to_texture[1], coverage[1], opacity[1], place);
  if (shadow_count > 2) share *= shadowed_by(to_texture[2], coverage[2], opacity[2], place);
  if (shadow_count > 3) share *= shadowed_by(to_texture[3], coverage[3], opacity[3], place);
  vec3 at = (to_pile * vec4(place, 1)).xyz;
  if (has_pile && abs(at.y) < highest) share *= passed(at, pile_coverage, pile_opacity);
  return share;
}
)";

constexpr const char* k_sphere_vertex = R"(
layout(location = 0) in vec3 position;
uniform mat4 view, projection;
uniform float radius, pixels;  // of a unit at distance 1, or in all of an orthographic view
uniform bool grains;
flat out vec3 centre, colour;
flat out vec4 faces[7];  // where to, and the cosine of its rim
flat out float size;
// A grain's colour, size and faces are those of models/drawing/render.cpp, by the same hash: so it looks in films, too.
uint hashed(uint v) {
  v = (v ^ (v >> 16u)) * 0x7feb352du;
  v = (v ^ (v >> 15u)) * 0x846ca68bu;
  return v ^ (v >> 16u);
}
float drawn(inout uint state) {
  state = hashed(state + 0x9e3779b9u);
  return float(state >> 8u) / 16777216.0;
}
void main() {
  vec4 at = view * vec4(position, 1);
  centre = at.xyz;
  uint number = uint(gl_VertexID) * 2u + 1u, sized = number + 0x51ed270bu, broken_off = number + 0x2545f491u;
  size = grains ? radius * mix(0.75, 1.2, drawn(sized)) : radius;
  for (int k = 0; k < 7; ++k) {
    float height = 2.0 * drawn(broken_off) - 1.0, turn = 6.2831853 * drawn(broken_off), across = sqrt(1.0 - height * height);
    faces[k] = vec4(across * cos(turn), height, across * sin(turn), 0.75 + 0.2 * drawn(broken_off));
  }
  gl_Position = projection * at;
  gl_PointSize = max(2.0 * size * pixels / gl_Position.w, 1.0);
  float shade = 2.0 * drawn(number) - 1.0, warm = 2.0 * drawn(number) - 1.0;
  colour = vec3(0.56, 0.36, 0.17) * (1.0 + 0.28 * shade) * vec3(1.0 + 0.1 * warm, 1.0, 1.0 - 0.1 * warm);
}
)";

constexpr const char* k_sphere_fragment = R"(
flat in vec3 centre, colour;
flat in vec4 faces[7];
flat in float size;
uniform mat4 view, projection;
uniform bool grains;
out vec4 pixel;
// The face that is broken off the grain there, if one is; its rim is round.
vec3 broken(vec3 n) {
  vec3 face = n;
  float nearest = 0.0;
  for (int k = 0; k < 7; ++k) {
    float above = dot(n, faces[k].xyz) - faces[k].w;
    if (above > nearest) nearest = above, face = faces[k].xyz;
  }
  return normalize(mix(n, face, 0.7));
}
void main() {
  vec2 at = gl_PointCoord * vec2(2, -2) + vec2(-1, 1);
  float gap = 1.0 - dot(at, at);
  if (gap < 0.0) discard;
  vec3 normal = vec3(at, sqrt(gap)), place = centre + size * normal;
  vec4 clip = projection * vec4(place, 1);
  gl_FragDepth = 0.5 + 0.5 * clip.z / clip.w;
  mat3 back = transpose(mat3(view));
  vec3 world = back * (place - view[3].xyz), out_of = back * normal, n = grains ? broken(out_of) : out_of;
  pixel = encoded(shade(colour, n, lit(world + 1.5 * size * out_of) * shadowed(world)) * (0.75 + 0.25 * n.y));
}
)";

constexpr const char* k_sphere_depth_fragment = R"(
void main() {
  vec2 at = gl_PointCoord * 2.0 - 1.0;
  if (dot(at, at) > 1.0) discard;
}
)";

constexpr const char* k_solid_vertex = R"(
layout(location = 0) in vec3 position;
layout(location = 1) in vec3 direction;
uniform mat4 model, view, projection;
out vec3 world, normal;
void main() {
  world = (model * vec4(position, 1)).xyz;
  normal = mat3(model) * direction;
  gl_Position = projection * view * vec4(world, 1);
}
)";

constexpr const char* k_solid_fragment = R"(
in vec3 world, normal;
uniform float bias;
out vec4 pixel;
void main() {
  vec3 n = normalize(normal);
  pixel = encoded(shade(vec3(0.16, 0.30, 0.44), n, lit(world + bias * n)));
}
)";

constexpr const char* k_nothing_fragment = "void main() {}\n";

constexpr const char* k_floor_fragment = R"(
in vec3 world, normal;
uniform vec3 target;
uniform float reach, tile, bias;
out vec4 pixel;
void main() {
  float direct = lit(world + bias * normal) * shadowed(world);
  vec2 square = world.xz / tile, wide = max(fwidth(square), 1e-4);
  vec2 wave = clamp((abs(fract(square * 0.5) - 0.5) - 0.25) / wide * 2.0, -0.5, 0.5);  // edges as wide as a pixel
  float odd = 0.5 + 2.0 * wave.x * wave.y * clamp(0.6 / max(wide.x, wide.y), 0.0, 1.0);
  vec3 colour = shade(mix(vec3(0.34, 0.36, 0.39), vec3(0.48, 0.49, 0.51), odd), normal, direct);
  float fade = smoothstep(0.25, 1.0, length(world - target) / reach);
  pixel = encoded(mix(colour, vec3(0.61, 0.66, 0.71), fade));
}
)";

constexpr const char* k_overlay_vertex = R"(
uniform vec4 box;  // left, top, right, bottom in clip space
out vec2 at;
void main() {
  at = vec2(gl_VertexID & 1, gl_VertexID >> 1);
  gl_Position = vec4(mix(box.xy, box.zw, at), 0, 1);
}
)";

constexpr const char* k_overlay_fragment = R"(
in vec2 at;
uniform sampler2D image;
out vec4 pixel;
void main() { pixel = vec4(texture(image, at).rgb, 0.88); }
)";

GLuint compiled(GLenum kind, const std::string& body) {
  const std::string source = "#version 330 core\n" + body;
  const char* text = source.c_str();
  const GLuint shader = glCreateShader(kind);
  glShaderSource(shader, 1, &text, nullptr);
  glCompileShader(shader);
  GLint good = 0;
  glGetShaderiv(shader, GL_COMPILE_STATUS, &good);
  if (good != 0) return shader;
  char log[1024] = {};
  glGetShaderInfoLog(shader, sizeof log - 1, nullptr, log);
  throw Failure("cannot draw: this OpenGL refuses a shader of the viewer (" +
                std::string(log, std::strcspn(log, "\n")) + "). Update its driver.");
}

struct Program {
  GLuint name = 0;
  Program(const std::string& vertex, const std::string& fragment) : name(glCreateProgram()) {
    for (const GLuint shader : {compiled(GL_VERTEX_SHADER, vertex), compiled(GL_FRAGMENT_SHADER, fragment)}) {
      glAttachShader(name, shader);
      glDeleteShader(shader);
    }
    glLinkProgram(name);
    GLint good = 0;
    glGetProgramiv(name, GL_LINK_STATUS, &good);
    if (good == 0) throw Failure("cannot draw: this OpenGL cannot link the viewer's shaders. Update its driver.");
  }
  GLint at(const char* uniform) const { return glGetUniformLocation(name, uniform); }
  void set(const char* uniform, const Matrix& m) const { glUniformMatrix4fv(at(uniform), 1, GL_FALSE, m.data()); }
  void set(const char* uniform, Vec3 v) const {
    glUniform3f(at(uniform), static_cast<float>(v.x), static_cast<float>(v.y), static_cast<float>(v.z));
  }
  void set(const char* uniform, double v) const { glUniform1f(at(uniform), static_cast<float>(v)); }
  void set(const char* uniform, int v) const { glUniform1i(at(uniform), v); }
};

// Vertices on the graphics card: an array with one or two attributes of three floats.
struct Mesh3 {
  GLuint array = 0, vertices = 0;
  GLsizei count = 0;  // floats
  Mesh3() {
    glGenVertexArrays(1, &array);
    glGenBuffers(1, &vertices);
  }
  void layout(int floats, bool normals) const {
    glBindVertexArray(array);
    glBindBuffer(GL_ARRAY_BUFFER, vertices);
    const GLsizei stride = floats * static_cast<GLsizei>(sizeof(float));
    glEnableVertexAttribArray(0);
    glVertexAttribPointer(0, 3, GL_FLOAT, GL_FALSE, stride, nullptr);
    if (!normals) return;
    glEnableVertexAttribArray(1);
    glVertexAttribPointer(1, 3, GL_FLOAT, GL_FALSE, stride, reinterpret_cast<const void*>(3 * sizeof(float)));
  }
  void fill(std::span<const float> values) {
    glBindBuffer(GL_ARRAY_BUFFER, vertices);
    glBufferData(GL_ARRAY_BUFFER, static_cast<GLsizeiptr>(values.size_bytes()), values.data(), GL_STREAM_DRAW);
    count = static_cast<GLsizei>(values.size());
  }
  // Draws triangles of vertices with normals.
  void draw() const {
    glBindVertexArray(array);
    glDrawArrays(GL_TRIANGLES, 0, count / 6);
  }
};

GLuint new_texture(GLint filter) {
  GLuint name = 0;
  glGenTextures(1, &name);
  glBindTexture(GL_TEXTURE_2D, name);
  for (const GLenum which : {GL_TEXTURE_MIN_FILTER, GL_TEXTURE_MAG_FILTER})
    glTexParameteri(GL_TEXTURE_2D, which, filter);
  for (const GLenum which : {GL_TEXTURE_WRAP_S, GL_TEXTURE_WRAP_T})
    glTexParameteri(GL_TEXTURE_2D, which, GL_CLAMP_TO_EDGE);
  return name;
}

void require_version() {
  if (epoxy_gl_version() < 33)
    throw Failure("cannot draw: this display has OpenGL " + std::to_string(epoxy_gl_version() / 10) + "." +
                  std::to_string(epoxy_gl_version() % 10) +
                  ", and the viewer needs 3.3. Set LIBGL_ALWAYS_SOFTWARE=1 to draw on the CPU.");
}

}  // namespace

struct Painter::State {
  Program sphere, sphere_depth, solid, solid_depth, floor, overlay;
  Mesh3 spheres, floor_square, nothing;
  GLuint map = 0, map_target = 0, image = 0, pile_on_floor = 0, pile_on_sand = 0;
  std::array<GLuint, k_shadows_at_most> coverage = {};
  // The meshes that were made before, by the collider's shape, size and field. Meshes of fields are costly.
  std::map<std::array<double, 5>, Mesh3> meshes;

  State()
      : sphere(k_sphere_vertex, std::string(k_lighting) + k_shadows + k_sphere_fragment),
        sphere_depth(k_sphere_vertex, k_sphere_depth_fragment),
        solid(k_solid_vertex, std::string(k_lighting) + k_solid_fragment),
        solid_depth(k_solid_vertex, k_nothing_fragment),
        floor(k_solid_vertex, std::string(k_lighting) + k_shadows + k_floor_fragment),
        overlay(k_overlay_vertex, k_overlay_fragment) {
    floor_square.layout(6, true);
    map = new_texture(GL_LINEAR);
    glTexImage2D(GL_TEXTURE_2D, 0, GL_DEPTH_COMPONENT24, k_map_size, k_map_size, 0, GL_DEPTH_COMPONENT, GL_FLOAT,
                 nullptr);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_COMPARE_MODE, GL_COMPARE_REF_TO_TEXTURE);
    glGenFramebuffers(1, &map_target);
    glBindFramebuffer(GL_FRAMEBUFFER, map_target);
    glFramebufferTexture2D(GL_FRAMEBUFFER, GL_DEPTH_ATTACHMENT, GL_TEXTURE_2D, map, 0);
    glDrawBuffer(GL_NONE);
    glReadBuffer(GL_NONE);
    glBindFramebuffer(GL_FRAMEBUFFER, 0);
    for (GLuint& texture : coverage) texture = new_texture(GL_LINEAR);
    pile_on_floor = new_texture(GL_LINEAR), pile_on_sand = new_texture(GL_LINEAR);
    image = new_texture(GL_NEAREST);
    glEnable(GL_PROGRAM_POINT_SIZE);
    glEnable(GL_DEPTH_TEST);
    glEnable(GL_CULL_FACE);
    glPixelStorei(GL_UNPACK_ALIGNMENT, 1);
    glPixelStorei(GL_PACK_ALIGNMENT, 1);
  }

  const Mesh3& mesh_of(const sandglass_collider& c, const CollisionFields* fields) {
    const std::array<double, 5> key = {static_cast<double>(c.shape), static_cast<double>(c.size[0]),
                                       static_cast<double>(c.size[1]), static_cast<double>(c.size[2]),
                                       static_cast<double>(reinterpret_cast<uintptr_t>(c.field))};
    const auto found = meshes.find(key);
    if (found != meshes.end()) return found->second;
    Mesh3& mesh = meshes[key];
    mesh.layout(6, true);
    mesh.fill(flat_triangles(collider_mesh(c, fields != nullptr ? fields->mesh_of(c.field) : nullptr)));
    return mesh;
  }

  void draw_solids(const Painted& scene, const Program& program, bool cast) {
    for (size_t i = 0; i < scene.colliders.size(); ++i) {
      const sandglass_collider& c = scene.colliders[i];
      if (c.shape == SANDGLASS_SHAPE_HALF_SPACE) continue;
      const bool baked = std::any_of(scene.shadows.begin(), scene.shadows.end(),
                                     [&](const FloorShadow& shadow) { return shadow.collider == i; });
      float low[3], high[3];
      const bool glass = c.shape == SANDGLASS_SHAPE_FIELD && c.field != nullptr &&
                         sandglass_field_bounds(c.field, low, high) == SANDGLASS_SOLID_OUTSIDE;
      if (cast && (baked || glass)) continue;
      program.set("model", pose(c));
      mesh_of(c, scene.fields).draw();
    }
  }

  void draw_floors(const Painted& scene, double diagonal) {
    for (const sandglass_collider& c : scene.colliders) {
      if (c.shape != SANDGLASS_SHAPE_HALF_SPACE) continue;
      const float reach = static_cast<float>(k_floor_reach * diagonal);
      const Mesh square = {{-reach, 0, reach, reach, 0, reach, reach, 0, -reach, -reach, 0, -reach},
                           {0, 1, 2, 0, 2, 3}};
      floor_square.fill(flat_triangles(square));
      floor.set("model", pose(c));
      floor_square.draw();
    }
  }

  // Uploads the texture and binds it to the texture unit of this number.
  static void upload(const FloorShadow& shadow, GLuint texture, int unit) {
    glActiveTexture(GL_TEXTURE0 + static_cast<GLenum>(unit));
    glBindTexture(GL_TEXTURE_2D, texture);
    const GLsizei side = static_cast<GLsizei>(shadow.texels);
    glTexImage2D(GL_TEXTURE_2D, 0, GL_R8, side, side, 0, GL_RED, GL_UNSIGNED_BYTE, shadow.coverage.data());
    glActiveTexture(GL_TEXTURE0);
  }

  void upload_shadows(const Painted& scene) {
    for (int i = 0; i < shadow_count(scene); ++i)
      upload(scene.shadows[static_cast<size_t>(i)], coverage[static_cast<size_t>(i)], 1 + i);
    if (scene.pile == nullptr) return;
    upload(*scene.pile, pile_on_floor, k_floor_unit);
    upload(*scene.pile_on_sand, pile_on_sand, k_sand_unit);
  }

  static int shadow_count(const Painted& scene) {
    return std::min(k_shadows_at_most, static_cast<int>(scene.shadows.size()));
  }

  // Sets the shadows of the program in use. `unit` is the texture unit of the sand's shadow on this surface; `highest`
  // is in metres.
  static void use_shadows(const Painted& scene, const Program& program, int unit, double highest) {
    program.set("highest", highest);
    program.set("shadow_count", shadow_count(scene));
    for (int i = 0; i < k_shadows_at_most; ++i) {
      const std::string index = "[" + std::to_string(i) + "]";
      program.set(("coverage" + index).c_str(), 1 + i);
      if (i >= shadow_count(scene)) continue;
      const FloorShadow& shadow = scene.shadows[static_cast<size_t>(i)];
      program.set(("opacity" + index).c_str(), shadow.opacity);
      program.set(("to_texture" + index).c_str(), to_square(shadow));
    }
    program.set("has_pile", scene.pile != nullptr ? 1 : 0);
    program.set("pile_coverage", unit);
    if (scene.pile == nullptr) return;
    program.set("pile_opacity", scene.pile->opacity);
    program.set("to_pile", to_square(*scene.pile));
  }

  void lay_over(const Overlay& over, int width, int height) {
    const Picture& picture = *over.picture;
    glUseProgram(overlay.name);
    glBindTexture(GL_TEXTURE_2D, image);
    glTexImage2D(GL_TEXTURE_2D, 0, GL_RGB8, picture.width, picture.height, 0, GL_RGB, GL_UNSIGNED_BYTE,
                 picture.rgb.data());
    const auto x = [&](int pixel) { return static_cast<float>(2.0 * pixel / width - 1.0); };
    const auto y = [&](int pixel) { return static_cast<float>(1.0 - 2.0 * pixel / height); };
    glUniform4f(overlay.at("box"), x(over.x), y(over.y), x(over.x + picture.width), y(over.y + picture.height));
    overlay.set("image", 0);
    glBindVertexArray(nothing.array);
    glDrawArrays(GL_TRIANGLE_STRIP, 0, 4);
  }
};

Painter::Painter() {
  require_version();
  state_ = std::make_unique<State>();
}
Painter::~Painter() = default;  // the end of the context frees all its objects

void Painter::paint(const Painted& scene, int width, int height, std::span<const Overlay> overlays) {
  State& s = *state_;
  const double diagonal = std::max(length(scene.bounds.high - scene.bounds.low), 20.0 * scene.radius);
  const Vec3 middle = (scene.bounds.low + scene.bounds.high) * 0.5, sun = normalised(scene.to_light);
  const double reach = 1.2 * diagonal;
  const Matrix light_view = looking(middle + sun * (4.0 * diagonal), middle),
               light_projection = orthographic(reach, 1.0 * diagonal, 7.0 * diagonal),
               light_clip = product(light_projection, light_view);
  const GLsizei count = static_cast<GLsizei>(scene.spheres.size() / static_cast<size_t>(scene.sphere_floats));
  s.spheres.layout(scene.sphere_floats, false);
  s.spheres.fill(scene.spheres);

  glDisable(GL_BLEND);
  glBindFramebuffer(GL_FRAMEBUFFER, s.map_target);
  glViewport(0, 0, k_map_size, k_map_size);
  glClear(GL_DEPTH_BUFFER_BIT);
  glUseProgram(s.sphere_depth.name);
  s.sphere_depth.set("view", light_view);
  s.sphere_depth.set("projection", light_projection);
  s.sphere_depth.set("radius", scene.radius);
  s.sphere_depth.set("grains", scene.grains ? 1 : 0);
  s.sphere_depth.set("pixels", 0.5 * k_map_size / reach);
  glBindVertexArray(s.spheres.array);
  if (scene.pile == nullptr) glDrawArrays(GL_POINTS, 0, count);
  glUseProgram(s.solid_depth.name);
  s.solid_depth.set("view", light_view);
  s.solid_depth.set("projection", light_projection);
  s.draw_solids(scene, s.solid_depth, true);

  glBindFramebuffer(GL_FRAMEBUFFER, 0);
  glViewport(0, 0, width, height);
  glClearColor(0.80f, 0.83f, 0.86f, 1.0f);
  glClear(GL_COLOR_BUFFER_BIT | GL_DEPTH_BUFFER_BIT);
  const double distance = length(scene.camera.eye - scene.camera.target), aspect = static_cast<double>(width) / height;
  const Matrix view = looking(scene.camera.eye, scene.camera.target),
               projection = perspective(scene.camera.fov_deg, aspect, 0.02 * distance, distance + 60.0 * diagonal);
  const auto begin = [&](const Program& program) {
    glUseProgram(program.name);
    program.set("view", view);
    program.set("projection", projection);
    program.set("to_light", sun);
    program.set("light_clip", light_clip);
    program.set("map", 0);
    glActiveTexture(GL_TEXTURE0);
    glBindTexture(GL_TEXTURE_2D, s.map);
  };
  const double bias = std::max(1.5 * scene.radius, 3.0 * reach / k_map_size);
  begin(s.floor);
  s.floor.set("target", scene.camera.target);
  s.floor.set("reach", k_floor_reach * diagonal * 0.5);
  s.floor.set("tile", std::pow(10.0, std::floor(std::log10(diagonal))) * 0.5);
  s.floor.set("bias", 0.25 * bias);
  s.upload_shadows(scene);
  s.use_shadows(scene, s.floor, k_floor_unit, k_same_floor);
  s.draw_floors(scene, diagonal);
  begin(s.solid);
  s.solid.set("bias", bias);
  s.draw_solids(scene, s.solid, false);
  begin(s.sphere);
  s.use_shadows(scene, s.sphere, k_sand_unit, k_floor_reach * diagonal);
  s.sphere.set("radius", scene.radius);
  s.sphere.set("grains", scene.grains ? 1 : 0);
  s.sphere.set("pixels", 0.5 * height / std::tan(scene.camera.fov_deg * std::numbers::pi / 360.0));
  glBindVertexArray(s.spheres.array);
  glDrawArrays(GL_POINTS, 0, count);

  glDisable(GL_DEPTH_TEST);
  glDisable(GL_CULL_FACE);
  glEnable(GL_BLEND);
  glBlendFunc(GL_SRC_ALPHA, GL_ONE_MINUS_SRC_ALPHA);
  for (const Overlay& over : overlays) s.lay_over(over, width, height);
  glEnable(GL_CULL_FACE);
  glEnable(GL_DEPTH_TEST);
}

Picture Painter::read_back(int width, int height) const {
  Picture flipped(width, height, {0, 0, 0}), picture = flipped;
  glReadBuffer(GL_BACK);
  glReadPixels(0, 0, width, height, GL_RGB, GL_UNSIGNED_BYTE, flipped.rgb.data());
  const size_t row = static_cast<size_t>(width) * 3;
  for (int y = 0; y < height; ++y) std::memcpy(picture.at(0, y), flipped.at(0, height - 1 - y), row);
  return picture;
}

}  // namespace sandglass::host
