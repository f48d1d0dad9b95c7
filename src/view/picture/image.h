// Picture in memory.
#pragma once

#include <cstddef>
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

/// Returns two pictures of the same height, one beside the other.
inline Image JoinImages(const Image& left, const Image& right) {
  Image joined{left.width + right.width, left.height, {}};
  joined.pixels.reserve(left.pixels.size() + right.pixels.size());
  for (int row = 0; row < left.height; ++row) {
    for (const Image* image : {&left, &right}) {
      const auto begin = image->pixels.begin() + static_cast<std::ptrdiff_t>(row) * image->width;
      joined.pixels.insert(joined.pixels.end(), begin, begin + image->width);
    }
  }
  return joined;
}
/// Adds a picture of the same width below another one, which may be empty.
inline void AppendImage(const Image& below, Image& image) {
  image.width = below.width;
  image.height += below.height;
  image.pixels.insert(image.pixels.end(), below.pixels.begin(), below.pixels.end());
}

/// Writes a PNG through a temporary file. Throws Error if `path` does not end in .png or cannot be written.
void WritePng(const Image& image, const std::string& path);

}  // namespace kerf
