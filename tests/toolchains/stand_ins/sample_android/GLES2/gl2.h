#pragma once
typedef unsigned int GLuint, GLenum;
typedef int GLint, GLsizei;
typedef float GLfloat;
typedef unsigned char GLboolean;
typedef char GLchar;
#define GL_FALSE 0
#define GL_TRIANGLE_STRIP 0x0005
#define GL_DEPTH_TEST 0x0B71
#define GL_FLOAT 0x1406
#define GL_LINEAR 0x2601
#define GL_TEXTURE_MAG_FILTER 0x2800
#define GL_TEXTURE_MIN_FILTER 0x2801
#define GL_FRAGMENT_SHADER 0x8B30
#define GL_VERTEX_SHADER 0x8B31
extern "C" {
void glGenTextures(GLsizei n, GLuint* textures);
void glBindTexture(GLenum target, GLuint texture);
void glTexParameteri(GLenum target, GLenum name, GLint value);
GLuint glCreateProgram(void);
GLuint glCreateShader(GLenum type);
void glShaderSource(GLuint shader, GLsizei count, const GLchar* const* text, const GLint* length);
void glCompileShader(GLuint shader);
void glAttachShader(GLuint program, GLuint shader);
void glDeleteShader(GLuint shader);
void glBindAttribLocation(GLuint program, GLuint index, const GLchar* name);
void glLinkProgram(GLuint program);
void glUseProgram(GLuint program);
void glDisable(GLenum capability);
void glVertexAttribPointer(GLuint index, GLint size, GLenum type, GLboolean normalized, GLsizei stride,
                           const void* pointer);
void glEnableVertexAttribArray(GLuint index);
void glDrawArrays(GLenum mode, GLint first, GLsizei count);
}
