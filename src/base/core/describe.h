// Parameter structs describe their fields once; the scene reader, `kerf scene --defaults`, command-line options and
// docs are all made from that description.
//
//   template <typename Visitor>
//   void Describe(BlockParams& p, Visitor&& visit) {
//     visit("voxel_mm", p.voxel_mm, Range{0.02, 4}, "edge of a voxel");
//   }
#pragma once

#include <cstddef>
#include <string_view>
#include <vector>

namespace kerf {

/// Closed range of valid values, in the unit that the key names.
struct Range {
  double lower;
  double upper;
};

/// The words that a text may be.
struct Choices {
  std::vector<std::string_view> words;
};
/// A text of at most this many characters, on one line.
struct TextLimit {
  std::size_t characters;
};

/// The unit that a key's name ends in, as people write it: "mm", "mm/s", "GPa"; empty for a number without unit.
std::string_view UnitOfKey(std::string_view key);

}  // namespace kerf
