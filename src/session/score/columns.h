// Where the wanted cut meets the bone: surface and far side, place by place along the line.
#pragma once

#include <optional>
#include <vector>

#include "bone/grid/removed.h"
#include "kerf/tool.h"
#include "session/scene/exercise.h"

namespace kerf {

/// At one place of the line, in the plane of the wanted cut. Depths along the way into the bone from the line itself.
struct CutColumn {
  double s_mm = 0;     // of the line
  double near_mm = 0;  // where the surface is
  double far_mm = 0;   // where the bone ends; gaps of up to kGap_mm are passed over
};

/// Looks no further above the line than this for the surface, and no deeper than that for the far side.
inline constexpr double kAbove_mm = 5;
inline constexpr double kBelow_mm = 80;
inline constexpr double kGap_mm = 5;

/// From one column to the next: the larger of a voxel and 0.2 mm, and so that the line's ends have one each.
double CalcColumnStep(double voxel_mm, const WantedCut& cut);
/// Of the bone before it is cut; columns without bone are left out. `beyond_mm`: the line is gone along so much further
/// at both ends.
std::vector<CutColumn> FindColumns(const PhiSampler& before, const WantedCut& cut, double beyond_mm);

/// Where the tool stands in the wanted cut.
struct DepthReading {
  double depth_mm = 0;            // of the tool's lowest point below the surface as it was; below 0: above it
  double to_goal_mm = 0;          // that are left to the depth wanted, where that point is
  double beyond_mm = -kBelow_mm;  // past the far side, along the line itself; below 0: so far before it
};

/// For a gauge that is shown while one cuts: 10 us a call.
class DepthGauge {
 public:
  DepthGauge(const Bone& before, const WantedCut& cut);
  /// None where the tool is beside the wanted cut. Its rim is looked at, of a ball its outline.
  std::optional<DepthReading> Calc(const Pose& X_WT) const;
  /// Of each of columns(), how deep below its surface the tool has been so far: the larger of `deepest_mm` and where it
  /// is now. `deepest_mm`: one for each column.
  void TakeDepths(const Pose& X_WT, std::vector<double>& deepest_mm) const;
  const WantedCut& cut() const { return cut_; }
  const std::vector<CutColumn>& columns() const { return columns_; }

 private:
  const CutColumn* Find(double s_mm) const;
  template <typename Visit>
  void VisitRim(const Pose& X_WT, Visit&& visit) const;

  WantedCut cut_;
  double step_mm_ = 0;
  std::vector<CutColumn> columns_;
  std::vector<int> at_;  // by place along the line, -1: none
  double first_mm_ = 0;
};

/// Without a plan: the longest way, along a radius of the tool, from its rim in the bone out to the surface as it was;
/// 0 when no rim is in the bone. 0.3 ms a call.
double CalcBladeDepth(const PhiSampler& before, const Tool& tool, const Pose& X_WT);

}  // namespace kerf
