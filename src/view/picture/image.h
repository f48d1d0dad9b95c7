// Picture in memory.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "bone/mesh/meshfile.h"

namespace kerf {

/// 8-bit sRGB, rows from the top.
struct Image {
  int width = 0;
  int height = 0;
  std::vector<Rgb8> pixels;  // width x height

  const Rgb8& At(int column, int row) const {
    return pixels[static_cast<std::size_t>(row) * static_cast<std::size_t>(width) + static_cast<std::size_t>(column)];
  }
};

/// Writes a PNG through a temporary file. Throws Error if `path` does not end in .png or cannot be written.
void WritePng(const Image& image, const std::string& path);

}  // namespace kerf
