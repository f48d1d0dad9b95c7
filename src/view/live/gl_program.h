// A program of OpenGL 3.3 in the context that is current.
#pragma once

#include <array>
#include <cstdint>

namespace kerf {

class GlProgram {
 public:
  GlProgram() = default;
  ~GlProgram() = default;  // Release() while the context is there
  GlProgram(const GlProgram&) = delete;
  GlProgram& operator=(const GlProgram&) = delete;

  bool made() const { return id_ != 0; }
  /// Throws Error with the driver's words when it does not compile.
  void Make(const char* name, const char* vertex, const char* fragment);
  void Release();
  void Use() const;
  /// -1 where the driver has left it out; setting that does nothing.
  int Uniform(const char* name) const;
  std::uint32_t id() const { return id_; }

 private:
  std::uint32_t id_ = 0;
};

/// Column by column, as OpenGL takes it, from VTK's rows.
std::array<float, 16> ToGl(const double (&rows)[16]);

}  // namespace kerf
