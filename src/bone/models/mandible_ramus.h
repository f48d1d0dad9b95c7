// The ramus with its coronoid and condylar processes: an outline in the side view, with a thickness along a curved
// middle surface.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "bone/models/mandible_layout.h"

namespace kerf {

class MandibleRamus {
 public:
  explicit MandibleRamus(const MandibleLayout& layout);

  /// Returns the distance to the ramus of the left half (x >= 0). If the distance exceeds `limit`, any value larger
  /// than `limit` may be returned.
  double Distance(const Vec3& p_W, double limit) const;
  double HalfThickness(const Vec2& uv) const;
  /// Centre of the condyle, world frame.
  const Vec3& condyle() const { return condyle_; }

 private:
  double PlateDistance(const Vec3& p_W, double limit) const;
  double CondyleDistance(const Vec3& p_W, double limit) const;
  double OutlineDistance(const Vec2& uv) const;  // in the side view

  const MandibleLayout* layout_;
  std::uint64_t id_;  // of the plate as a function of (y, z)
  Vec3 condyle_{0};
  Vec3 condyle_radii_{1};
  Vec3 condyle_axis_{1, 0, 0}, condyle_front_{0, -1, 0}, condyle_up_{0, 0, 1};
  std::array<RoundedCone<Vec3>, 2> neck_;
  Box3 box_, condyle_box_;
  double v_notch_ = 0;
  // Distance to the outline on a grid in (u, v).
  Vec2 origin_{-18, -40};
  double step_ = 0.5;
  int count_u_ = 0, count_v_ = 0;
  std::vector<float> outline_;
};

}  // namespace kerf
