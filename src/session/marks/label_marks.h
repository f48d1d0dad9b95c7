// Marks from a label map, such as a segmentation of a CT.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "session/marks/mark.h"

namespace kerf {

/// Labels on a lattice, which may be oblique, sheared or left-handed. The voxel (i, j, k) is number
/// i + size[0] (j + size[1] k) of `labels`; its centre lies at origin_W + i steps_W[0] + j steps_W[1] + k steps_W[2].
struct LabelLattice {
  std::array<int, 3> size{0, 0, 0};
  Vec3 origin_W{0};
  std::array<Vec3, 3> steps_W{Vec3{1, 0, 0}, Vec3{0, 1, 0}, Vec3{0, 0, 1}};  // mm
  std::span<const std::int16_t> labels;                                      // 0: background
};

/// Smallest structure of a label map that becomes a mark.
inline constexpr double kMinLabelMark_mm3 = 1;

/// Makes a mark of each connected part (by faces, edges or corners of voxels) of each label other than 0, of at least
/// kMinLabelMark_mm3; at most `max_marks`, the largest ones. They are in the order of their labels, the largest part
/// first, and named "nerve 1", "nerve 2" and so on with the word of `kind`. If `left_out` is given, it receives the
/// number of parts that were large enough but too many.
///
/// The curve goes through the centroids of layers of equal distance, along the voxels, from one end of the part. It
/// ends a radius before the ends of the part, since a mark has round ends, and leaves out points without which it
/// deviates by less than a quarter of a voxel and 0.2 mm. The radius is that of the tube with the curve's length and
/// the part's volume. A part whose curve would be shorter than twice its radius is a ball of its volume.
///
/// For a tube with round ends and a radius of at least two voxels, the curve is accurate to half a voxel, the radius to
/// 5 % and the length to 3 %. Throws kerf::Error if `labels` does not fit the lattice, or if there is nothing to mark.
std::vector<Mark> MakeMarksFromLabels(const LabelLattice& lattice, MarkKind kind, std::size_t max_marks = kMaxMarks,
                                      std::size_t* left_out = nullptr);

/// Returns true if the mark is longer than six times its radius, as a nerve is, and a tooth is not.
bool LooksLikeNerve(const Mark& mark);

}  // namespace kerf
