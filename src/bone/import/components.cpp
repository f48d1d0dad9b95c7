#include "bone/import/components.h"

#include <fmt/format.h>

#include <algorithm>
#include <glm/common.hpp>
#include <numeric>

namespace kerf {

namespace {

constexpr std::int32_t kUnseen = -1;
constexpr std::size_t kBetweenReports = std::size_t{1} << 20;  // voxels

// Returns half the extent of a voxel along the patient's axes.
Vec3 CalcHalfVoxel(const Volume& lattice) {
  Vec3 half(0);
  for (int a = 0; a < 3; ++a) half += 0.5 * lattice.spacing_mm[a] * glm::abs(lattice.axes_W[a]);
  return half;
}

// Returns whether an axis of the lattice is not along one of the patient's axes.
bool IsOblique(const Volume& lattice) {
  for (int a = 0; a < 3; ++a) {
    const Vec3 axis = glm::abs(lattice.axes_W[a]);
    if (axis.x + axis.y + axis.z > std::max({axis.x, axis.y, axis.z})) return true;
  }
  return false;
}

}  // namespace

Components FindComponents(const Volume& lattice, const std::function<bool(std::size_t)>& inside,
                          const std::function<void(double)>& progress) {
  Components result;
  result.labels.assign(lattice.count(), 0);
  std::size_t done = 0;
  const auto report = [&] {
    if (progress && ++done % kBetweenReports == 0) {
      progress(std::min(1.0, static_cast<double>(done) / (3.0 * static_cast<double>(lattice.count()))));
    }
  };
  for (std::size_t v = 0; v < result.labels.size(); ++v) {
    report();
    if (inside(v)) result.labels[v] = kUnseen;
  }
  const std::array<int, 3> n = lattice.size;
  const std::array<std::size_t, 3> stride = {1, static_cast<std::size_t>(n[0]), static_cast<std::size_t>(n[0]) * n[1]};
  const bool oblique = IsOblique(lattice);
  std::vector<std::size_t> open;
  for (std::size_t start = 0; start < result.labels.size(); ++start) {
    report();
    if (result.labels[start] != kUnseen) continue;
    const auto label = static_cast<std::int32_t>(result.list.size() + 1);
    Component c;
    c.lower = n;
    c.upper = {-1, -1, -1};
    Vec3 sum{0};
    result.labels[start] = label;
    open.push_back(start);
    while (!open.empty()) {
      report();
      const std::size_t v = open.back();
      open.pop_back();
      const std::array<int, 3> at = {static_cast<int>(v % stride[1]), static_cast<int>(v / stride[1] % n[1]),
                                     static_cast<int>(v / stride[2])};
      ++c.voxels;
      if (oblique) c.box_W.Include(lattice.WorldFromVoxel({at[0], at[1], at[2]}));
      for (int a = 0; a < 3; ++a) {
        sum[a] += at[a];
        c.lower[a] = std::min(c.lower[a], at[a]);
        c.upper[a] = std::max(c.upper[a], at[a]);
        if (at[a] > 0 && result.labels[v - stride[a]] == kUnseen) {
          result.labels[v - stride[a]] = label;
          open.push_back(v - stride[a]);
        }
        if (at[a] + 1 < n[a] && result.labels[v + stride[a]] == kUnseen) {
          result.labels[v + stride[a]] = label;
          open.push_back(v + stride[a]);
        }
      }
    }
    c.volume_mm3 = static_cast<double>(c.voxels) * lattice.CalcVoxelVolume();
    c.centre_W = lattice.WorldFromVoxel(sum / static_cast<double>(c.voxels));
    for (int corner = 0; corner < 8 && !oblique; ++corner) {
      Vec3 p_V;
      for (int a = 0; a < 3; ++a) p_V[a] = ((corner >> a) & 1) != 0 ? c.upper[a] + 0.5 : c.lower[a] - 0.5;
      c.box_W.Include(lattice.WorldFromVoxel(p_V));
    }
    if (oblique) c.box_W = {c.box_W.lower - CalcHalfVoxel(lattice), c.box_W.upper + CalcHalfVoxel(lattice)};
    result.list.push_back(c);
  }
  // Largest first; equal ones in the order of the lattice, so that the result is deterministic.
  std::vector<std::int32_t> order(result.list.size());
  std::iota(order.begin(), order.end(), 0);
  std::stable_sort(order.begin(), order.end(),
                   [&](std::int32_t a, std::int32_t b) { return result.list[a].voxels > result.list[b].voxels; });
  std::vector<std::int32_t> renamed(result.list.size() + 1, 0);
  std::vector<Component> sorted;
  sorted.reserve(order.size());
  for (const std::int32_t old : order) {
    sorted.push_back(result.list[old]);
    renamed[old + 1] = static_cast<std::int32_t>(sorted.size());
  }
  result.list = std::move(sorted);
  for (std::int32_t& label : result.labels) label = renamed[label];
  return result;
}

std::string Describe(const Component& c) {
  const Vec3 size = c.box_W.size();
  return fmt::format("{:.1f} cm3, centre ({:.0f}, {:.0f}, {:.0f}), box {:.0f} x {:.0f} x {:.0f} mm",
                     c.volume_mm3 / 1000, c.centre_W.x, c.centre_W.y, c.centre_W.z, size.x, size.y, size.z);
}

}  // namespace kerf
