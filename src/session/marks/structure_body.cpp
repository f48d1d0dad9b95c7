#include "session/marks/structure_body.h"

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <iterator>
#include <utility>

#include "session/marks/segment.h"

namespace kerf {
namespace {

constexpr double kEnd_mm = 1;          // length of an end
constexpr double kEndFraction = 0.25;  // of the structure's length, at most

}  // namespace

StructureBody::StructureBody(const Bone& before, const RegionParts& parts, int part) : h_(before.voxel_mm()) {
  const double r = parts.voxel_mm();
  Box3 box_W;
  for (const RegionParts::Run& run : parts.runs()) {
    if (run.part != part) continue;
    box_W.Include(parts.PointOf(run, run.z0) - Vec3(0.5 * r));
    box_W.Include(parts.PointOf(run, run.z1) + Vec3(0.5 * r));
  }
  if (!Allocate(box_W)) return;
  const PhiSampler phi(before);
  // The voxels of phi's grid whose centres are in voxels `a` to `b` of the region grid.
  const auto first = [&](int a) { return static_cast<int>(std::ceil((a - 0.5) * r / h_ - 1e-9)); };
  for (const RegionParts::Run& run : parts.runs()) {
    if (run.part != part) continue;
    for (int x = first(run.x); x < first(run.x + 1); ++x) {
      for (int y = first(run.y); y < first(run.y + 1); ++y) {
        for (int z = first(run.z0); z < first(run.z1 + 1); ++z) Set(phi, {x, y, z});
      }
    }
  }
  FindEnds();
}

StructureBody::StructureBody(const Bone& before, const MarkTube& tube) : h_(before.voxel_mm()) {
  if (tube.empty()) return;
  const Vec3 r(tube.radius_mm());
  Box3 box_W;
  for (const Vec3& p : tube.curve_W()) box_W.Include(p);
  if (!Allocate({box_W.lower - r, box_W.upper + r})) return;
  const PhiSampler phi(before);
  for (std::size_t i = 0; i < tube.curve_W().size(); ++i) {
    const Vec3& a = tube.curve_W()[i > 0 ? i - 1 : 0];
    const Vec3& b = tube.curve_W()[i];
    const Vec3 lower = glm::ceil((glm::min(a, b) - r) / h_);
    const Vec3 upper = glm::floor((glm::max(a, b) + r) / h_);
    for (int x = static_cast<int>(lower.x); x <= static_cast<int>(upper.x); ++x) {
      for (int y = static_cast<int>(lower.y); y <= static_cast<int>(upper.y); ++y) {
        for (int z = static_cast<int>(lower.z); z <= static_cast<int>(upper.z); ++z) {
          if (CalcSegmentDistance(h_ * Vec3(x, y, z), a, b) <= tube.radius_mm()) Set(phi, {x, y, z});
        }
      }
    }
  }
  FindEnds();
}

/// Returns false if the box is empty or too large.
bool StructureBody::Allocate(const Box3& box_W) {
  if (box_W.empty()) return false;
  std::size_t count = 1;
  for (int axis = 0; axis < 3; ++axis) {
    const auto i = static_cast<std::size_t>(axis);
    lower_[i] = static_cast<int>(std::floor(box_W.lower[axis] / h_)) - 1;
    size_[i] = static_cast<int>(std::ceil(box_W.upper[axis] / h_)) + 2 - lower_[i];
    count *= static_cast<std::size_t>(size_[i]);
    if (count > kMaxVoxels) return false;
  }
  inside_.assign(count, false);
  second_end_.assign(count, false);
  return true;
}

/// Adds a voxel if it is bone.
void StructureBody::Set(const PhiSampler& before, const Index& voxel) {
  std::size_t i = 0;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    i = i * static_cast<std::size_t>(size_[axis]) + static_cast<std::size_t>(voxel[axis] - lower_[axis]);
  }
  if (!inside_[i] && before.Calc(PointOf(i)) < 0) inside_[i] = true;
}

Vec3 StructureBody::PointOf(std::size_t i) const {
  const auto sy = static_cast<std::size_t>(size_[1]);
  const auto sz = static_cast<std::size_t>(size_[2]);
  return h_ * Vec3(lower_[0] + static_cast<int>(i / (sy * sz)), lower_[1] + static_cast<int>(i / sz % sy),
                   lower_[2] + static_cast<int>(i % sz));
}

template <typename Enter, typename Visit>
void StructureBody::Flood(std::vector<std::size_t> from, std::vector<bool>& seen, Enter&& enter, Visit&& visit) const {
  const std::size_t sz = 1;
  const auto sy = static_cast<std::size_t>(size_[2]);
  const std::size_t sx = sy * static_cast<std::size_t>(size_[1]);
  for (const std::size_t i : from) seen[i] = true;
  // Only the voxels of one step are kept: a structure has millions.
  std::vector<std::size_t> reached = std::move(from), further;
  for (int steps = 0; !reached.empty(); ++steps) {
    further.clear();
    for (const std::size_t i : reached) {
      visit(i, steps);
      for (const std::size_t next : {i - sx, i + sx, i - sy, i + sy, i - sz, i + sz}) {
        if (!inside_[next] || seen[next]) continue;
        seen[next] = true;
        if (enter(next)) further.push_back(next);
      }
    }
    reached.swap(further);
  }
}

void StructureBody::FindEnds() {
  const auto any = [](std::size_t) { return true; };
  std::vector<bool> seen(inside_.size(), false);
  std::size_t largest = 0;  // voxels in a part
  std::size_t last_of_largest = 0;
  for (std::size_t i = 0; i < inside_.size(); ++i) {
    if (!inside_[i] || seen[i]) continue;
    std::size_t count = 0;
    std::size_t last = i;
    Flood({i}, seen, any, [&](std::size_t voxel, int) {
      ++count;
      last = voxel;
    });
    if (count <= largest) continue;
    largest = count;
    last_of_largest = last;
  }
  if (largest == 0) return;
  // The voxel that is furthest from any one is an end, and the one that is furthest from that is the other.
  struct Reached {
    std::size_t voxel;
    int steps;
  };
  Reached furthest{};
  const auto flood_from = [&](std::size_t first) {
    std::vector<Reached> near;
    seen.assign(inside_.size(), false);
    Flood({first}, seen, any, [&](std::size_t voxel, int steps) {
      furthest = {voxel, steps};
      if (steps <= kEnd_mm / h_) near.push_back(furthest);
    });
    return near;
  };
  const std::vector<Reached> near_first = flood_from(last_of_largest);
  const double end = kEndFraction * furthest.steps;
  for (const Reached& reached : near_first) {
    if (reached.steps <= end) first_end_.push_back(reached.voxel);
  }
  for (const Reached& reached : flood_from(furthest.voxel)) {
    if (reached.steps <= end) second_end_[reached.voxel] = true;
  }
}

bool StructureBody::IsSevered(const Bone& after) const {
  if (first_end_.empty()) return false;
  const PhiSampler phi(after);
  const auto is_bone = [&](std::size_t i) { return phi.Calc(PointOf(i)) < 0; };
  std::vector<std::size_t> from;
  std::copy_if(first_end_.begin(), first_end_.end(), std::back_inserter(from), is_bone);
  std::vector<bool> seen(inside_.size(), false);
  bool is_connected = false;
  Flood(std::move(from), seen, is_bone,
        [&](std::size_t voxel, int) { is_connected = is_connected || second_end_[voxel]; });
  return !is_connected;
}

}  // namespace kerf
