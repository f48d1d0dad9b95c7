#include "bone/segmentation/role_warnings.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <map>

#include "bone/import/image_fields.h"

namespace kerf {
namespace {

bool IsPulp(const std::string& name) {
  const std::string lower = Lower(name);
  return lower.find("pulp") != std::string::npos || lower.find("root") != std::string::npos;
}

// One digit is no number of ISO 3950, but counts teeth, as in "tooth 1 from the middle".
bool HasTwoDigits(const std::string& name) {
  const auto is_digit = [](unsigned char c) { return std::isdigit(c) != 0; };
  return std::adjacent_find(name.begin(), name.end(), [&](char a, char b) { return is_digit(a) && is_digit(b); }) !=
         name.end();
}

}  // namespace

void AddRoleWarnings(const Segmentation& segmentation, SegmentationRoles& roles, const std::vector<bool>& by_name) {
  std::string empty, canals;
  std::map<int, std::size_t> teeth;
  for (std::size_t n = 0; n < segmentation.segments.size(); ++n) {
    const Segment& segment = segmentation.segments[n];
    const SegmentMeaning& meaning = roles.meanings[n];
    if (segment.voxels == 0) {
      std::string& list = meaning.role == SegmentRole::kCanal ? canals : empty;
      list += (list.empty() ? "" : ", ") + Describe(segment);
    }
    if (meaning.role != SegmentRole::kTooth || !by_name[n] || IsPulp(segment.name)) continue;
    if (meaning.fdi == 0 && HasTwoDigits(segment.name)) {
      roles.warnings.push_back(
          fmt::format("the segment {} is a tooth, but its number is not of ISO 3950; it is used without a number",
                      Describe(segment)));
    }
    if (meaning.fdi == 0) continue;
    const auto [first, is_new] = teeth.emplace(meaning.fdi, n);
    if (!is_new) {
      roles.warnings.push_back(fmt::format("the segments {} and {} are both tooth {}; they are used as one tooth",
                                           Describe(segmentation.segments[first->second]), Describe(segment),
                                           meaning.fdi));
    }
  }
  if (!canals.empty()) {
    roles.warnings.push_back(fmt::format("the canal of the nerve is absent from the mask: no voxel is {}", canals));
  }
  if (!empty.empty()) roles.warnings.push_back(fmt::format("segments without voxels: {}", empty));
}

}  // namespace kerf
