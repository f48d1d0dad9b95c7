// Translucent shapes whose vertices are computed again for each frame, in the current OpenGL context.
#pragma once

#include <cstddef>
#include <cstdint>
#include <initializer_list>
#include <span>
#include <vector>

#include "view/live/gl_program.h"

class vtkOpenGLRenderWindow;

namespace kerf {

/// A program, and the buffer with the vertices that it draws. The scene's depth is tested, but not written.
class VertexStream {
 public:
  /// `name`: of the shaders. `floats`: the number of floats of each attribute of a vertex, in the order in which they
  /// are stored; their locations in the vertex shader are 0, 1, ... The texts must outlive the stream.
  VertexStream(const char* name, const char* vertex_shader, const char* fragment_shader,
               std::initializer_list<int> floats);
  ~VertexStream() = default;  // call Release() first, while the context exists
  VertexStream(const VertexStream&) = delete;
  VertexStream& operator=(const VertexStream&) = delete;

  /// Sends the vertices and prepares drawing them; uniforms can be set from then on. End() must follow. Throws Error if
  /// the program does not compile.
  void Begin(vtkOpenGLRenderWindow& window, std::span<const std::byte> vertices);
  void End(vtkOpenGLRenderWindow& window);
  void Release();
  const GlProgram& program() const { return program_; }

 private:
  void Make();

  const char* name_;
  const char* vertex_shader_;
  const char* fragment_shader_;
  std::vector<int> floats_;
  GlProgram program_;
  std::uint32_t vertex_array_ = 0;
  std::uint32_t buffer_ = 0;
};

}  // namespace kerf
