#include "bone/segmentation/dicom_segmentation.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <limits>
#include <map>
#include <set>
#include <utility>

#include "base/core/number_text.h"
#include "base/core/printable.h"
#include "bone/import/dicom_segments.h"
#include "bone/import/limits.h"
#include "kerf/error.h"

namespace kerf {
namespace {

constexpr double kSamePlace_mm = 1e-3;
constexpr double kUneven = 0.05;     // of the distance between slices; more is stated
constexpr double kMaxUneven = 0.25;  // of it, as in positions that were rounded
constexpr double kSideways = 0.1;    // of a pixel

/// Slices of a file: the place of each frame along the normal, in slices.
struct Slices {
  int count = 1;
  double spacing_mm = 1;
  Vec3 shear_W{0};         // shift sideways per length along the normal, as of a tilted gantry
  std::size_t lowest = 0;  // a frame of the first slice
  std::vector<int> of_frame;
  std::vector<int> thickness;  // of each frame, in slices
};

/// Returns the largest distance of a height from the first by other than a multiple of the spacing, in spacings.
double CalcUnevenness(const std::vector<double>& heights_mm, double spacing_mm) {
  double largest = 0;
  for (const double height_mm : heights_mm) {
    const double place = (height_mm - heights_mm.front()) / spacing_mm;
    largest = std::max(largest, std::abs(place - std::round(place)));
  }
  return largest;
}

/// Returns the distance between slices with frames at these heights, which increase. `stated_mm`: 0 if the file
/// states none; it may be the thickness of the slices instead.
double ChooseSpacing(const std::vector<double>& heights_mm, double stated_mm, const std::string& path,
                     std::vector<std::string>& warnings) {
  if (heights_mm.size() == 1) {
    if (stated_mm > 0) return stated_mm;
    throw Error(fmt::format("{}: the segmentation has one slice of unknown thickness", path));
  }
  double least_mm = heights_mm.back() - heights_mm.front(), sum_mm = 0;
  for (std::size_t i = 1; i < heights_mm.size(); ++i) least_mm = std::min(least_mm, heights_mm[i] - heights_mm[i - 1]);
  std::size_t neighbours = 0;
  for (std::size_t i = 1; i < heights_mm.size(); ++i) {
    const double gap_mm = heights_mm[i] - heights_mm[i - 1];
    if (gap_mm > 1.6 * least_mm) continue;
    sum_mm += gap_mm;
    ++neighbours;
  }
  const double mean_mm = sum_mm / static_cast<double>(neighbours);
  double spacing_mm = stated_mm > 0 ? stated_mm : least_mm;
  const double stated_slices = least_mm / spacing_mm;
  if (!(std::abs(std::round(stated_slices) - stated_slices) <= kUneven && stated_slices > kUneven)) {
    spacing_mm = least_mm;
  } else if (stated_slices > 1.5 && heights_mm.size() > 2 && CalcUnevenness(heights_mm, least_mm) <= kUneven) {
    warnings.push_back(fmt::format(
        "the segmentation has frames only at every {:.4g} mm, but states slices of {:.4g} mm: each frame was "
        "taken to be {:.4g} mm thick",
        least_mm, stated_mm, least_mm));
    spacing_mm = least_mm;
  }
  const double uneven = CalcUnevenness(heights_mm, spacing_mm);
  if (uneven <= kUneven) return spacing_mm;
  if (CalcUnevenness(heights_mm, mean_mm) < uneven) spacing_mm = mean_mm;
  const double rest = CalcUnevenness(heights_mm, spacing_mm);
  if (rest > kMaxUneven) throw Error(fmt::format("{}: the slices of the segmentation are not evenly spaced", path));
  if (rest > kUneven) {
    warnings.push_back(
        fmt::format("the positions of the segmentation's slices are up to {:.2g} mm from an even spacing of {:.4g} mm, "
                    "which was used",
                    rest * spacing_mm, spacing_mm));
  }
  return spacing_mm;
}

/// Returns the shift sideways from slice to slice, mm: 0 unless the slices are sheared, as those of a tilted gantry.
Vec3 FindShear(const DicomSegments& read, const std::vector<Vec3>& sideways, const std::vector<double>& heights_mm,
               const std::string& path) {
  const double most_mm = kSideways * std::min(read.pixel_mm[0], read.pixel_mm[1]);
  const auto beyond = [&](const Vec3& per_mm) {
    for (std::size_t f = 0; f < sideways.size(); ++f) {
      if (glm::length(sideways[f] - heights_mm[f] * per_mm) > most_mm) return true;
    }
    return false;
  };
  if (!beyond(Vec3(0))) return Vec3(0);
  Vec3 sum(0);
  double squares = 0;
  for (std::size_t f = 0; f < sideways.size(); ++f) {
    sum += heights_mm[f] * sideways[f];
    squares += heights_mm[f] * heights_mm[f];
  }
  const Vec3 per_mm = squares > 0 ? sum / squares : Vec3(0);
  if (!beyond(per_mm)) return per_mm;
  throw Error(
      fmt::format("{}: the slices of the segmentation are shifted sideways unevenly, which kerf doesn't read", path));
}

std::string DescribeNumber(const DicomSegments& read, int number) {
  for (const DicomSegment& segment : read.segments) {
    if (segment.number == number && !segment.label.empty()) return fmt::format("'{}'", segment.label);
  }
  return fmt::format("segment {}", number);
}

/// Extends each frame of a segment that has one at every n-th slice to n slices. Names the segments with other gaps.
void FillGaps(const DicomSegments& read, Slices& slices, std::vector<std::string>& warnings) {
  std::map<int, std::vector<std::pair<int, std::size_t>>> of_segment;  // slices and frames
  for (std::size_t f = 0; f < read.frames.size(); ++f) {
    of_segment[read.frames[f].segment].emplace_back(slices.of_frame[f], f);
  }
  std::string gaps;
  for (auto& [number, frames] : of_segment) {
    std::sort(frames.begin(), frames.end());
    std::set<int> steps;
    for (std::size_t i = 1; i < frames.size(); ++i) steps.insert(frames[i].first - frames[i - 1].first);
    if (steps.empty() || *steps.rbegin() == 1) continue;
    const int step = *steps.begin();
    if (steps.size() == 1 && frames.size() > 2) {
      warnings.push_back(fmt::format("{} has a frame at every {} slices only: each was taken to be {} slices thick",
                                     DescribeNumber(read, number), step, step));
      for (const auto& [slice, f] : frames) {
        slices.of_frame[f] = std::max(0, slice - (step - 1) / 2);
        slices.thickness[f] = std::min(step, slices.count - slices.of_frame[f]);
      }
      continue;
    }
    const int missing = frames.back().first - frames.front().first + 1 - static_cast<int>(frames.size());
    gaps += fmt::format("{}{} in {}", gaps.empty() ? "" : ", ", DescribeNumber(read, number),
                        FormatCount(static_cast<std::size_t>(missing), "slice", "slices"));
  }
  if (!gaps.empty()) {
    warnings.push_back(fmt::format(
        "segments without a frame between their first and last slice, where they were left empty: {}", gaps));
  }
}

Slices FindSlices(const DicomSegments& read, const std::string& path, std::vector<std::string>& warnings) {
  const Vec3 normal_W = glm::cross(read.row_W, read.column_W);
  std::vector<double> heights_mm;
  std::vector<Vec3> sideways;
  for (const DicomSegmentFrame& frame : read.frames) {
    const Vec3 off = frame.origin_W - read.frames.front().origin_W;
    heights_mm.push_back(glm::dot(off, normal_W));
    sideways.push_back(off - heights_mm.back() * normal_W);
  }
  std::vector<double> different_mm = heights_mm;
  std::sort(different_mm.begin(), different_mm.end());
  const auto same = [](double a, double b) { return b - a <= kSamePlace_mm; };
  different_mm.erase(std::unique(different_mm.begin(), different_mm.end(), same), different_mm.end());
  Slices slices;
  slices.spacing_mm = ChooseSpacing(different_mm, read.slice_mm, path, warnings);
  slices.shear_W = FindShear(read, sideways, heights_mm, path);
  slices.thickness.assign(read.frames.size(), 1);
  std::set<std::pair<int, int>> taken;
  for (const double height_mm : heights_mm) {
    const double place = (height_mm - different_mm.front()) / slices.spacing_mm;
    if (place > 1e5) throw Error(fmt::format("{}: the slices of the segmentation are too far apart", path));
    slices.of_frame.push_back(static_cast<int>(std::lround(place)));
    slices.count = std::max(slices.count, slices.of_frame.back() + 1);
    const int segment = read.frames[slices.of_frame.size() - 1].segment;
    if (taken.insert({segment, slices.of_frame.back()}).second) continue;
    throw Error(fmt::format("{}: two frames {}have the same position", path,
                            segment == 0 ? "" : fmt::format("of segment {} ", segment)));
  }
  slices.lowest = static_cast<std::size_t>(std::min_element(slices.of_frame.begin(), slices.of_frame.end()) -
                                           slices.of_frame.begin());
  FillGaps(read, slices, warnings);
  return slices;
}

Volume MakeLattice(const DicomSegments& read, const Slices& slices, const std::string& path) {
  Volume lattice;
  lattice.size = {read.size[0], read.size[1], slices.count};
  lattice.spacing_mm = {read.pixel_mm[0], read.pixel_mm[1], slices.spacing_mm};
  lattice.axes_W = {read.row_W, read.column_W, glm::cross(read.row_W, read.column_W)};
  if (slices.shear_W != Vec3(0)) {
    const Vec3 along_W = lattice.axes_W[2] + slices.shear_W;
    lattice.axes_W[2] = glm::normalize(along_W);
    lattice.spacing_mm.z *= glm::length(along_W);
  }
  lattice.origin_W = read.frames[slices.lowest].origin_W;
  if (static_cast<double>(read.size[0]) * read.size[1] * slices.count > static_cast<double>(kMaxVoxels)) {
    throw Error(fmt::format("{}: the segmentation has more than the 2^31 voxels that kerf reads", path));
  }
  CheckLattice(lattice, path);
  return lattice;
}

/// Calls visit(index in the volume) for each voxel of a segment.
template <typename Visit>
void ForEachVoxel(const DicomSegments& read, const Slices& slices, int number, Visit&& visit) {
  const std::size_t pixels = static_cast<std::size_t>(read.size[0]) * static_cast<std::size_t>(read.size[1]);
  for (std::size_t f = 0; f < read.frames.size(); ++f) {
    if (read.frames[f].segment != number) continue;
    for (int n = 0; n < slices.thickness[f]; ++n) {
      const std::size_t to = static_cast<std::size_t>(slices.of_frame[f] + n) * pixels;
      for (std::size_t i = 0; i < pixels; ++i) {
        if (read.pixels[f * pixels + i] != 0) visit(to + i);
      }
    }
  }
}

/// Puts the segment into the first layer in which it overlaps none, and counts its voxels.
void AddToLayers(const DicomSegments& read, const Slices& slices, Segment& segment, Segmentation& segmentation) {
  for (segment.layer = 0;; ++segment.layer) {
    if (segment.layer == static_cast<int>(segmentation.layers.size())) {
      segmentation.layers.emplace_back(segmentation.lattice.count(), std::int16_t{0});
    }
    std::vector<std::int16_t>& layer = segmentation.layers[static_cast<std::size_t>(segment.layer)];
    bool overlaps = false;
    ForEachVoxel(read, slices, segment.label, [&](std::size_t v) { overlaps |= layer[v] != 0; });
    if (overlaps) continue;
    ForEachVoxel(read, slices, segment.label, [&](std::size_t v) {
      segment.voxels += layer[v] == 0 ? 1 : 0;
      layer[v] = static_cast<std::int16_t>(segment.label);
    });
    segment.volume_mm3 = static_cast<double>(segment.voxels) * segmentation.lattice.CalcVoxelVolume();
    return;
  }
}

/// Puts the slices of a label map into one layer, and counts the voxels of the segments.
void TakeLabels(const DicomSegments& read, const Slices& slices, Segmentation& segmentation) {
  std::vector<std::int16_t>& layer = segmentation.layers.emplace_back(segmentation.lattice.count(), std::int16_t{0});
  std::map<int, Segment*> segment_of;
  for (Segment& segment : segmentation.segments) segment_of[segment.label] = &segment;
  std::vector<std::size_t> counts(65536, 0);
  const std::size_t pixels = static_cast<std::size_t>(read.size[0]) * static_cast<std::size_t>(read.size[1]);
  for (std::size_t f = 0; f < read.frames.size(); ++f) {
    const std::size_t to = static_cast<std::size_t>(slices.of_frame[f]) * pixels;
    for (std::size_t i = 0; i < pixels; ++i) {
      const std::uint16_t label = read.labels[f * pixels + i];
      ++counts[label];
      layer[to + i] =
          label > std::numeric_limits<std::int16_t>::max() ? std::int16_t{0} : static_cast<std::int16_t>(label);
    }
  }
  std::set<int> unnamed;
  for (int label = 1; label < static_cast<int>(counts.size()); ++label) {
    const std::size_t voxels = counts[static_cast<std::size_t>(label)];
    const auto segment = segment_of.find(label);
    if (segment == segment_of.end()) {
      if (voxels > 0) unnamed.insert(label);
      continue;
    }
    segment->second->voxels = voxels;
    segment->second->volume_mm3 = static_cast<double>(voxels) * segmentation.lattice.CalcVoxelVolume();
  }
  if (!unnamed.empty()) segmentation.warnings.push_back(DescribeUnnamed(unnamed));
}

}  // namespace

Segmentation ReadDicomSegmentation(const std::string& path, double threshold) {
  DicomSegments read = ReadDicomSegments(path, threshold);
  if (read.segments.size() > kMaxSegments) {
    throw Error(
        fmt::format("{}: the file has {} segments; kerf reads up to {}", path, read.segments.size(), kMaxSegments));
  }
  Segmentation segmentation;
  segmentation.warnings = std::move(read.warnings);
  const Slices slices = FindSlices(read, path, segmentation.warnings);
  segmentation.path = path;
  segmentation.lattice = MakeLattice(read, slices, path);
  segmentation.named = true;
  segmentation.series_uid = read.series_uid;
  segmentation.frame_uid = read.frame_uid;
  segmentation.cropped = true;
  for (const DicomSegment& described : read.segments) {
    Segment segment;
    segment.name = described.label.empty() ? fmt::format("Segment {}", described.number)
                                           : FirstCharacters(described.label, kMaxSegmentName);
    segment.category = described.category;
    segment.codes = described.codes;
    segment.modifiers = described.modifiers;
    segment.label = described.number;
    if (read.labels.empty()) AddToLayers(read, slices, segment, segmentation);
    segmentation.segments.push_back(std::move(segment));
  }
  if (!read.labels.empty()) TakeLabels(read, slices, segmentation);
  return segmentation;
}

}  // namespace kerf
