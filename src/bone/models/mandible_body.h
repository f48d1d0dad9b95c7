// The body of the mandible: a cross-section swept along the arch, from chin to angle.
#pragma once

#include <array>
#include <vector>

#include "bone/models/mandible_layout.h"

namespace kerf {

/// A vertical section across the body. `t` below: 0 at the lower border, 1 at the crest.
struct BodySection {
  double base_z = 0;
  double crest_z = 0;
  std::array<double, 4> middle{};      // offset of the middle of the width at kBodyLevels, mm, facial positive
  std::array<double, 4> half_width{};  // at the same levels, mm
  double scale = 1;                    // factor for the distance found in this section, so that it is at most the true
                                       // distance

  double Middle(double t) const;
  double HalfWidth(double t) const;
};

/// Levels t at which a section is defined; between them `middle` and `half_width` are cubic in t.
inline constexpr std::array<double, 4> kBodyLevels = {0, 0.34, 0.7, 1};

class MandibleBody {
 public:
  explicit MandibleBody(const MandibleLayout& layout);

  double Distance(const Vec3& p_W) const { return Distance(p_W, base_->FindClosest({p_W.x, p_W.y})); }
  double Distance(const Vec3& p_W, const CurvePlace& place) const;
  BodySection Section(double s) const;  // s along the base curve, mm

 private:
  const PlaneCurve* base_;
  double step_ = 0.5;
  std::vector<BodySection> sections_;
};

}  // namespace kerf
