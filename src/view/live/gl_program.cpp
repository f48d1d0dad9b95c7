#define GL_GLEXT_PROTOTYPES
#include "view/live/gl_program.h"

#include <GL/glcorearb.h>
#include <fmt/format.h>

#include <string>

#include "kerf/error.h"

namespace kerf {
namespace {

GLuint Compile(const char* name, GLenum kind, const char* text) {
  const GLuint shader = glCreateShader(kind);
  glShaderSource(shader, 1, &text, nullptr);
  glCompileShader(shader);
  GLint good = 0;
  glGetShaderiv(shader, GL_COMPILE_STATUS, &good);
  if (good == GL_TRUE) return shader;
  std::array<char, 1024> log{};
  glGetShaderInfoLog(shader, static_cast<GLsizei>(log.size()), nullptr, log.data());
  glDeleteShader(shader);
  throw Error(fmt::format("this machine's graphics driver can't compile the shader {}: {}", name, log.data()));
}

}  // namespace

void GlProgram::Make(const char* name, const char* vertex, const char* fragment) {
  const GLuint v = Compile(name, GL_VERTEX_SHADER, vertex);
  const GLuint f = Compile(name, GL_FRAGMENT_SHADER, fragment);
  id_ = glCreateProgram();
  glAttachShader(id_, v);
  glAttachShader(id_, f);
  glLinkProgram(id_);
  glDeleteShader(v);
  glDeleteShader(f);
  GLint good = 0;
  glGetProgramiv(id_, GL_LINK_STATUS, &good);
  if (good == GL_TRUE) return;
  Release();
  throw Error(fmt::format("this machine's graphics driver can't link the shader {}", name));
}

void GlProgram::Release() {
  if (id_ != 0) glDeleteProgram(id_);
  id_ = 0;
}

void GlProgram::Use() const {
  glUseProgram(id_);
}

int GlProgram::Uniform(const char* name) const {
  return glGetUniformLocation(id_, name);
}

std::array<float, 16> ToGl(const double (&rows)[16]) {
  std::array<float, 16> columns{};
  for (std::size_t i = 0; i < 4; ++i) {
    for (std::size_t j = 0; j < 4; ++j) columns[4 * j + i] = static_cast<float>(rows[4 * i + j]);
  }
  return columns;
}

}  // namespace kerf
