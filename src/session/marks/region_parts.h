// Canals, teeth and lesions of a bone's regions, each as a part of the region grid.
#pragma once

#include <array>
#include <cstddef>
#include <map>
#include <utility>
#include <vector>

#include "bone/grid/removed.h"
#include "kerf/bone.h"
#include "session/marks/structures.h"

namespace kerf {

/// Voxels of the region grid as runs along z, divided into parts: canals by the patient's middle, teeth where they do
/// not touch or have numbers. See AssessStructures().
class RegionParts {
 public:
  struct Run {
    int x = 0;
    int y = 0;
    int z0 = 0;
    int z1 = 0;
    int part = 0;
  };

  /// `tissue`: kTooth, kCanal or kLesion.
  RegionParts(const Bone& bone, Tissue tissue, double mid_x_mm);

  const std::vector<Run>& runs() const { return runs_; }
  double voxel_mm() const { return h_; }
  Vec3 PointOf(const Run& run, int z) const { return h_ * Vec3(run.x, run.y, z); }
  /// Returns the part of the voxel that contains the point; -1 if there is none.
  int FindPart(const Vec3& p_W) const;
  /// Returns kind, side, number and size of each part; the size is 0 if there is no such canal.
  const std::vector<StructureResult>& structures() const { return structures_; }

 private:
  void AddRuns(const Bone& bone, const std::array<bool, 256>& regions, int part);
  int LabelConnected();
  int DivideTeeth();

  double h_;
  std::vector<Run> runs_;
  std::map<std::pair<int, int>, std::vector<std::size_t>> columns_;
  std::vector<StructureResult> structures_;
};

/// Returns the part from which a cell's bone was removed; -1 if it was none. At the surface, where the place is in a
/// voxel outside of the bone, it is that of the nearest voxel around it. `regions`: of the parts' tissue.
int FindPartOf(const RemovedCell& cell, const Bone& before, const RegionParts& parts,
               const std::array<bool, 256>& regions);

/// Returns the side of a structure of which `left` of `size` is on the patient's left.
BodySide CalcSide(double size, double left);

}  // namespace kerf
