#define GL_GLEXT_PROTOTYPES
#include "view/live/vertex_stream.h"

#include <GL/glcorearb.h>
#include <vtkOpenGLRenderWindow.h>
#include <vtkOpenGLShaderCache.h>
#include <vtkOpenGLState.h>

#include <numeric>

namespace kerf {

VertexStream::VertexStream(const char* name, const char* vertex_shader, const char* fragment_shader,
                           std::initializer_list<int> floats)
    : name_(name), vertex_shader_(vertex_shader), fragment_shader_(fragment_shader), floats_(floats) {}

void VertexStream::Make() {
  program_.Make(name_, vertex_shader_, fragment_shader_);
  glGenVertexArrays(1, &vertex_array_);
  glGenBuffers(1, &buffer_);
  glBindVertexArray(vertex_array_);
  glBindBuffer(GL_ARRAY_BUFFER, buffer_);
  const auto stride = static_cast<GLsizei>(sizeof(float)) * std::accumulate(floats_.begin(), floats_.end(), 0);
  const char* offset = nullptr;
  for (GLuint i = 0; i < floats_.size(); ++i) {
    glEnableVertexAttribArray(i);
    glVertexAttribPointer(i, floats_[i], GL_FLOAT, GL_FALSE, stride, offset);
    offset += sizeof(float) * static_cast<std::size_t>(floats_[i]);
  }
}

void VertexStream::Begin(vtkOpenGLRenderWindow& window, std::span<const std::byte> vertices) {
  window.GetShaderCache()->ReleaseCurrentShader();
  if (!program_.made()) Make();
  glBindVertexArray(vertex_array_);
  glBindBuffer(GL_ARRAY_BUFFER, buffer_);
  glBufferData(GL_ARRAY_BUFFER, static_cast<GLsizeiptr>(vertices.size()), vertices.data(), GL_STREAM_DRAW);
  program_.Use();
  vtkOpenGLState& state = *window.GetState();
  state.vtkglEnable(GL_DEPTH_TEST);
  state.vtkglEnable(GL_BLEND);
  state.vtkglBlendFuncSeparate(GL_SRC_ALPHA, GL_ONE_MINUS_SRC_ALPHA, GL_ONE, GL_ONE_MINUS_SRC_ALPHA);
  state.vtkglDepthMask(GL_FALSE);
}

void VertexStream::End(vtkOpenGLRenderWindow& window) {
  window.GetState()->vtkglDepthMask(GL_TRUE);
  glBindVertexArray(0);
  glBindBuffer(GL_ARRAY_BUFFER, 0);
  glUseProgram(0);
}

void VertexStream::Release() {
  if (buffer_ != 0) glDeleteBuffers(1, &buffer_);
  if (vertex_array_ != 0) glDeleteVertexArrays(1, &vertex_array_);
  buffer_ = vertex_array_ = 0;
  program_.Release();
}

}  // namespace kerf
