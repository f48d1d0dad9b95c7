// Picture in memory.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "bone/mesh/meshfile.h"
#include "kerf/describe.h"

namespace kerf {

/// Pixels along a side of a picture, and of a sheet or plot.
inline constexpr Range kPictureSideRange{64, 8192};
inline constexpr Range kSheetSideRange{200, kPictureSideRange.upper};

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
