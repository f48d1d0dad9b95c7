#include "bone/import/label_image.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdint>
#include <utility>
#include <vector>

#include "bone/import/image_file.h"
#include "kerf/error.h"

namespace kerf {

std::string FindLabelObjection(std::span<const std::int16_t> values, bool exact, std::size_t max_different) {
  const std::int16_t lowest = values.empty() ? std::int16_t{0} : *std::min_element(values.begin(), values.end());
  if (lowest < 0) return fmt::format("it has negative values, down to {}", lowest);
  if (!exact) return "it has values that are not whole numbers from 0 to 32767";
  std::vector<bool> found(32768);
  std::size_t different = 0;
  for (const std::int16_t label : values) {
    if (found[static_cast<std::size_t>(label)]) continue;
    found[static_cast<std::size_t>(label)] = true;
    ++different;
  }
  if (different <= max_different) return {};
  return fmt::format("it has {} different values, and a label map has at most {}", different, max_different);
}

Volume ReadLabelImage(const std::string& path) {
  Volume image = ReadImageFile(path);
  if (const std::string objection = FindLabelObjection(image.hu, image.exact, kMaxDifferentLabels);
      !objection.empty()) {
    throw Error(
        fmt::format("{}: this image looks like a CT, not like a label map: {}; export the segmentation as a "
                    "label map",
                    path, objection));
  }
  return image;
}

}  // namespace kerf
