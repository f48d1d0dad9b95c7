// Segmentations: named or numbered sets of voxels, as 3D Slicer and segmentation programs write them.
#pragma once

#include <cstdint>
#include <map>
#include <set>
#include <string>
#include <vector>

#include "bone/import/volume.h"

namespace kerf {

struct Segment {
  std::string name;                    // up to 64 characters; empty in a label map without names
  std::string category;                // SNOMED CT code of its category; empty: none
  std::vector<std::string> codes;      // SNOMED CT codes of its type and its region
  std::vector<std::string> modifiers;  // SNOMED CT codes of the modifiers of both, such as left
  int label = 0;                       // its value in the voxels of its layer, 1 or more
  int layer = 0;
  std::size_t voxels = 0;
  double volume_mm3 = 0;
};

/// Segments of different layers may overlap.
struct Segmentation {
  std::string path;
  Volume lattice;                                 // without values
  std::vector<std::vector<std::int16_t>> layers;  // labels of all voxels, 0 for none
  std::vector<Segment> segments;                  // in the order of the file, or by label
  std::vector<std::string> warnings;              // one sentence each
  bool named = false;                             // true if the file names its segments
  bool cropped = false;                           // true if the file lacks slices without a segment
  std::string series_uid;  // of the CT that was segmented, if the file is DICOM and states it; otherwise empty
  std::string frame_uid;   // of the frame of reference, likewise
};

/// Segments of a file.
inline constexpr std::size_t kMaxSegments = 256;

/// Characters of a segment's name; more are left out. DICOM allows as many.
inline constexpr std::size_t kMaxSegmentName = 64;

/// Reads a segmentation (.seg.nrrd) or a label map (.nrrd .nhdr .mha .mhd .nii .nii.gz .hdr .img), also with names in a
/// NIfTI extension (label_table.h). `frame` as in ReadImageFile(). Values within 1e-3 of whole numbers are labels;
/// those of a soft map, up to 1, 100 or 255, are 1 from `threshold` on. Throws kerf::Error with one sentence if the
/// file cannot be read or contradicts itself, if its values are not labels, or if it has more than kMaxSegments
/// segments.
Segmentation ReadSegmentation(const std::string& path, const std::string& frame = "", double threshold = 0.5);

/// Returns "'mandible' (label 2, 45.30 cm3)" or "label 2 (45.30 cm3)".
std::string Describe(const Segment& segment);

/// Returns a sentence about labels of voxels that no segment has.
std::string DescribeUnnamed(const std::set<int>& labels);

/// Parses the segments in the lines "key:=value" of the header of a .seg.nrrd with `layers` layers. A segment whose
/// label the header does not give has the label 0. Throws kerf::Error, with `path` in the message, for a fault.
std::vector<Segment> ParseSegments(const std::map<std::string, std::string>& keys, std::size_t layers,
                                   const std::string& path, std::vector<std::string>& warnings);

}  // namespace kerf
