// Distance of the tool from a mark.
#pragma once

#include <string>
#include <vector>

#include "kerf/tool.h"
#include "session/marks/mark.h"

namespace kerf {

/// The tube of a mark: everything within its radius of its curve. Reading is thread-safe.
class MarkTube {
 public:
  explicit MarkTube(const Mark& mark);

  const std::string& name() const { return name_; }
  MarkKind kind() const { return kind_; }
  double radius_mm() const { return radius_mm_; }
  const std::vector<Vec3>& curve_W() const { return curve_W_; }  // the polyline of CalcCurve()
  bool empty() const { return curve_W_.empty(); }                // the mark has no points

  struct Nearest {
    double distance_mm = 0;
    Vec3 p_W{0};  // on the curve, world frame
  };
  /// Returns the distance between the tool's body (a flat cylinder or a ball, without the spindle) and the tube, and
  /// the curve's point nearest to the tool. If the tool reaches the tube, the distance is 0 or negative, at least minus
  /// the radius, which means that the curve is reached. Error: kCurveError_mm of the curve; the search itself adds less
  /// than 1e-4 mm. Takes some microseconds for a curve of 100 mm. 1e9 if the mark is empty.
  Nearest Find(const Tool& tool, const Pose& X_WT) const;
  /// Returns the same for a point in place of the tool.
  Nearest Find(const Vec3& p_W) const;

 private:
  std::string name_;
  MarkKind kind_;
  double radius_mm_;
  std::vector<Vec3> curve_W_;
};

std::vector<MarkTube> MakeMarkTubes(const std::vector<Mark>& marks);

}  // namespace kerf
