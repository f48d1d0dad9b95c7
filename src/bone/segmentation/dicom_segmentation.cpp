#include "bone/segmentation/dicom_segmentation.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <set>
#include <utility>

#include "base/core/printable.h"
#include "bone/import/dicom_segments.h"
#include "bone/import/limits.h"
#include "kerf/error.h"

namespace kerf {
namespace {

constexpr double kSamePlace_mm = 1e-3;
constexpr double kUneven = 0.05;  // of the distance between slices

/// Slices of a file: the place of each frame along the normal, in slices.
struct Slices {
  int count = 1;
  double spacing_mm = 1;
  std::vector<int> of_frame;
};

Slices FindSlices(const DicomSegments& read, const std::string& path) {
  const Vec3 normal_W = glm::cross(read.row_W, read.column_W);
  const Vec3& first_W = read.frames.front().origin_W;
  std::vector<double> heights_mm;
  for (const DicomSegmentFrame& frame : read.frames) {
    const Vec3 off = frame.origin_W - first_W;
    heights_mm.push_back(glm::dot(off, normal_W));
    if (glm::length(off - heights_mm.back() * normal_W) > 0.1 * std::min(read.pixel_mm[0], read.pixel_mm[1])) {
      throw Error(
          fmt::format("{}: the slices of the segmentation are shifted sideways, which kerf doesn't read", path));
    }
  }
  std::vector<double> sorted = heights_mm;
  std::sort(sorted.begin(), sorted.end());
  double least_mm = 0;
  for (std::size_t i = 1; i < sorted.size(); ++i) {
    const double gap_mm = sorted[i] - sorted[i - 1];
    if (gap_mm > kSamePlace_mm && (least_mm == 0 || gap_mm < least_mm)) least_mm = gap_mm;
  }
  Slices slices;
  slices.spacing_mm = read.slice_mm > 0 ? read.slice_mm : least_mm;
  // The stated distance may be the thickness of the slices.
  if (least_mm > 0 && std::abs(std::round(least_mm / slices.spacing_mm) - least_mm / slices.spacing_mm) > kUneven) {
    slices.spacing_mm = least_mm;
  }
  if (!(slices.spacing_mm > 0))
    throw Error(fmt::format("{}: the segmentation has one slice of unknown thickness", path));
  std::set<std::pair<int, int>> taken;
  for (const double height_mm : heights_mm) {
    const double place = (height_mm - sorted.front()) / slices.spacing_mm;
    if (std::abs(place - std::round(place)) > kUneven) {
      throw Error(fmt::format("{}: the slices of the segmentation are not evenly spaced", path));
    }
    if (place > 1e5) throw Error(fmt::format("{}: the slices of the segmentation are too far apart", path));
    slices.of_frame.push_back(static_cast<int>(std::lround(place)));
    slices.count = std::max(slices.count, slices.of_frame.back() + 1);
    const int segment = read.frames[slices.of_frame.size() - 1].segment;
    if (!taken.insert({segment, slices.of_frame.back()}).second) {
      throw Error(fmt::format("{}: two frames of segment {} have the same position", path, segment));
    }
  }
  return slices;
}

Volume MakeLattice(const DicomSegments& read, const Slices& slices, const std::string& path) {
  Volume lattice;
  lattice.size = {read.size[0], read.size[1], slices.count};
  lattice.spacing_mm = {read.pixel_mm[0], read.pixel_mm[1], slices.spacing_mm};
  lattice.axes_W = {read.row_W, read.column_W, glm::cross(read.row_W, read.column_W)};
  const auto lowest = std::min_element(slices.of_frame.begin(), slices.of_frame.end());
  lattice.origin_W = read.frames[static_cast<std::size_t>(lowest - slices.of_frame.begin())].origin_W;
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
    const std::size_t to = static_cast<std::size_t>(slices.of_frame[f]) * pixels;
    for (std::size_t i = 0; i < pixels; ++i) {
      if (read.pixels[f * pixels + i] != 0) visit(to + i);
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

}  // namespace

Segmentation ReadDicomSegmentation(const std::string& path) {
  const DicomSegments read = ReadDicomSegments(path);
  if (read.segments.size() > kMaxSegments) {
    throw Error(
        fmt::format("{}: the file has {} segments; kerf reads up to {}", path, read.segments.size(), kMaxSegments));
  }
  const Slices slices = FindSlices(read, path);
  Segmentation segmentation;
  segmentation.path = path;
  segmentation.lattice = MakeLattice(read, slices, path);
  segmentation.named = true;
  segmentation.series_uid = read.series_uid;
  segmentation.cropped = true;
  for (const DicomSegment& described : read.segments) {
    Segment segment;
    segment.name = described.label.empty() ? fmt::format("Segment {}", described.number)
                                           : FirstCharacters(described.label, kMaxSegmentName);
    segment.category = described.category;
    segment.codes = described.codes;
    segment.modifiers = described.modifiers;
    segment.label = described.number;
    AddToLayers(read, slices, segment, segmentation);
    segmentation.segments.push_back(std::move(segment));
  }
  return segmentation;
}

}  // namespace kerf
