// OpenGL 3.3 program in the current context.
#pragma once

#include <array>
#include <cstdint>

namespace kerf {

class GlProgram {
 public:
  GlProgram() = default;
  ~GlProgram() = default;  // call Release() first, while the context exists
  GlProgram(const GlProgram&) = delete;
  GlProgram& operator=(const GlProgram&) = delete;

  bool made() const { return id_ != 0; }
  /// Throws Error with the driver's message if the program does not compile.
  void Make(const char* name, const char* vertex, const char* fragment);
  void Release();
  void Use() const;
  /// Returns -1 if the driver has optimised the uniform away; setting the uniform -1 has no effect.
  int Uniform(const char* name) const;
  std::uint32_t id() const { return id_; }

 private:
  std::uint32_t id_ = 0;
};

/// Converts VTK's row-major matrix to OpenGL's column-major order.
std::array<float, 16> ToGl(const double (&rows)[16]);

}  // namespace kerf
