// Sand over ARCore's camera image. Java hands over image, poses and matrices (Sand.java says where each comes from);
// this file maps a vertex buffer, runs the library's frame into it, and draws the grains as points with OpenGL ES.
#include <GLES3/gl3.h>
#include <jni.h>

#include <iterator>
#include <memory>

#include "performance.h"
#include "sand.h"

namespace {

// A grain: a round point with the shading of a sphere. Its radius is 0.35 of a particle's.
const char k_vertex_shader[] = R"glsl(#version 300 es
layout(location = 0) in vec3 position;
uniform mat4 projection, view;
uniform vec3 origin;
uniform float pixels_at_one_metre;
void main() {
  gl_Position = projection * view * vec4(position + origin, 1.0);
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

struct Session {
  sample::Sand sand;
  sample::Performance performance{16'666'667};  // the display's interval
  sandglass_camera_image image = {};
  bool seen = false;
  double last_seconds = 0.0;
  GLuint program = 0, buffer = 0;
};

Session* of(jlong handle) { return reinterpret_cast<Session*>(handle); }

void compile(GLuint program, GLenum kind, const char* text) {
  const GLuint shader = glCreateShader(kind);
  glShaderSource(shader, 1, &text, nullptr);
  glCompileShader(shader);
  glAttachShader(program, shader);
  glDeleteShader(shader);
}

void draw(const Session& s, GLsizei count, const float projection[16], const float view[16], float height) {
  const auto place = [&s](const char* name) { return glGetUniformLocation(s.program, name); };
  const sample::Shading shading = s.sand.shading();
  glEnable(GL_DEPTH_TEST);
  glUseProgram(s.program);
  glUniformMatrix4fv(place("projection"), 1, GL_FALSE, projection);
  glUniformMatrix4fv(place("view"), 1, GL_FALSE, view);
  glUniform3fv(place("origin"), 1, s.sand.origin());
  glUniform1f(place("pixels_at_one_metre"), 0.35f * sample::k_particle_radius * projection[5] * height);
  glUniform3fv(place("to_light"), 1, shading.to_light);
  glUniform3fv(place("sun"), 1, shading.sun);
  glUniform3fv(place("ambient"), 1, shading.ambient);
  glEnableVertexAttribArray(0);
  glVertexAttribPointer(0, 3, GL_FLOAT, GL_FALSE, sizeof(sandglass_grain), nullptr);
  glDrawArrays(GL_POINTS, 0, count);
}

}  // namespace

extern "C" {

JNIEXPORT jlong JNICALL Java_org_sandglass_sample_Sand_create(JNIEnv*, jclass) {
  auto s = std::make_unique<Session>();
  if (!s->sand.create()) return 0;  // the status has the reason: log it
  s->program = glCreateProgram();
  compile(s->program, GL_VERTEX_SHADER, k_vertex_shader);
  compile(s->program, GL_FRAGMENT_SHADER, k_fragment_shader);
  glLinkProgram(s->program);
  glGenBuffers(1, &s->buffer);
  glBindBuffer(GL_ARRAY_BUFFER, s->buffer);
  glBufferData(GL_ARRAY_BUFFER, sample::k_grains * sizeof(sandglass_grain), nullptr, GL_STREAM_DRAW);
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
                                                                jfloat exposure) {
  Session* s = of(handle);
  const uint8_t* bytes[3];
  for (int i = 0; i < 3; ++i)
    bytes[i] = static_cast<uint8_t*>(env->GetDirectBufferAddress(env->GetObjectArrayElement(planes, i)));
  jint of_planes[6];
  float of_lens[4], of_pose[7];
  env->GetIntArrayRegion(strides, 0, 6, of_planes);
  env->GetFloatArrayRegion(lens, 0, 4, of_lens);
  env->GetFloatArrayRegion(pose, 0, 7, of_pose);
  s->image = sandglass::camera_image();
  s->image.format = SANDGLASS_CAMERA_I420;
  s->image.chroma_step = static_cast<uint32_t>(of_planes[3]);
  for (int i = 0; i < 3; ++i) {
    s->image.planes[i] = bytes[i];
    s->image.strides[i] = of_planes[2 * i];
  }
  s->image.width = static_cast<uint32_t>(width);
  s->image.height = static_cast<uint32_t>(height);
  s->image.timestamp_ns = static_cast<uint64_t>(timestamp_ns);
  s->image.focal_x = of_lens[0];
  s->image.focal_y = of_lens[1];
  s->image.centre_x = of_lens[2];
  s->image.centre_y = of_lens[3];
  for (int k = 0; k < 4; ++k) s->image.orientation[k] = of_pose[k];
  for (int k = 0; k < 3; ++k) s->image.position[k] = of_pose[4 + k];
  s->image.exposure = exposure;
  return s->seen = sandglass_camera_check(&s->image, nullptr) == SANDGLASS_OK;
}

JNIEXPORT void JNICALL Java_org_sandglass_sample_Sand_frame(JNIEnv* env, jclass, jlong handle, jdouble seconds,
                                                            jfloatArray projection, jfloatArray view, jint height) {
  Session* s = of(handle);
  float of_projection[16], of_view[16];
  env->GetFloatArrayRegion(projection, 0, 16, of_projection);
  env->GetFloatArrayRegion(view, 0, 16, of_view);
  const float step = s->last_seconds > 0.0 ? static_cast<float>(seconds - s->last_seconds) : 0.0f;
  s->last_seconds = seconds;
  // Invalidating gives new memory while the GPU still reads the old: the library writes where nobody reads.
  glBindBuffer(GL_ARRAY_BUFFER, s->buffer);
  void* grains = glMapBufferRange(GL_ARRAY_BUFFER, 0, sample::k_grains * sizeof(sandglass_grain),
                                  GL_MAP_WRITE_BIT | GL_MAP_INVALIDATE_BUFFER_BIT);
  const sandglass_frame_report report = s->sand.frame(
      step, s->performance.headroom(seconds), static_cast<sandglass_grain*>(grains), s->seen ? &s->image : nullptr);
  s->seen = false;
  glUnmapBuffer(GL_ARRAY_BUFFER);
  s->performance.report(report.time.target_ns, report.time.elapsed_ns);
  draw(*s, static_cast<GLsizei>(report.sand.grain_numbers), of_projection, of_view, static_cast<float>(height));
}

JNIEXPORT void JNICALL Java_org_sandglass_sample_Sand_destroy(JNIEnv*, jclass, jlong handle) {
  const std::unique_ptr<Session> s(of(handle));
  glDeleteBuffers(1, &s->buffer);
  glDeleteProgram(s->program);
}

}  // extern "C"
