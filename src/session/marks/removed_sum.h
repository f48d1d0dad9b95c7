// Volume that was removed from one structure, and its place.
#pragma once

#include "bone/grid/removed.h"
#include "session/marks/mark_tube.h"
#include "session/marks/region_parts.h"
#include "session/marks/structures.h"

namespace kerf {

class RemovedSum {
 public:
  void Add(double mm3, const Vec3& p_W) {
    mm3_ += mm3;
    moment_ += mm3 * p_W;
  }
  void Add(const RemovedCell& cell) { Add(cell.mm3, cell.p_W); }
  void Add(const RemovedSum& other) {
    mm3_ += other.mm3_;
    moment_ += other.moment_;
  }
  bool is_empty() const { return mm3_ == 0; }
  bool is_injury(double voxel_mm) const { return mm3_ > kMinInjury_vox * voxel_mm * voxel_mm * voxel_mm; }
  /// Sets the removed volume and, if it is an injury, that the structure is cut at its centre.
  void Fill(double voxel_mm, StructureResult& result) const {
    result.removed_mm3 = mm3_;
    result.is_cut = is_injury(voxel_mm);
    if (!result.is_cut) return;
    result.distance_mm = 0;
    result.p_W = moment_ / mm3_;
  }

 private:
  double mm3_ = 0;
  Vec3 moment_{0};
};

/// Returns name, kind, side and size of a mark.
StructureResult DescribeMark(const Mark& mark, const MarkTube& tube, double mid_x_mm);

}  // namespace kerf
