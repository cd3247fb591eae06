// The camera image as ARCore leaves it in an external texture, drawn over the whole surface.
#pragma once

#include <GLES2/gl2.h>
#include <GLES2/gl2ext.h>

#include "arcore_c_api.h"

namespace sample {

class CameraBackground {
 public:
  // Needs a current OpenGL context. Returns the texture's name, for ArSession_setCameraTextureName.
  GLuint create() {
    glGenTextures(1, &texture_);
    glBindTexture(GL_TEXTURE_EXTERNAL_OES, texture_);
    glTexParameteri(GL_TEXTURE_EXTERNAL_OES, GL_TEXTURE_MIN_FILTER, GL_LINEAR);
    glTexParameteri(GL_TEXTURE_EXTERNAL_OES, GL_TEXTURE_MAG_FILTER, GL_LINEAR);
    program_ = glCreateProgram();
    add(GL_VERTEX_SHADER,
        "attribute vec2 at; attribute vec2 uv; varying vec2 v;"
        "void main() { v = uv; gl_Position = vec4(at, 0.0, 1.0); }");
    add(GL_FRAGMENT_SHADER,
        "#extension GL_OES_EGL_image_external : require\n"
        "precision mediump float; varying vec2 v; uniform samplerExternalOES image;"
        "void main() { gl_FragColor = texture2D(image, v); }");
    glBindAttribLocation(program_, 0, "at");
    glBindAttribLocation(program_, 1, "uv");
    glLinkProgram(program_);
    return texture_;
  }

  void draw(const ArSession* session, const ArFrame* frame) {
    const float corners[8] = {-1, -1, 1, -1, -1, 1, 1, 1};
    float uv[8];
    ArFrame_transformCoordinates2d(session, frame, AR_COORDINATES_2D_OPENGL_NORMALIZED_DEVICE_COORDINATES, 4, corners,
                                   AR_COORDINATES_2D_TEXTURE_NORMALIZED, uv);
    glDisable(GL_DEPTH_TEST);
    glUseProgram(program_);
    glBindTexture(GL_TEXTURE_EXTERNAL_OES, texture_);
    glVertexAttribPointer(0, 2, GL_FLOAT, GL_FALSE, 0, corners);
    glVertexAttribPointer(1, 2, GL_FLOAT, GL_FALSE, 0, uv);
    glEnableVertexAttribArray(0);
    glEnableVertexAttribArray(1);
    glDrawArrays(GL_TRIANGLE_STRIP, 0, 4);
  }

 private:
  void add(GLenum kind, const char* text) {
    const GLuint shader = glCreateShader(kind);
    glShaderSource(shader, 1, &text, nullptr);
    glCompileShader(shader);
    glAttachShader(program_, shader);
    glDeleteShader(shader);
  }

  GLuint texture_ = 0, program_ = 0;
};

}  // namespace sample
