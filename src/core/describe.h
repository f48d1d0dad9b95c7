// Parameter structs describe their fields once; the scene reader, `kerf scene --defaults`, command-line options and
// docs are all made from that description.
//
//   template <typename Visitor>
//   void Describe(BlockParams& p, Visitor&& visit) {
//     visit("voxel_mm", p.voxel_mm, Range{0.02, 4}, "edge of a voxel");
//   }
#pragma once

namespace kerf {

/// Closed range of valid values, in the unit that the key names.
struct Range {
  double lower;
  double upper;
};

}  // namespace kerf
