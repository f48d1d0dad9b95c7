// VTK's XML image data (.vti).
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "bone/import/image_header.h"
#include "bone/import/volume.h"

namespace kerf {

/// What a .vti file states, checked for impossible values.
struct VtiHeader {
  ImageLayout layout;   // kRaw for appended raw values, kText for those in ASCII, kVti for base64 or zlib
  Vec3 origin{0};       // of the first value, in the file's coordinates
  glm::dmat3 steps{1};  // from value to value, columns
  std::vector<std::string> warnings;
};

/// Returns whether `path` has the extension .vti.
bool IsVtiPath(const std::string& path);

/// Reads the header of a .vti with one piece. The values are the scalars of its points, or else of its cells. Throws
/// kerf::Error, with `path` in the message, for anything else.
VtiHeader ReadVtiHeader(const std::string& path);

/// Returns the first `bytes` bytes of the values of a kVti layout. Throws kerf::Error if there are fewer.
std::vector<char> ReadVtiValues(const ImageLayout& layout, std::size_t bytes, const std::string& path);

/// Reads the values of a checked file. A .vti names no frame: LPS is assumed with a warning unless `frame` is given.
/// The values are multiplied by `scale`; those that are no numbers become `blank`.
Volume ReadVti(const std::string& path, const std::string& frame, double scale, std::int16_t blank);

}  // namespace kerf
