// What the segments of a segmentation are: the mandible, teeth, the nerve's canal, other bone.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "bone/import/mask.h"
#include "bone/import/write_dicom_segments.h"
#include "bone/segmentation/segmentation.h"
#include "kerf/describe.h"

namespace kerf {

enum class SegmentRole { kMandible, kTooth, kCanal, kMetal, kLesion, kOtherBone, kIgnored };

/// Returns the name of a role as the option --label takes it, such as "mandible".
const char* ToString(SegmentRole role);

enum class JawSide { kUnknown, kLeft, kRight };
enum class JawPart { kUnknown, kLower, kUpper };

struct SegmentMeaning {
  SegmentRole role = SegmentRole::kIgnored;
  int fdi = 0;                       // of a tooth: its number after ISO 3950; 0: unknown
  JawPart jaw = JawPart::kUnknown;   // of a tooth
  JawSide side = JawSide::kUnknown;  // of a canal
  bool operator==(const SegmentMeaning&) const = default;
};

/// Returns the meaning of a segment's name in English or German, as 3D Slicer, DentalSegmentator, TotalSegmentator and
/// their users write them; nullopt if it is not known.
std::optional<SegmentMeaning> FindMeaning(const std::string& name);

/// Throws kerf::Error unless the text is an assignment as in LabelOptions.
void CheckAssignment(const std::string& assignment);

/// Returns the meaning of a segment's SNOMED CT codes; nullopt if they are not known.
std::optional<SegmentMeaning> FindCodedMeaning(const Segment& segment);

struct SegmentCodes {
  DicomCode category, type;
};
/// Returns the codes of a segment: of a meaning those that FindCodedMeaning() understands, except that the canal has a
/// code of kerf's own, since no standard one is known to kerf; without a meaning those of some bone.
SegmentCodes FindCodes(const std::optional<SegmentMeaning>& meaning);

struct PresetLabel {
  int label;
  std::string name;  // as the source names it
};

/// Labels of a program or a set of data whose files do not name them.
struct LabelPreset {
  std::string name;
  std::string source;
  std::vector<PresetLabel> labels;
};

const std::vector<LabelPreset>& ListLabelPresets();

struct LabelOptions {
  std::string preset;                    // of ListLabelPresets(); empty: none
  std::vector<std::string> assignments;  // "2=mandible", "Bone=mandible", "3=tooth36", "4=canal", ...
  double threshold = 0.5;                // from which on a voxel of a fractional segmentation or soft map counts
};

template <typename V>
void Describe(LabelOptions& p, V&& visit) {
  visit("mask_threshold", p.threshold, Range{0, 1},
        "fraction from which on a voxel of a fractional DICOM segmentation, or of a soft map, counts");
}

struct SegmentationRoles {
  std::vector<SegmentMeaning> meanings;  // of each segment
  std::vector<std::string> warnings;     // one sentence each
};

/// Finds what the segments are: by the assignments, then by the preset, then by names and codes. Throws kerf::Error if
/// an option is invalid, if no segment or more than one is the mandible, if a name contradicts its code, or if nothing
/// says what the labels are; the message then lists the labels, their volumes and the presets that fit by volume and
/// place. It also throws if the given preset does not fit, but another one does (preset_check.h); if none does, it
/// warns.
SegmentationRoles FindRoles(const Segmentation& segmentation, const LabelOptions& options);

/// Makes the mask of the mandible. The lower teeth and the canals belong to it; upper teeth and other bone do not;
/// whether metal, lesions, teeth of an unknown jaw, and voxels in both the mandible and other bone belong to it is left
/// to the CT. Teeth keep their numbers.
BoneMask MakeBoneMask(const Segmentation& segmentation, const SegmentationRoles& roles);

}  // namespace kerf
