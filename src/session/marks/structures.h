// What a cut did to the structures in and near a bone: canals, teeth and roots of the bone's regions, and marks.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "base/core/message.h"
#include "kerf/bone.h"
#include "session/marks/mark.h"

namespace kerf {

enum class BodySide : std::uint8_t { kLeft, kRight, kBoth };  // of the patient
enum class ToothPart : std::uint8_t { kNone, kCrown, kRoot };

/// A structure and the cut.
struct StructureResult {
  std::string name{};  // of a mark; otherwise empty: NameStructure()
  MarkKind kind = MarkKind::kOther;
  BodySide side = BodySide::kBoth;
  bool is_row = false;   // touching teeth without numbers, which are one part of the bone's regions
  int number = 0;        // of a tooth of the bone: counted on its side from the patient's middle, from 1; 0: not known
  int fdi = 0;           // number of a tooth after ISO 3950, if its region has one; otherwise 0
  bool is_mark = false;  // marked by the user; otherwise a part of the bone's regions
  bool is_cut = false;
  bool is_severed = false;  // cut over its whole cross-section, so that its two ends are no longer connected
  double removed_mm3 = 0;   // volume of the structure that was removed
  std::optional<double>
      distance_mm{};  // least distance of the removed bone from it; 0 if it is cut; none: nothing was removed
  Vec3 p_W{0};        // the structure's place that is nearest to the cut, world frame
  ToothPart part = ToothPart::kNone;  // of a tooth of the bone, at that place
  double size_mm3 = 0;                // of the structure, before the cut
};

/// Least volume that counts as an injury, in voxels of phi's grid: 0.008 mm^3 with voxels of 0.2 mm. The volume of a
/// cell is assigned to a structure as a whole by the centre of what was removed of it, so that a smaller volume is
/// within the error of the structure's border.
inline constexpr double kMinInjury_vox = 1;

/// Largest volume and horizontal extent of a single tooth: those of a large molar.
inline constexpr double kMaxTooth_mm3 = 1500;
inline constexpr double kMaxTooth_mm = 14;

struct StructureAssessment {
  std::vector<StructureResult> structures;  // cut ones first, then by distance
  bool canal_known = false;                 // the bone has a canal region, or there is a mark of a nerve or a canal
  bool teeth_known = false;                 // the bone has tooth regions, or there is a mark of a tooth or a root
};

/// Finds what the cut from `before` to `after` did to each structure.
///
/// Structures of the bone are the parts of its canal, tooth and lesion regions. Canals are divided at the patient's
/// middle plane x = mid_x_mm (without it, the middle of the bone's bounds). Each region with the number of a tooth is a
/// tooth (bone/material/segment_regions.h), and so is each connected part of the other tooth regions; parts smaller
/// than 5 mm^3 belong to the nearest tooth, and those that touch are one row: a part of more than kMaxTooth_mm3, or
/// longer than kMaxTooth_mm across. Teeth behind a row cannot be counted. The lesions are one structure. The side of a
/// structure is that of its centre; a structure with more than a fifth of its volume on the other side is on both
/// sides. The place on a tooth is a root if there is bone of another region within 1.5 mm of it, otherwise a crown.
///
/// A structure is cut if more than kMinInjury_vox was removed in it, and severed if what is left of it in the bone no
/// longer connects its two ends (see StructureBody). Distances are measured from the removed cells of phi's grid to the
/// voxels of the region grid, or to a mark's tube, and are accurate to about a voxel of either grid. A piece that was
/// taken out counts as removed.
/// Throws kerf::Error if the voxel sizes differ or CheckMarks() refuses the marks. Takes about a second.
StructureAssessment AssessStructures(const Bone& before, const Bone& after, const std::vector<Mark>& marks,
                                     std::optional<double> mid_x_mm = {});

/// Returns the name of a mark, or a description such as "canal of the nerve, patient's left", "tooth 36", "tooth 3
/// from the middle, patient's right" or "row of touching teeth, patient's left".
Message NameStructure(const StructureResult& structure);
/// Returns a place in words: "25.1 mm left, 3.2 mm back, 8.9 mm down", from the world's origin.
Message DescribePlace(const Vec3& p_W);
/// Returns one part of a place in words, along the axis 0 to 2: "25.1 mm left".
Message DescribePlaceAlong(int axis, double at_mm);
/// Returns what the places are measured from, a sentence to be translated.
const char* ExplainPlaces();

}  // namespace kerf
