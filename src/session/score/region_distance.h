// Distance of the tool from a tissue of the bone, or its depth in it.
#pragma once

#include <array>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "kerf/bone.h"
#include "kerf/tool.h"
#include "session/marks/mark_tube.h"
#include "session/scene/exercise.h"

namespace kerf {

/// Represents the tissue by balls centred at the voxels of the region grid, each as large as fits into the tissue.
/// Their union equals the tissue to within half a voxel.
class RegionDistance {
 public:
  RegionDistance(const Bone& bone, Tissue tissue);
  /// `regions`: flags by region id.
  RegionDistance(const Bone& bone, const std::array<bool, 256>& regions);

  /// Returns true if the bone has no such tissue.
  bool empty() const { return balls_.empty(); }
  /// Returns the distance from the tool's body to the tissue, mm. Negative if the tool is in the tissue: minus its
  /// maximum depth there. Returns 1e9 if there is no tissue. Error: half a region voxel. Takes less than 0.1 ms. Not
  /// thread-safe: use in one thread at a time.
  double Calc(const Tool& tool, const Pose& X_WT) const;

  /// Returns the distance from what the cuts remove to the tissue, mm; at most 0 if they cross it. Returns 1e9 if there
  /// is no tissue. Error: half a region voxel. Takes about 10 ms.
  double CalcFrom(std::span<const WantedCut> cuts) const;

  /// The same distance, and the place in the tissue to which it refers: the centre of the ball, world frame.
  struct Nearest {
    double distance_mm = 0;
    Vec3 p_W{0};
  };
  Nearest Find(const Tool& tool, const Pose& X_WT) const;

 private:
  struct Ball {
    Vec3 p_W;
    double radius_mm;
  };
  struct Cluster {
    Vec3 centre_W{0};
    double radius_mm = 0;   // encloses the centres of its balls
    double largest_mm = 0;  // maximum radius of its balls
    std::size_t begin = 0;
    std::size_t end = 0;
  };
  void Build(const Bone& bone, const std::array<bool, 256>& regions);

  std::vector<Ball> balls_;
  std::vector<Cluster> clusters_;
  mutable std::vector<std::pair<double, std::size_t>> order_;
};

/// The structure that is nearest to the tool, among tissues of the bone and the user's marks.
struct NearestStructure {
  std::string name;                   // of the mark, or the given name of the tissue
  std::optional<double> distance_mm;  // at most 0 if the tool is in it; none: nothing is marked
  Vec3 p_W{0};                        // the structure's place, on the axis of a mark or in the tissue; world frame
};
/// `regions` may be null or empty. Errors: half a region voxel for the tissue, MarkTube::Find() for marks. Takes less
/// than 0.1 ms for the tissue and for each mark.
NearestStructure FindNearestStructure(const RegionDistance* regions, const std::string& regions_name,
                                      const std::vector<MarkTube>& marks, const Tool& tool, const Pose& X_WT);

}  // namespace kerf
