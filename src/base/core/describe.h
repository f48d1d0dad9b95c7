// Descriptions of parameter structs. Each struct describes its fields once; the scene reader, `kerf scene --defaults`,
// command-line options and docs are derived from that description.
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

/// Closed range of valid values, in the unit given by the key name.
struct Range {
  double lower;
  double upper;
};

/// Valid values of a text parameter.
struct Choices {
  std::vector<std::string_view> words;
};
/// Text on one line, at most this many characters long.
struct TextLimit {
  std::size_t characters;
};

/// Returns the unit at the end of a key name in the usual notation: "mm", "mm/s", "GPa"; empty if there is none.
std::string_view UnitOfKey(std::string_view key);

}  // namespace kerf
