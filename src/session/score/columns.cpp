#include "session/score/columns.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "cut/tool/shape.h"

namespace kerf {
namespace {

constexpr int kRimPoints = 120;
/// A point of the tool further than this from the wanted plane is not in the wanted cut.
constexpr double kBeside_mm = 8;

/// Returns the zero of phi between two points of a line, by linear interpolation.
double CalcCrossing(double t0, double phi0, double t1, double phi1) {
  return phi0 == phi1 ? t1 : t0 + (t1 - t0) * phi0 / (phi0 - phi1);
}

}  // namespace

double CalcColumnStep(double voxel_mm, const WantedCut& cut) {
  const double max_mm = std::max(voxel_mm, 0.2);
  if (!(cut.length_mm > 0)) return max_mm;
  return cut.length_mm / std::max(std::ceil(cut.length_mm / max_mm), 1.0);
}

std::vector<CutColumn> FindColumns(const PhiSampler& before, const WantedCut& cut, double beyond_mm) {
  const double step_mm = CalcColumnStep(before.voxel_mm(), cut);
  const double dt_mm = 0.5 * before.voxel_mm();
  std::vector<CutColumn> columns;
  const auto further = static_cast<int>(std::ceil(beyond_mm / step_mm));
  const auto last = static_cast<int>(std::lround(cut.length_mm / step_mm)) + further;
  for (int i = -further; i <= last; ++i) {
    CutColumn column;
    column.s_mm = i * step_mm;
    bool found = false;
    double t0 = -kAbove_mm;
    double phi0 = before.Calc(cut.ToWorld({column.s_mm, t0, 0}));
    for (double t = t0 + dt_mm; t < kBelow_mm; t += dt_mm) {
      const double phi = before.Calc(cut.ToWorld({column.s_mm, t, 0}));
      if (phi0 >= 0 && phi < 0 && !found) {
        column.near_mm = CalcCrossing(t0, phi0, t, phi);
        found = true;
      }
      if (phi0 < 0 && phi >= 0 && found) column.far_mm = CalcCrossing(t0, phi0, t, phi);
      if (found && phi >= 0 && t > column.far_mm + kGap_mm && column.far_mm > column.near_mm) break;
      if (!found && t > cut.depth_mm + kAbove_mm) break;
      t0 = t;
      phi0 = phi;
    }
    if (found && column.far_mm > column.near_mm) columns.push_back(column);
  }
  return columns;
}

DepthGauge::DepthGauge(const Bone& before, const WantedCut& cut) : cut_(cut) {
  const PhiSampler phi(before);
  step_mm_ = CalcColumnStep(before.voxel_mm(), cut);
  // A disc that only plunges passes the columns at its points.
  const double rim_mm = 2 * std::numbers::pi * cut.radius_mm;
  outline_points_ = std::max(kRimPoints, static_cast<int>(std::ceil(rim_mm / step_mm_)));
  // A hole has no line, beyond whose ends the tool would be: it may be as far beside the hole in every direction.
  const double beyond_mm = cut.length_mm > 0 ? cut.radius_mm : kBeside_mm;
  columns_ = FindColumns(phi, cut, beyond_mm);
  first_mm_ = -std::ceil(beyond_mm / step_mm_) * step_mm_;
  at_.assign(static_cast<std::size_t>((cut.length_mm - 2 * first_mm_) / step_mm_ + 1.5), -1);
  for (std::size_t i = 0; i < columns_.size(); ++i) {
    const auto place = static_cast<std::size_t>(std::lround((columns_[i].s_mm - first_mm_) / step_mm_));
    if (place < at_.size()) at_[place] = static_cast<int>(i);
  }
}

const CutColumn* DepthGauge::Find(double s_mm) const {
  const long place = std::lround((s_mm - first_mm_) / step_mm_);
  if (place < 0 || place >= static_cast<long>(at_.size())) return nullptr;
  const int i = at_[static_cast<std::size_t>(place)];
  return i < 0 ? nullptr : &columns_[static_cast<std::size_t>(i)];
}

/// Calls visit(column, p) for each point p of the tool's outline, in the cut's frame, that is not beside the cut.
/// `column`: the column at that point.
template <typename Visit>
void DepthGauge::VisitOutline(const Pose& X_WT, Visit&& visit) const {
  if (std::abs(cut_.ToCut(X_WT.p_AB).z) > kBeside_mm + cut_.reach_mm) return;
  for (const Vec3& p : cut_.CalcOutline(X_WT, outline_points_)) {
    if (std::abs(p.z) > kBeside_mm) continue;
    if (const CutColumn* column = Find(p.x); column != nullptr) visit(*column, p);
  }
}

std::optional<DepthReading> DepthGauge::Calc(const Pose& X_WT) const {
  std::optional<DepthReading> reading;
  VisitOutline(X_WT, [&](const CutColumn& column, const Vec3& p) {
    const double beyond_mm = p.y - column.far_mm;
    const double bone_mm = column.far_mm - column.near_mm;
    const bool through = beyond_mm >= 0 && bone_mm > cut_.depth_mm;
    const double depth_mm = through ? bone_mm : p.y - column.near_mm;
    if (!reading) reading = {depth_mm, cut_.depth_mm - depth_mm, {}};
    if (through && depth_mm >= reading->depth_mm) reading->bone_mm = bone_mm;
    reading->depth_mm = std::max(reading->depth_mm, depth_mm);
    reading->to_goal_mm = std::min(reading->to_goal_mm, cut_.depth_mm - depth_mm);
    // Beyond the ends of the line the bone may end anywhere, for example at a rounded border.
    const bool on_line = column.s_mm > -0.5 * step_mm_ && column.s_mm < cut_.length_mm + 0.5 * step_mm_;
    if (on_line) reading->beyond_mm = std::max(reading->beyond_mm, beyond_mm);
  });
  return reading;
}

void DepthGauge::TakeDepths(const Pose& X_WT, std::vector<double>& deepest_mm) const {
  VisitOutline(X_WT, [&](const CutColumn& column, const Vec3& p) {
    double& deepest = deepest_mm[static_cast<std::size_t>(&column - columns_.data())];
    deepest = std::max(deepest, p.y - column.near_mm);
  });
}

std::optional<double> CalcLineShare(std::span<const DepthGauge> gauges,
                                    std::span<const std::vector<double>> deepest_mm) {
  int places = 0;
  int covered = 0;
  for (std::size_t k = 0; k < gauges.size(); ++k) {
    const std::vector<CutColumn>& columns = gauges[k].columns();
    for (std::size_t i = 0; i < columns.size(); ++i) {
      if (columns[i].s_mm < 0 || columns[i].s_mm > gauges[k].cut().length_mm) continue;
      const double wanted_mm = std::min(gauges[k].cut().depth_mm, columns[i].far_mm - columns[i].near_mm);
      ++places;
      if (deepest_mm[k][i] >= kCoveredFraction * wanted_mm) ++covered;
    }
  }
  return places > 0 ? std::optional(static_cast<double>(covered) / places) : std::nullopt;
}

const DepthGauge& FindNearestGauge(std::span<const DepthGauge> gauges, const Pose& X_WT) {
  const auto distance_mm = [&](const DepthGauge& gauge) {
    return gauge.cut().CalcDistance(gauge.cut().FindLowest(X_WT));
  };
  return *std::min_element(gauges.begin(), gauges.end(),
                           [&](const DepthGauge& a, const DepthGauge& b) { return distance_mm(a) < distance_mm(b); });
}

double CalcBladeDepth(const PhiSampler& before, const Tool& tool, const Pose& X_WT) {
  const double radius_mm = CalcRadius(tool);
  const std::optional<RoundSolid> solid = CalcRoundSolid(tool);
  const bool strokes = CalcStroke(tool) > 0;
  const double length_mm = solid ? solid->top_z_mm : strokes ? CalcReach(tool) : radius_mm;
  const double step_mm = std::max(0.5 * before.voxel_mm(), length_mm / 100);
  double deepest_mm = 0;
  for (int i = 0; i < kRimPoints; ++i) {
    const double turn = 2 * std::numbers::pi * i / kRimPoints;
    const Vec3 out = std::cos(turn) * Vec3(1, 0, 0) + std::sin(turn) * Vec3(0, 1, 0);
    const auto phi = [&](double in_mm) {
      Vec3 p_T = solid ? Vec3(0, 0, in_mm) : (radius_mm - in_mm) * out;
      // From a point of a straight edge, against the direction of the feed.
      if (strokes) p_T = {-in_mm, radius_mm * (2.0 * i / (kRimPoints - 1) - 1), 0};
      return before.Calc(X_WT.Point(p_T));
    };
    double phi0 = phi(0);
    if (phi0 >= 0) continue;
    double depth_mm = length_mm;
    for (double in_mm = step_mm; in_mm < length_mm; in_mm += step_mm) {
      const double phi1 = phi(in_mm);
      if (phi1 >= 0) {
        depth_mm = CalcCrossing(in_mm - step_mm, phi0, in_mm, phi1);
        break;
      }
      phi0 = phi1;
    }
    deepest_mm = std::max(deepest_mm, depth_mm);
  }
  return deepest_mm;
}

}  // namespace kerf
