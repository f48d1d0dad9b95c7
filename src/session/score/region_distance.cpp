#include "session/score/region_distance.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <glm/geometric.hpp>
#include <map>
#include <tuple>

#include "bone/grid/interpolate.h"
#include "bone/grid/removed.h"
#include "cut/effects/structure_voxels.h"
#include "cut/tool/shape.h"

namespace kerf {
namespace {

constexpr double kNone_mm = 1e9;
constexpr double kClusterEdge_mm = 2;

using Cell = std::tuple<int, int, int>;

Cell CellOf(const Vec3& p, double edge_mm) {
  return {static_cast<int>(std::floor(p.x / edge_mm)), static_cast<int>(std::floor(p.y / edge_mm)),
          static_cast<int>(std::floor(p.z / edge_mm))};
}

/// Returns the centres of all voxels in the boxes.
std::vector<Vec3> ListVoxels(const std::vector<Box3>& boxes, double h) {
  std::vector<Vec3> points;
  for (const Box3& box : boxes) {
    for (double x = box.lower.x + 0.5 * h; x < box.upper.x; x += h) {
      for (double y = box.lower.y + 0.5 * h; y < box.upper.y; y += h) {
        for (double z = box.lower.z + 0.5 * h; z < box.upper.z; z += h) points.emplace_back(x, y, z);
      }
    }
  }
  return points;
}

/// Computes the distance to the nearest of many points, using a grid of cells.
class NearestPoint {
 public:
  explicit NearestPoint(const std::vector<Vec3>& points) {
    for (const Vec3& p : points) cells_[CellOf(p, kEdge_mm)].push_back(p);
  }
  double Calc(const Vec3& p) const {
    const auto [x, y, z] = CellOf(p, kEdge_mm);
    double best2 = kNone_mm * kNone_mm;
    for (int ring = 0; ring < 1000; ++ring) {
      // All points in further rings are further away than this.
      const double min_mm = (ring - 1) * kEdge_mm;
      if (ring > 0 && best2 <= min_mm * min_mm) break;
      for (int i = -ring; i <= ring; ++i) {
        for (int j = -ring; j <= ring; ++j) {
          const bool face = std::abs(i) == ring || std::abs(j) == ring;
          for (int k = -ring; k <= ring; k += face || ring == 0 ? 1 : 2 * ring) Search({x + i, y + j, z + k}, p, best2);
        }
      }
    }
    return std::sqrt(best2);
  }

 private:
  void Search(const Cell& cell, const Vec3& p, double& best2) const {
    const auto found = cells_.find(cell);
    if (found == cells_.end()) return;
    for (const Vec3& q : found->second) best2 = std::min(best2, glm::dot(p - q, p - q));
  }
  static constexpr double kEdge_mm = 0.8;
  std::map<Cell, std::vector<Vec3>> cells_;
};

}  // namespace

RegionDistance::RegionDistance(const Bone& bone, Tissue tissue) {
  Build(bone, FindRegionsOf(bone, tissue));
}

RegionDistance::RegionDistance(const Bone& bone, const std::array<bool, 256>& regions) {
  Build(bone, regions);
}

void RegionDistance::Build(const Bone& bone, const std::array<bool, 256>& regions) {
  const double h = bone.region_voxel_mm();
  StructureVoxels voxels(h);
  voxels.AddRegions(bone, regions);
  voxels.Finish();
  if (voxels.empty()) return;
  const NearestPoint outside(ListVoxels(voxels.MakeShell(), h));
  std::map<Cell, std::vector<Ball>> cells;
  for (const Vec3& p_W : ListVoxels(voxels.MakeBoxes(), h)) {
    cells[CellOf(p_W, kClusterEdge_mm)].push_back({p_W, outside.Calc(p_W) - 0.5 * h});
  }
  for (const auto& [cell, balls] : cells) {
    Cluster cluster;
    cluster.begin = balls_.size();
    Box3 box;
    for (const Ball& ball : balls) {
      box.Include(ball.p_W);
      cluster.largest_mm = std::max(cluster.largest_mm, ball.radius_mm);
      balls_.push_back(ball);
    }
    cluster.end = balls_.size();
    cluster.centre_W = box.centre();
    cluster.radius_mm = 0.5 * glm::length(box.size());
    clusters_.push_back(cluster);
  }
  order_.reserve(clusters_.size());
}

double RegionDistance::Calc(const Tool& tool, const Pose& X_WT) const {
  return Find(tool, X_WT).distance_mm;
}

double RegionDistance::CalcFrom(std::span<const WantedCut> cuts) const {
  double nearest_mm = kNone_mm;
  for (const WantedCut& cut : cuts) {
    for (const Ball& ball : balls_) nearest_mm = std::min(nearest_mm, cut.CalcDistance(ball.p_W) - ball.radius_mm);
  }
  return nearest_mm;
}

RegionDistance::Nearest RegionDistance::Find(const Tool& tool, const Pose& X_WT) const {
  order_.clear();
  for (std::size_t i = 0; i < clusters_.size(); ++i) {
    const Cluster& c = clusters_[i];
    const double min_mm = CalcPassedDistance(tool, X_WT.InversePoint(c.centre_W)) - c.radius_mm - c.largest_mm;
    order_.emplace_back(min_mm, i);
  }
  std::sort(order_.begin(), order_.end());
  Nearest best{.distance_mm = kNone_mm};
  for (const auto& [min_mm, i] : order_) {
    if (min_mm >= best.distance_mm) break;
    for (std::size_t k = clusters_[i].begin; k < clusters_[i].end; ++k) {
      const Ball& ball = balls_[k];
      const double distance_mm = CalcPassedDistance(tool, X_WT.InversePoint(ball.p_W)) - ball.radius_mm;
      if (distance_mm < best.distance_mm) best = {.distance_mm = distance_mm, .p_W = ball.p_W};
    }
  }
  return best;
}

NearestStructure FindNearestStructure(const RegionDistance* regions, const std::string& regions_name,
                                      const std::vector<MarkTube>& marks, const Tool& tool, const Pose& X_WT) {
  NearestStructure best;
  if (regions != nullptr && !regions->empty()) {
    const RegionDistance::Nearest found = regions->Find(tool, X_WT);
    best = {.name = regions_name, .distance_mm = found.distance_mm, .p_W = found.p_W};
  }
  for (const MarkTube& mark : marks) {
    if (mark.empty()) continue;
    const MarkTube::Nearest found = mark.Find(tool, X_WT);
    if (best.distance_mm && found.distance_mm >= *best.distance_mm) continue;
    best = {.name = mark.name(), .distance_mm = found.distance_mm, .p_W = found.p_W};
  }
  return best;
}

}  // namespace kerf
