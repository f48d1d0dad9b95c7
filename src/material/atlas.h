// Which of the 31 cortical regions a point of a mandible belongs to.
#pragma once

#include <vector>

#include "kerf/geometry.h"

namespace kerf {


/// Cells of the cortex in the mandible's own coordinates: along the arch (symphysis to condyle), up, and facial or lingual. The
/// cells and numbers are kerf's own, since the published site map was not to be had; regions 24, 21, 13 and 6 lie under one another
/// where a cut through the body meets them in the paper's order (docs/materials.md).
class MandibleAtlas {
 public:
  /// `points_W`: at least 100 points spread over the bone's surface or volume, LPS mm. Throws Error when there are fewer.
  explicit MandibleAtlas(const std::vector<Vec3>& points_W);
  /// Region id 1 to 31 of the cortex nearest to a point. Thread-safe.
  int RegionAt(const Vec3& p_W) const;

 private:
  struct Frame {
    Vec3 centre_W{0};  // of the arch
    // filled by the constructor; see atlas.cpp
    std::vector<double> values;
  };
  Frame frame_;
};

}  // namespace kerf
