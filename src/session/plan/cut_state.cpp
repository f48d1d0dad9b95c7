#include "session/plan/cut_state.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "bone/grid/removed.h"
#include "kerf/error.h"
#include "session/plan/edit_plane.h"

namespace kerf {
namespace {

constexpr int kMaxSamples = 2048;  // along either side

/// Returns true if bone was removed on the line from p along the unit direction, not further away than `reach_mm`.
bool FindCut(const PhiSampler& before, const PhiSampler& now, const Vec3& p, const Vec3& direction, double reach_mm) {
  // |phi| is at most the distance to the surface, up to its own error, so that shorter steps cannot jump over a kerf.
  const double min_step_mm = 0.2 * now.voxel_mm();
  double s = 0;
  while (true) {
    const Vec3 q = p + s * direction;
    if (before.Calc(q) >= 0) return false;
    const double phi = now.Calc(q);
    if (phi >= 0) return true;
    if (s >= reach_mm) return false;
    s = std::min(reach_mm, s + std::max(min_step_mm, -0.5 * phi));
  }
}

struct SampleGrid {
  int columns = 0;
  int rows = 0;
  std::vector<std::uint8_t> left;  // 1: bone that is not cut

  std::size_t Index(int i, int j) const {
    return static_cast<std::size_t>(j) * static_cast<std::size_t>(columns) + static_cast<std::size_t>(i);
  }
};

/// Labels the connected sets of left samples with 1, 2, ... and returns their number.
int LabelBridges(const SampleGrid& grid, std::vector<int>& labels) {
  labels.assign(grid.left.size(), 0);
  int count = 0;
  std::vector<std::pair<int, int>> open;
  for (int j = 0; j < grid.rows; ++j) {
    for (int i = 0; i < grid.columns; ++i) {
      if (grid.left[grid.Index(i, j)] == 0 || labels[grid.Index(i, j)] != 0) continue;
      ++count;
      const auto visit = [&](int x, int y) {
        if (x < 0 || y < 0 || x >= grid.columns || y >= grid.rows) return;
        const std::size_t at = grid.Index(x, y);
        if (grid.left[at] == 0 || labels[at] != 0) return;
        labels[at] = count;
        open.emplace_back(x, y);
      };
      visit(i, j);
      while (!open.empty()) {
        const auto [x, y] = open.back();
        open.pop_back();
        visit(x + 1, y);
        visit(x - 1, y);
        visit(x, y + 1);
        visit(x, y - 1);
      }
    }
  }
  return count;
}

}  // namespace

CutState CalcCutState(const Bone& before, const Bone& now, const PlannedPlane& plane, const CutStateOptions& options) {
  if (std::abs(now.voxel_mm() - before.voxel_mm()) > 1e-9 * before.voxel_mm()) {
    throw Error(
        fmt::format("the bone before the cut has voxels of {} mm, the bone now {} mm; both must be the same bone",
                    before.voxel_mm(), now.voxel_mm()));
  }
  if (!(options.step_mm > 0) || !(options.min_bridge_mm2 >= 0)) {
    throw Error("the step of the samples in a plane must be above 0, and the smallest bridge must not be below 0");
  }
  const auto samples = [&](double size_mm) {
    return std::clamp(static_cast<int>(std::ceil(size_mm / options.step_mm - 1e-9)), 1, kMaxSamples);
  };
  SampleGrid grid{.columns = samples(plane.width_mm), .rows = samples(plane.height_mm), .left = {}};
  grid.left.assign(static_cast<std::size_t>(grid.columns) * static_cast<std::size_t>(grid.rows), 0);
  const PlaneAxes axes = CalcPlaneAxes(plane);
  const Vec3 corner_W = CalcPlaneCorners(plane)[0];
  const Vec3 across_W = plane.width_mm / grid.columns * axes.across_W;
  const Vec3 up_W = plane.height_mm / grid.rows * axes.up_W;
  const double area_mm2 = glm::length(across_W) * glm::length(up_W);
  const PhiSampler phi_before(before);
  const PhiSampler phi_now(now);
  CutState state;
  for (int j = 0; j < grid.rows; ++j) {
    for (int i = 0; i < grid.columns; ++i) {
      const Vec3 p = corner_W + (i + 0.5) * across_W + (j + 0.5) * up_W;
      if (phi_before.Calc(p) >= 0) continue;
      state.before_mm2 += area_mm2;
      if (FindCut(phi_before, phi_now, p, axes.normal_W, plane.margin_mm) ||
          FindCut(phi_before, phi_now, p, -axes.normal_W, plane.margin_mm)) {
        continue;
      }
      state.left_mm2 += area_mm2;
      grid.left[grid.Index(i, j)] = 1;
    }
  }

  std::vector<int> labels;
  state.bridges.resize(static_cast<std::size_t>(LabelBridges(grid, labels)));
  for (int j = 0; j < grid.rows; ++j) {
    for (int i = 0; i < grid.columns; ++i) {
      const int label = labels[grid.Index(i, j)];
      if (label == 0) continue;
      Bridge& bridge = state.bridges[static_cast<std::size_t>(label - 1)];
      bridge.area_mm2 += area_mm2;
      bridge.centre_W += corner_W + (i + 0.5) * across_W + (j + 0.5) * up_W;
      int end = i + 1;
      if (i > 0 && labels[grid.Index(i - 1, j)] == label) continue;  // in the run of an earlier sample
      while (end < grid.columns && labels[grid.Index(end, j)] == label) ++end;
      const Vec3 lower = corner_W + static_cast<double>(j) * up_W;
      const Vec3 a = lower + static_cast<double>(i) * across_W;
      const Vec3 b = lower + static_cast<double>(end) * across_W;
      bridge.patches.push_back({a, b, b + up_W, a + up_W});
      for (const Vec3& p : bridge.patches.back()) bridge.extent_W.Include(p);
    }
  }
  for (Bridge& bridge : state.bridges) bridge.centre_W /= std::round(bridge.area_mm2 / area_mm2);
  std::erase_if(state.bridges, [&](const Bridge& b) { return b.area_mm2 < options.min_bridge_mm2; });
  std::stable_sort(state.bridges.begin(), state.bridges.end(),
                   [](const Bridge& a, const Bridge& b) { return a.area_mm2 > b.area_mm2; });
  return state;
}

}  // namespace kerf
