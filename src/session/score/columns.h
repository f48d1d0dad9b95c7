// Columns of bone in the wanted cut: surface and far side at places along the line.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "bone/grid/removed.h"
#include "kerf/tool.h"
#include "session/scene/exercise.h"

namespace kerf {

/// Column at one place of the line, in the plane of the wanted cut. Depths are measured from the line into the bone.
struct CutColumn {
  double s_mm = 0;     // position along the line
  double near_mm = 0;  // depth of the surface
  double far_mm = 0;   // depth of the end of the bone; gaps of up to kGap_mm are ignored
};

/// Limits of the search: height above the line for the surface, depth below it for the far side, and length of a gap
/// that is ignored.
inline constexpr double kAbove_mm = 5;
inline constexpr double kBelow_mm = 80;
inline constexpr double kGap_mm = 5;

/// Returns the distance between columns: the larger of a voxel and 0.2 mm, adjusted so that both ends of the line have
/// a column. A hole has one column.
double CalcColumnStep(double voxel_mm, const WantedCut& cut);
/// Returns the columns of the bone before the cut; columns without bone are left out. `beyond_mm`: distance by which
/// the line is extended at both ends.
std::vector<CutColumn> FindColumns(const PhiSampler& before, const WantedCut& cut, double beyond_mm);

/// Depth of the tool in the wanted cut. Where the bone is thicker than the wanted depth, it is at most the thickness of
/// the bone: there is nothing to cut below.
struct DepthReading {
  double depth_mm = 0;                 // of the tool's lowest point below the original surface; negative: above it
  double to_goal_mm = 0;               // remaining distance to the wanted depth at that point
  std::optional<double> bone_mm = {};  // thickness of the bone if a cut that should not go through it does
  double beyond_mm = -kBelow_mm;       // distance beyond the far side, within the line's length; negative: before it
};

/// Depth gauge for display while cutting. A call takes 10 to 30 us.
class DepthGauge {
 public:
  DepthGauge(const Bone& before, const WantedCut& cut);
  /// Returns none if the tool is beside the wanted cut. Uses the points of WantedCut::CalcOutline().
  std::optional<DepthReading> Calc(const Pose& X_WT) const;
  /// Updates the maximum depth of the tool below the surface for each of columns(). `deepest_mm`: in and out, one value
  /// per column.
  void TakeDepths(const Pose& X_WT, std::vector<double>& deepest_mm) const;
  const WantedCut& cut() const { return cut_; }
  const std::vector<CutColumn>& columns() const { return columns_; }

 private:
  const CutColumn* Find(double s_mm) const;
  template <typename Visit>
  void VisitOutline(const Pose& X_WT, Visit&& visit) const;

  WantedCut cut_;
  double step_mm_ = 0;
  std::vector<CutColumn> columns_;
  std::vector<int> at_;  // column index by position along the line, -1: none
  double first_mm_ = 0;
  int outline_points_ = 0;
};

/// Fraction of the wanted depth, or of the thickness of thinner bone, from which a place of the line counts as covered.
inline constexpr double kCoveredFraction = 0.5;
/// Returns the fraction of the places of all lines that are covered; none without places. `deepest_mm`: of each gauge,
/// from TakeDepths().
std::optional<double> CalcLineShare(std::span<const DepthGauge> gauges,
                                    std::span<const std::vector<double>> deepest_mm);

/// Returns the gauge of the cut that the tool's lowest point is nearest to. `gauges`: at least one.
const DepthGauge& FindNearestGauge(std::span<const DepthGauge> gauges, const Pose& X_WT);

/// Returns the depth of a cut without a plan: the longest distance along a radius of the tool from its rim in the bone
/// to the original surface; 0 if no part of the rim is in the bone. Of a solid of revolution, the distance is along its
/// axis from its tip. A call takes 0.3 ms.
double CalcBladeDepth(const PhiSampler& before, const Tool& tool, const Pose& X_WT);

}  // namespace kerf
