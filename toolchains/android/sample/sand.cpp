// Sand over ARCore's camera image. Java hands over image, depth, poses and matrices (Sand.java says where each comes
// from); this file maps a vertex buffer, runs the library's frame into it, and draws the grains as points with OpenGL ES,
// and before them their shadows on the table, where nothing real stands in front (runtime/shadow/README.md).
#include <GLES3/gl3.h>
#include <jni.h>

#include <iterator>
#include <memory>

#include "performance.h"
#include "sand.h"

namespace {

// A grain: a round point with the shading of a sphere. Its radius is 0.35 of a particle's.
const char k_vertex_shader[] = R"glsl(#version 300 es
layout(location = 0) in vec4 older;  // position and speed
layout(location = 1) in vec4 newer;
uniform mat4 projection, view;
uniform vec3 origin;
uniform float pixels_at_one_metre;
uniform vec2 mixed;  // the share of the newer, and seconds between the two
void main() {
  // One that went further than its speeds explain is new, removed, or another of that number.
  float part = distance(older.xyz, newer.xyz) < mixed.y * (older.w + newer.w) + 0.01 ? mixed.x : 1.0;
  gl_Position = projection * view * vec4(mix(older.xyz, newer.xyz, part) + origin, 1.0);
  gl_PointSize = pixels_at_one_metre / gl_Position.w;
}
)glsl";
// The surface takes encoded values, and light adds up before it is encoded.
const char k_fragment_shader[] = R"glsl(#version 300 es
precision highp float;
uniform mat4 view;
uniform vec3 to_light, sun, ambient;
out vec4 colour;
void main() {
  vec2 p = vec2(2.0, -2.0) * gl_PointCoord + vec2(-1.0, 1.0);
  float r2 = dot(p, p);
  if (r2 > 1.0) discard;
  float facing = dot(vec3(p, sqrt(1.0 - r2)), mat3(view) * to_light);
  vec3 light = ambient + sun * max(facing, 0.0);
  colour = vec4(pow(vec3(0.53, 0.34, 0.13) * light, vec3(1.0 / 2.2)), 1.0);
}
)glsl";

// The table as the camera shows it: its image, darkened.
const char k_table_vertex_shader[] = R"glsl(#version 300 es
uniform mat4 projection, view;
uniform vec3 origin;
uniform float half_side;
out vec2 place;
void main() {
  place = half_side * vec2(2 * (gl_VertexID & 1) - 1, 2 * (gl_VertexID >> 1) - 1);
  gl_Position = projection * view * vec4(origin + vec3(place.x, 0.0, place.y), 1.0);
}
)glsl";
const char k_table_fragment_shader[] = R"glsl(#version 300 es
precision highp float;
precision highp usampler2D;
uniform sampler2D object, object_room, sand, sand_room;
uniform vec4 object_box, object_room_box, sand_box, sand_room_box;  // a corner, and one over the extents
uniform vec2 layers;                                                // of the object's two textures
uniform float s, sand_opacity;                                      // the main light's share
uniform usampler2D depth;                                           // millimetres along the camera's axis; 0: not known
uniform mat3 depth_from_screen;
uniform vec2 viewport, eye, slide;                                  // eye: x and z
uniform float eye_height, bias, height;                             // metres; how wrong depth may be; of the layers
in vec2 place;
out vec4 colour;
float at(sampler2D map, vec4 box, vec2 from, float above, float number, float outside) {  // sandglass/cast.h
  vec2 p = (from - box.xy) * box.zw;
  float layer = clamp(above / height, 0.0, 1.0) * (number - 1.0), lower = floor(layer);
  float half_texel = 0.5 / float(textureSize(map, 0).x), row = clamp(p.y, half_texel, 1.0 - half_texel);
  float low = texture(map, vec2(p.x, (lower + row) / number)).r;
  float high = texture(map, vec2(p.x, (min(lower + 1.0, number - 1.0) + row) / number)).r;
  return p == clamp(p, 0.0, 1.0) ? mix(low, high, layer - lower) : outside;
}
// Metres that what is real stands above the table; an eye below that sees nothing of what lies on it.
float stands() {
  ivec2 size = textureSize(depth, 0);
  vec2 p = (depth_from_screen * vec3(gl_FragCoord.xy / viewport, 1.0)).xy * vec2(size) - 0.5, part = fract(p);
  float sum = 0.0;
  for (int i = 0; i < 4; ++i) {
    ivec2 corner = ivec2(i & 1, i >> 1);
    float real = 0.001 * float(texelFetch(depth, clamp(ivec2(floor(p)) + corner, ivec2(0), size - 1), 0).r);
    vec2 weight = mix(1.0 - part, part, vec2(corner));
    float before = 1.0 / gl_FragCoord.w - real, above = 2.0 * height;
    if (eye_height > 0.0) above = before = eye_height * (1.0 - real * gl_FragCoord.w);
    sum += weight.x * weight.y * (real > 0.0 ? above * smoothstep(bias, 2.0 * bias, before) : 0.0);
  }
  return sum;
}
void main() {
  float up = stands();
  vec2 from = eye_height > 0.0 ? mix(place, eye, up / eye_height) : place;
  float sharp = (1.0 - at(object, object_box, from - up * slide, up, layers.x, 0.0)) * (1.0 - sand_opacity * at(sand, sand_box, from, 0.0, 1.0, 0.0));
  float rest = max(at(object_room, object_room_box, from, up, layers.y, 1.0) - s, 0.0) * max(at(sand_room, sand_room_box, from, 0.0, 1.0, 1.0) - s, 0.0);
  // What stands higher, as a hand does, gets none.
  float left = mix(s * sharp + (s < 1.0 ? rest / (1.0 - s) : 0.0), 1.0, smoothstep(height, 2.0 * height, up));
  colour = vec4(0.0, 0.0, 0.0, 1.0 - pow(left, 1.0 / 2.2));  // the surface blends encoded values
}
)glsl";
constexpr GLsizeiptr k_bytes = sample::k_grains * sizeof(sandglass_grain);
constexpr float k_depth_bias = 0.03f;  // metres: ARCore's depth at arm's length

struct Session {
  sample::Sand sand;
  sample::Performance performance{sample::k_budget_ns};
  sandglass_camera_image image = {};
  bool seen = false;
  double last_seconds = 0.0;
  GLuint program = 0, buffers[sample::k_buffers] = {}, table = 0, textures[5] = {};  // the last is the depth
  uint64_t versions[4] = {~0ull, ~0ull, ~0ull, ~0ull};                               // of those in the textures
  float depth_from_screen[9] = {};
};

Session* of(jlong handle) { return reinterpret_cast<Session*>(handle); }

void compile(GLuint program, GLenum kind, const char* text) {
  const GLuint shader = glCreateShader(kind);
  glShaderSource(shader, 1, &text, nullptr);
  glCompileShader(shader);
  glAttachShader(program, shader);
  glDeleteShader(shader);
}

GLuint program(const char* vertex, const char* fragment) {
  const GLuint made = glCreateProgram();
  compile(made, GL_VERTEX_SHADER, vertex);
  compile(made, GL_FRAGMENT_SHADER, fragment);
  glLinkProgram(made);
  return made;
}

void bind(const Session& s, int unit, GLenum filter) {
  glActiveTexture(GL_TEXTURE0 + static_cast<GLenum>(unit));
  glBindTexture(GL_TEXTURE_2D, s.textures[unit]);
  for (const GLenum name : {GL_TEXTURE_MIN_FILTER, GL_TEXTURE_MAG_FILTER})
    glTexParameteri(GL_TEXTURE_2D, name, static_cast<GLint>(filter));
  for (const GLenum name : {GL_TEXTURE_WRAP_S, GL_TEXTURE_WRAP_T})
    glTexParameteri(GL_TEXTURE_2D, name, GL_CLAMP_TO_EDGE);
}

void forget_depth(const Session& s) {
  const uint16_t unknown = 0;
  bind(s, 4, GL_NEAREST);
  glTexImage2D(GL_TEXTURE_2D, 0, GL_R16UI, 1, 1, 0, GL_RED_INTEGER, GL_UNSIGNED_SHORT, &unknown);
}

// Before what stands on it. It hides nothing, so it writes no depth.
void draw_table(Session& s, const float projection[16], const float view[16], float width, float height) {
  const auto place = [&s](const char* name) { return glGetUniformLocation(s.table, name); };
  const sample::Shadows shadows = s.sand.shadows();
  const sample::ShadowTexture all[] = {shadows.object, shadows.object_room, shadows.sand, shadows.sand_room};
  const char* const names[] = {"object", "object_room", "sand", "sand_room"};
  const char* const boxes[] = {"object_box", "object_room_box", "sand_box", "sand_room_box"};
  glEnable(GL_DEPTH_TEST);
  glUseProgram(s.table);
  glPixelStorei(GL_UNPACK_ALIGNMENT, 1);
  for (int i = 0; i < 4; ++i) {
    const auto side = static_cast<GLsizei>(all[i].texels), rows = static_cast<GLsizei>(all[i].layers) * side;
    bind(s, i, GL_LINEAR);
    if (s.versions[i] != all[i].version)
      glTexImage2D(GL_TEXTURE_2D, 0, GL_R8, side, rows, 0, GL_RED, GL_UNSIGNED_BYTE, all[i].bytes);
    s.versions[i] = all[i].version;
    glUniform1i(place(names[i]), i);
    glUniform4fv(place(boxes[i]), 1, all[i].box);
  }
  bind(s, 4, GL_NEAREST);
  glUniform1i(place("depth"), 4);
  glUniformMatrix3fv(place("depth_from_screen"), 1, GL_FALSE, s.depth_from_screen);
  glUniformMatrix4fv(place("projection"), 1, GL_FALSE, projection);
  glUniformMatrix4fv(place("view"), 1, GL_FALSE, view);
  glUniform3fv(place("origin"), 1, s.sand.origin());
  glUniform1f(place("half_side"), sample::k_table);
  glUniform1f(place("s"), shadows.main_share);
  glUniform1f(place("sand_opacity"), shadows.sand_opacity);
  glUniform2f(place("viewport"), width, height);
  // The eye lies at -transpose(rotation) * translation of the view.
  float eye[3];
  for (int k = 0; k < 3; ++k) {
    const float* axis = view + 4 * k;
    eye[k] = -(axis[0] * view[12] + axis[1] * view[13] + axis[2] * view[14]) - s.sand.origin()[k];
  }
  glUniform2f(place("eye"), eye[0], eye[2]);
  glUniform1f(place("eye_height"), eye[1]);
  glUniform2fv(place("slide"), 1, shadows.slide);
  glUniform2f(place("layers"), static_cast<float>(shadows.object.layers),
              static_cast<float>(shadows.object_room.layers));
  glUniform1f(place("height"), sample::k_receives);
  glUniform1f(place("bias"), k_depth_bias);
  glEnable(GL_BLEND);
  glBlendFunc(GL_SRC_ALPHA, GL_ONE_MINUS_SRC_ALPHA);
  glDepthMask(GL_FALSE);
  glDrawArrays(GL_TRIANGLE_STRIP, 0, 4);
  glDepthMask(GL_TRUE);
  glDisable(GL_BLEND);
}

void draw(const Session& s, GLsizei count, const float projection[16], const float view[16], float height) {
  const auto place = [&s](const char* name) { return glGetUniformLocation(s.program, name); };
  const sample::Shading shading = s.sand.shading();
  glUseProgram(s.program);
  glUniformMatrix4fv(place("projection"), 1, GL_FALSE, projection);
  glUniformMatrix4fv(place("view"), 1, GL_FALSE, view);
  glUniform3fv(place("origin"), 1, s.sand.origin());
  glUniform1f(place("pixels_at_one_metre"), 0.35f * sample::k_particle_radius * projection[5] * height);
  glUniform3fv(place("to_light"), 1, shading.to_light);
  glUniform3fv(place("sun"), 1, shading.sun);
  glUniform3fv(place("ambient"), 1, shading.ambient);
  const sample::Buffers& buffers = s.sand.buffers();
  glUniform2f(place("mixed"), buffers.share, buffers.span);
  for (const GLuint i : {0u, 1u}) {
    glBindBuffer(GL_ARRAY_BUFFER, s.buffers[i == 0 ? buffers.older : buffers.newer]);
    glEnableVertexAttribArray(i);
    glVertexAttribPointer(i, 4, GL_FLOAT, GL_FALSE, sizeof(sandglass_grain), nullptr);
  }
  glDrawArrays(GL_POINTS, 0, count);
}

}  // namespace

extern "C" {

JNIEXPORT jlong JNICALL Java_org_sandglass_sample_Sand_create(JNIEnv*, jclass) {
  auto s = std::make_unique<Session>();
  if (!s->sand.create(s->performance.headroom(0.0))) return 0;  // the status has the reason: log it
  s->program = program(k_vertex_shader, k_fragment_shader);
  s->table = program(k_table_vertex_shader, k_table_fragment_shader);
  glGenTextures(5, s->textures);
  forget_depth(*s);
  glGenBuffers(sample::k_buffers, s->buffers);
  for (const GLuint buffer : s->buffers) {
    glBindBuffer(GL_ARRAY_BUFFER, buffer);
    glBufferData(GL_ARRAY_BUFFER, k_bytes, nullptr, GL_DYNAMIC_DRAW);
  }
  return reinterpret_cast<jlong>(s.release());
}

JNIEXPORT void JNICALL Java_org_sandglass_sample_Sand_pour(JNIEnv*, jclass, jlong handle, jfloat x, jfloat y,
                                                           jfloat z) {
  const float point[3] = {x, y, z};
  of(handle)->sand.pour(point);
}

JNIEXPORT jboolean JNICALL Java_org_sandglass_sample_Sand_image(JNIEnv* env, jclass, jlong handle, jobjectArray planes,
                                                                jintArray strides, jint width, jint height,
                                                                jlong timestamp_ns, jfloatArray lens, jfloatArray pose,
                                                                jfloat exposure, jfloatArray gains) {
  Session* s = of(handle);
  jint of_planes[6];
  float of_lens[4];
  env->GetIntArrayRegion(strides, 0, 6, of_planes);
  env->GetFloatArrayRegion(lens, 0, 4, of_lens);
  s->image = sandglass::camera_image();
  s->image.format = SANDGLASS_CAMERA_I420;
  s->image.chroma_step = static_cast<uint32_t>(of_planes[3]);
  for (int i = 0; i < 3; ++i) {
    s->image.planes[i] = static_cast<uint8_t*>(env->GetDirectBufferAddress(env->GetObjectArrayElement(planes, i)));
    s->image.strides[i] = of_planes[2 * i];
  }
  s->image.width = static_cast<uint32_t>(width);
  s->image.height = static_cast<uint32_t>(height);
  s->image.timestamp_ns = static_cast<uint64_t>(timestamp_ns);
  s->image.focal_x = of_lens[0];
  s->image.focal_y = of_lens[1];
  s->image.centre_x = of_lens[2];
  s->image.centre_y = of_lens[3];
  env->GetFloatArrayRegion(pose, 0, 4, s->image.orientation);
  env->GetFloatArrayRegion(pose, 4, 3, s->image.position);
  s->image.exposure = exposure;
  // Red, both greens of the sensor, blue.
  constexpr jsize k_of_colour[3] = {0, 1, 3};
  for (int c = 0; c < 3 && gains != nullptr; ++c)
    env->GetFloatArrayRegion(gains, k_of_colour[c], 1, &s->image.gains[c]);
  return s->seen = sandglass_camera_check(&s->image, nullptr) == SANDGLASS_OK;
}

JNIEXPORT void JNICALL Java_org_sandglass_sample_Sand_depth(JNIEnv* env, jclass, jlong handle, jobject plane,
                                                            jint row_stride, jint width, jint height,
                                                            jfloatArray corners) {
  Session* s = of(handle);
  float c[6];
  env->GetFloatArrayRegion(corners, 0, 6, c);
  const float columns[9] = {c[2] - c[0], c[3] - c[1], 0, c[4] - c[0], c[5] - c[1], 0, c[0], c[1], 1};
  for (int i = 0; i < 9; ++i) s->depth_from_screen[i] = columns[i];
  bind(*s, 4, GL_NEAREST);
  glPixelStorei(GL_UNPACK_ALIGNMENT, 2);
  glPixelStorei(GL_UNPACK_ROW_LENGTH, row_stride / 2);
  glTexImage2D(GL_TEXTURE_2D, 0, GL_R16UI, width, height, 0, GL_RED_INTEGER, GL_UNSIGNED_SHORT,
               env->GetDirectBufferAddress(plane));
  glPixelStorei(GL_UNPACK_ROW_LENGTH, 0);
}

JNIEXPORT jboolean JNICALL Java_org_sandglass_sample_Sand_frame(JNIEnv* env, jclass, jlong handle, jdouble seconds,
                                                                jfloatArray projection, jfloatArray view, jint width,
                                                                jint height) {
  Session* s = of(handle);
  float of_projection[16], of_view[16];
  env->GetFloatArrayRegion(projection, 0, 16, of_projection);
  env->GetFloatArrayRegion(view, 0, 16, of_view);
  const float step = s->last_seconds > 0.0 ? static_cast<float>(seconds - s->last_seconds) : 0.0f;
  s->last_seconds = seconds;
  const bool rested = s->sand.rests();
  // The buffer keeps what it holds. Mapping it waits for the frame before the last, if the GPU still draws that.
  glBindBuffer(GL_ARRAY_BUFFER, s->buffers[s->sand.buffers().next]);
  void* grains = glMapBufferRange(GL_ARRAY_BUFFER, 0, k_bytes, GL_MAP_WRITE_BIT | GL_MAP_FLUSH_EXPLICIT_BIT);
  const sandglass_frame_report report = s->sand.frame(
      step, s->performance.headroom(seconds), static_cast<sandglass_grain*>(grains), s->seen ? &s->image : nullptr);
  s->seen = false;
  if (s->sand.buffers().changed) glFlushMappedBufferRange(GL_ARRAY_BUFFER, 0, k_bytes);
  glUnmapBuffer(GL_ARRAY_BUFFER);
  s->performance.report(report.time.target_ns, report.time.elapsed_ns);
  if (s->sand.rests() && !rested) forget_depth(*s);
  draw_table(*s, of_projection, of_view, static_cast<float>(width), static_cast<float>(height));
  draw(*s, static_cast<GLsizei>(report.sand.grain_numbers), of_projection, of_view, static_cast<float>(height));
  return s->sand.rests();
}

JNIEXPORT void JNICALL Java_org_sandglass_sample_Sand_destroy(JNIEnv*, jclass, jlong handle) {
  const std::unique_ptr<Session> s(of(handle));
  glDeleteBuffers(sample::k_buffers, s->buffers);
  glDeleteProgram(s->program);
  glDeleteProgram(s->table);
  glDeleteTextures(5, s->textures);
}

}  // extern "C"
