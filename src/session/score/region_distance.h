// How far the tool is from a tissue of the bone, and how deep in it.
#pragma once

#include <array>
#include <vector>

#include "kerf/bone.h"
#include "kerf/tool.h"

namespace kerf {

/// The tissue as balls about the voxels of the region grid, each as large as fits in it: their union is the tissue to
/// half a voxel.
class RegionDistance {
 public:
  RegionDistance(const Bone& bone, Tissue tissue);
  /// Of region ids.
  RegionDistance(const Bone& bone, const std::array<bool, 256>& regions);

  /// The bone has none of it.
  bool empty() const { return balls_.empty(); }
  /// From the tool's body to the tissue, mm; below 0: the tool is in it, so deep at the deepest place. 1e9 when there
  /// is none. Error: half a region voxel. Less than 0.1 ms; safe in any one thread at a time.
  double Calc(const Tool& tool, const Pose& X_WT) const;
  std::size_t ball_count() const { return balls_.size(); }

 private:
  struct Ball {
    Vec3 p_W;
    double radius_mm;
  };
  struct Cluster {
    Vec3 centre_W{0};
    double radius_mm = 0;   // holds its balls' centres
    double largest_mm = 0;  // of its balls
    std::size_t begin = 0;
    std::size_t end = 0;
  };
  void Build(const Bone& bone, const std::array<bool, 256>& regions);

  std::vector<Ball> balls_;
  std::vector<Cluster> clusters_;
  mutable std::vector<std::pair<double, std::size_t>> order_;
};

/// Of a point from the tool's body, tool frame, mm; 0 in it.
double CalcToolDistance(const Tool& tool, const Vec3& p_T);

}  // namespace kerf
