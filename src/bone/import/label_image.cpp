#include "bone/import/label_image.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdint>
#include <utility>
#include <vector>

#include "bone/import/image_file.h"
#include "kerf/error.h"

namespace kerf {
namespace {

/// Returns why the values are not those of a label map; empty if they are.
std::string FindObjection(const Volume& image) {
  const std::int16_t lowest = *std::min_element(image.hu.begin(), image.hu.end());
  if (lowest < 0) return fmt::format("it has negative values, down to {}", lowest);
  if (!image.exact) return "it has values that are not whole numbers from 0 to 32767";
  std::vector<bool> found(32768);
  std::size_t different = 0;
  for (const std::int16_t label : image.hu) {
    if (found[static_cast<std::size_t>(label)]) continue;
    found[static_cast<std::size_t>(label)] = true;
    ++different;
  }
  if (different <= kMaxDifferentLabels) return {};
  return fmt::format("it has {} different values, and a label map has at most {}", different, kMaxDifferentLabels);
}

}  // namespace

Volume ReadLabelImage(const std::string& path) {
  Volume image = ReadImageFile(path);
  if (const std::string objection = FindObjection(image); !objection.empty()) {
    throw Error(
        fmt::format("{}: this image looks like a CT, not like a label map: {}; export the segmentation as a "
                    "label map",
                    path, objection));
  }
  return image;
}

}  // namespace kerf
