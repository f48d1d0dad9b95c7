#include "bone/import/padding.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <limits>
#include <map>
#include <utility>
#include <vector>

namespace kerf {

namespace {

constexpr std::int16_t kAir = -1024;
constexpr int kBelowAir = -1200;      // no tissue, and few artefacts
constexpr int kNoScale = -16000;      // nor air in a CT of another scale
constexpr int kBelowAll = -4000;      // no artefact either
constexpr int kMinBright = 1000;      // no soft tissue; bone does not fill edges with one value
constexpr double kMinEdge = 0.9;      // fraction of an edge's voxels
constexpr std::size_t kMinEdges = 3;  // of the four along an axis

void ClearVoxel(std::size_t v, Volume& volume) {
  volume.hu[v] = kAir;
  if (volume.padding.empty()) volume.padding.resize(volume.hu.size());
  volume.padding[v] = true;
}

// Makes values below `limit` air, and returns their number.
std::size_t RaiseBelow(int limit, Volume& volume) {
  std::size_t count = 0;
  for (std::size_t v = 0; v < volume.hu.size(); ++v) {
    if (volume.hu[v] >= limit) continue;
    ClearVoxel(v, volume);
    ++count;
  }
  return count;
}

// Returns the value that fills at least three of the scan's edges along an axis; the lowest value if none does.
std::int16_t FindEdgeValue(const Volume& volume, std::size_t axis) {
  const std::size_t a = (axis + 1) % 3;
  const std::size_t b = (axis + 2) % 3;
  std::map<std::int16_t, std::size_t> edges;  // by the value that fills them
  for (int corner = 0; corner < 4; ++corner) {
    std::array<int, 3> at{};
    at[a] = (corner & 1) * (volume.size[a] - 1);
    at[b] = (corner >> 1) * (volume.size[b] - 1);
    std::map<std::int16_t, int> counts;
    for (at[axis] = 0; at[axis] < volume.size[axis]; ++at[axis]) {
      const std::int16_t value = volume.hu[volume.Index(at[0], at[1], at[2])];
      if (++counts[value] >= kMinEdge * volume.size[axis]) {
        ++edges[value];
        break;
      }
    }
  }
  for (const auto& [value, count] : edges) {
    if (count >= kMinEdges) return value;
  }
  return std::numeric_limits<std::int16_t>::min();
}

// Makes a value air where it reaches inwards along `axis` from the scan's faces, and returns the number of voxels.
// `padding`: of each voxel, whether it is such; kept apart, so that the other axes still see the value.
void MarkInwards(const Volume& volume, std::size_t axis, std::int16_t value, std::vector<bool>& padding) {
  const std::size_t a = (axis + 1) % 3;
  const std::size_t b = (axis + 2) % 3;
  std::array<int, 3> at{};
  for (at[a] = 0; at[a] < volume.size[a]; ++at[a]) {
    for (at[b] = 0; at[b] < volume.size[b]; ++at[b]) {
      for (const bool upwards : {true, false}) {
        const int n = volume.size[axis];
        for (int step = 0; step < n; ++step) {
          at[axis] = upwards ? step : n - 1 - step;
          const std::size_t v = volume.Index(at[0], at[1], at[2]);
          if (volume.hu[v] != value) break;
          padding[v] = true;
        }
      }
    }
  }
}

// Makes a bright value that fills edges air, and returns the number of voxels and the value.
std::pair<std::size_t, std::int16_t> ClearBright(Volume& volume) {
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const std::int16_t value = FindEdgeValue(volume, axis);
    if (value < kMinBright) continue;
    // Air, in a CT whose values are no HU, is darker than the rest.
    const auto above = std::count_if(volume.hu.begin(), volume.hu.end(), [value](auto hu) { return hu > value; });
    const auto below = std::count_if(volume.hu.begin(), volume.hu.end(), [value](auto hu) { return hu < value; });
    if (above >= below) continue;
    std::vector<bool> padding(volume.hu.size(), false);
    MarkInwards(volume, (axis + 1) % 3, value, padding);
    MarkInwards(volume, (axis + 2) % 3, value, padding);
    std::size_t count = 0;
    for (std::size_t v = 0; v < padding.size(); ++v) {
      if (!padding[v]) continue;
      ClearVoxel(v, volume);
      ++count;
    }
    return {count, value};
  }
  return {0, 0};
}

void WarnOfPadding(std::size_t count, const std::string& what, Volume& volume) {
  volume.warnings.push_back(fmt::format("{} voxels ({:.2g} %) {} are padding around the scan and were taken as air",
                                        count, 100 * static_cast<double>(count) / static_cast<double>(volume.count()),
                                        what));
}

// Gives single voxels beyond any HU, whose neighbours are not even metal, the value of a neighbour.
void ClearSpikes(Volume& volume) {
  constexpr int kBeyond = 20000, kMetal = 4000;
  const std::array<std::size_t, 3> stride = {1, static_cast<std::size_t>(volume.size[0]),
                                             static_cast<std::size_t>(volume.size[0]) * volume.size[1]};
  std::vector<std::pair<std::size_t, std::int16_t>> spikes;
  for (std::size_t v = 0; v < volume.hu.size(); ++v) {
    if (volume.hu[v] < kBeyond) continue;
    std::vector<std::int16_t> beside;
    for (const std::size_t s : stride) {
      if (v >= s) beside.push_back(volume.hu[v - s]);
      if (v + s < volume.hu.size()) beside.push_back(volume.hu[v + s]);
    }
    if (beside.empty() || *std::max_element(beside.begin(), beside.end()) >= kMetal) continue;
    const auto middle = beside.begin() + static_cast<std::ptrdiff_t>(beside.size() / 2);
    std::nth_element(beside.begin(), middle, beside.end());
    spikes.emplace_back(v, *middle);
  }
  for (const auto& [v, hu] : spikes) volume.hu[v] = hu;
  if (spikes.empty()) return;
  volume.warnings.push_back(
      fmt::format("{} single voxels have values from {} HU, beyond any tissue or metal, and got that of a neighbour",
                  spikes.size(), kBeyond));
}

}  // namespace

std::size_t ClearPadding(Volume& volume) {
  if (volume.hu.empty()) return 0;
  ClearSpikes(volume);
  const std::int16_t lowest = *std::min_element(volume.hu.begin(), volume.hu.end());
  std::size_t cleared = 0;
  if (lowest < kBelowAir) {
    const auto lowest_count = static_cast<std::size_t>(std::count(volume.hu.begin(), volume.hu.end(), lowest));
    // Without air above it, the value may be that of air itself in a CT whose values are no HU.
    const auto air_count = static_cast<std::size_t>(std::count_if(
        volume.hu.begin(), volume.hu.end(), [](std::int16_t hu) { return hu >= kBelowAir && hu < kAir + 300; }));
    const bool fills =
        1000 * lowest_count >= volume.hu.size() && (lowest < kNoScale || 200 * air_count >= volume.hu.size());
    const int limit = fills ? kBelowAir : kBelowAll;
    if (const std::size_t count = RaiseBelow(limit, volume); count > 0) {
      WarnOfPadding(count, fmt::format("with values from {} HU, far below air,", lowest), volume);
      cleared += count;
    }
  }
  if (const auto [count, value] = ClearBright(volume); count > 0) {
    WarnOfPadding(count, fmt::format("with the value {} HU", value), volume);
    cleared += count;
  }
  return cleared;
}

}  // namespace kerf
