#include "cut/tool/planar_kind.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

namespace kerf {
namespace {

using Point = ConvexOutline::Point;

constexpr double kSideSpacing_mm = 0.25;  // least distance between points of a side that bone holds

double CalcHalfArc(const PlanarBlade& blade) {
  return 0.5 * blade.edge_mm / blade.swing_radius_mm;
}

Point MovePoint(const PlanarBlade& blade, const Point& p, double slide_mm) {
  const Vec3 moved = blade.motion().Move(Vec3(p.x, p.y, 0), slide_mm);
  return {moved.x, moved.y};
}

/// Point of T at a depth behind the teeth, at the height y; where the arc has no such point, behind the origin.
double FindBehindTeeth(const PlanarBlade& blade, double depth_mm, double y) {
  const double from_axis_mm = blade.swing_radius_mm - depth_mm;
  if (blade.swing_radius_mm == 0 || !(from_axis_mm > std::abs(y))) return -depth_mm;
  return std::sqrt(from_axis_mm * from_axis_mm - y * y) - blade.swing_radius_mm;
}

/// Adds points of the sides that have no teeth, as far apart as on an edge with this number of intervals. While a blade
/// without a tip moves, its sides are where the stroke takes them furthest: bone holds the blade there, whatever the
/// stroke's phase.
void AddSolids(const PlanarBlade& blade, int intervals, double rim_mm, ToolShape& shape) {
  const ConvexOutline outline = blade.SweepOutline({});
  std::vector<FacePoint> moving;
  for (int i = 0; i < outline.size(); ++i) {
    const ConvexOutline::Side side = outline.side(i);
    if (side.normal.x > 0.5) continue;  // the teeth
    const bool is_back = side.normal.x < -0.5;
    if (blade.has_tip && !is_back && side.normal.y < 0.5) continue;  // at the handle
    const Point& from = outline.corner(i);
    const Point& to = outline.corner(i + 1 < outline.size() ? i + 1 : 0);
    const double length_mm = std::hypot(to.x - from.x, to.y - from.y);
    double wanted = length_mm * intervals / blade.edge_mm;
    if (!blade.has_tip) wanted = std::min(wanted, length_mm / kSideSpacing_mm);
    const int count = std::max(2, static_cast<int>(std::ceil(wanted)));
    const double furthest_mm = std::copysign(0.5 * blade.stroke_mm, side.normal.y);
    const Vec3 n_T(side.normal.x, side.normal.y, 0);
    for (int k = 0; k < count; ++k) {
      const double at = (k + 0.5) / count;
      const Point p{from.x + at * (to.x - from.x), from.y + at * (to.y - from.y)};
      shape.solids.push_back({{p.x, p.y, 0}, n_T, is_back ? Touching::kAlways : Touching::kStopped});
      if (is_back || blade.has_tip || blade.CalcEdgeDistance(p) > -rim_mm) continue;
      moving.push_back({shape.motion.Move(Vec3(p.x, p.y, 0), furthest_mm), shape.motion.CalcTurn(furthest_mm) * n_T,
                        Touching::kMoving});
    }
  }
  shape.solids.insert(shape.solids.end(), moving.begin(), moving.end());
}

/// Adds pairs of points of the flats, one on each side.
void AddFaces(const PlanarBlade& blade, const ShapeSampling& sampling, double rim_mm, ToolShape& shape) {
  const double stopped_mm = std::min(sampling.stopped_margin_mm, rim_mm);
  const ConvexOutline outline = blade.SweepOutline({});
  double half_mm = 0;
  for (int i = 0; i < outline.size(); ++i) half_mm = std::max(half_mm, std::abs(outline.corner(i).y));
  const int columns = std::max(2, static_cast<int>(std::ceil(2 * half_mm / sampling.face_spacing_mm)));
  const auto add_row = [&](double depth_mm, double inside_mm, bool along_teeth, Touching touching) {
    for (int i = 0; i < columns; ++i) {
      const double y = 2 * half_mm * ((i + 0.5) / columns - 0.5);
      const double x = along_teeth ? FindBehindTeeth(blade, depth_mm, y) : -depth_mm;
      if (touching == Touching::kAlways && blade.CalcEdgeDistance({x, y}) > -rim_mm + 1e-9) continue;
      if (blade.CalcSignedDistance({x, y}) > -inside_mm + 1e-9) continue;
      for (const double side : {-1.0, 1.0}) {
        shape.faces.push_back({{x, y, side * 0.5 * blade.thickness_mm}, {0, 0, side}, touching});
      }
    }
  };
  if (stopped_mm < rim_mm) add_row(stopped_mm, stopped_mm, true, Touching::kStopped);
  // Rows are twice as close as points along a row: in a shallow kerf only a few rows hold the blade against tilting.
  const double behind_mm = blade.length_mm() - rim_mm;
  const int rows = std::max(1, static_cast<int>(std::ceil(behind_mm / (0.5 * sampling.face_spacing_mm))));
  for (int row = 0; row < rows; ++row) {
    add_row(rim_mm + behind_mm * row / rows, row == 0 ? rim_mm : 0, row == 0, Touching::kAlways);
  }
}

}  // namespace

ConvexOutline PlanarBlade::SweepOutline(const SlideRange& slide) const {
  std::array<Point, 6 + kChords + 1> points{};
  std::size_t count = 0;
  for (const double slide_mm : {slide.least_mm, slide.most_mm}) {
    points[count++] = MovePoint(*this, back_low, slide_mm);
    points[count++] = MovePoint(*this, back_high, slide_mm);
  }
  const double from_mm = -0.5 * edge_mm + slide.least_mm;
  const double to_mm = 0.5 * edge_mm + slide.most_mm;
  if (swing_radius_mm == 0) {
    for (const double y : {from_mm, 0.5 * edge_mm + slide.least_mm, -0.5 * edge_mm + slide.most_mm, to_mm}) {
      points[count++] = {0, y};
    }
  } else {
    for (int i = 0; i <= kChords; ++i) {
      points[count++] = MovePoint(*this, {0, 0}, from_mm + (to_mm - from_mm) * i / kChords);
    }
  }
  // Without a tip only the teeth cut, and not the way of a corner that moves aslant.
  constexpr double kRotation = 0.01;  // of the pose in a step
  const double turned_rad = swing_radius_mm == 0 ? 0 : 0.5 * (edge_mm + stroke_mm) / swing_radius_mm;
  return ConvexOutline::MakeHull(
      {points.data(), count},
      has_tip ? ConvexOutline::Cutting{1e-6, 0.5} : ConvexOutline::Cutting{std::cos(turned_rad) - kRotation, 2});
}

double PlanarBlade::CalcSagitta() const {
  if (swing_radius_mm == 0) return 0;
  return swing_radius_mm * (1 - std::cos(0.5 * (edge_mm + stroke_mm) / swing_radius_mm / kChords));
}

double PlanarBlade::CalcEdgeDistance(const Point& p) const {
  const double out = swing_radius_mm == 0 ? p.x : std::hypot(p.x + swing_radius_mm, p.y) - swing_radius_mm;
  return has_tip ? std::max(out, p.y - 0.5 * edge_mm) : out;
}

/// The blade with the chord of its arc.
ConvexOutline PlanarBlade::MakeQuadrangle() const {
  const Point corners[] = {MovePoint(*this, {0, 0}, -0.5 * edge_mm), MovePoint(*this, {0, 0}, 0.5 * edge_mm), back_high,
                           back_low};
  return ConvexOutline::MakeHull(corners, {});
}

bool PlanarBlade::IsInFrontOfArc(const Point& p) const {
  return swing_radius_mm > 0 && std::abs(std::atan2(p.y, p.x + swing_radius_mm)) <= CalcHalfArc(*this);
}

double PlanarBlade::CalcSignedDistance(const Point& p) const {
  const ConvexOutline outline = MakeQuadrangle();
  if (swing_radius_mm == 0) return outline.CalcSignedDistance(p);
  const double out = std::hypot(p.x + swing_radius_mm, p.y) - swing_radius_mm;
  if (IsInFrontOfArc(p) && out > 0) return out;
  double most = out;
  for (int i = 0; i < outline.size(); ++i) {
    const ConvexOutline::Side side = outline.side(i);
    if (side.normal.x < 0.5) most = std::max(most, side.normal.x * p.x + side.normal.y * p.y - side.offset_mm);
  }
  return most <= 0 ? most : outline.CalcSignedDistance(p);
}

Point PlanarBlade::FindNearest(const Point& p) const {
  if (swing_radius_mm > 0) {
    if (CalcSignedDistance(p) <= 0) return p;
    if (IsInFrontOfArc(p)) {
      const double from_axis_mm = std::hypot(p.x + swing_radius_mm, p.y);
      if (from_axis_mm > swing_radius_mm) {
        const double scale = swing_radius_mm / from_axis_mm;
        return {scale * (p.x + swing_radius_mm) - swing_radius_mm, scale * p.y};
      }
    }
  }
  return MakeQuadrangle().FindNearest(p);
}

double CalcPlanarRadius(const PlanarBlade& blade) {
  if (blade.swing_radius_mm == 0) return 0.5 * blade.edge_mm;
  return 2 * blade.swing_radius_mm * std::sin(0.5 * CalcHalfArc(blade));
}

double CalcPlanarReach(const PlanarBlade& blade) {
  const ConvexOutline outline = blade.SweepOutline({-0.5 * blade.stroke_mm, 0.5 * blade.stroke_mm});
  double reach_mm = 0;
  for (int i = 0; i < outline.size(); ++i) {
    reach_mm = std::max(reach_mm, std::hypot(outline.corner(i).y, outline.corner(i).x, 0.5 * blade.kerf_mm));
  }
  return reach_mm;
}

int CountPlanarPasses(const PlanarBlade& blade) {
  return std::max(1, static_cast<int>(std::lround(2 * blade.stroke_mm / blade.pitch_mm)));
}

double CalcPlateStiffness(double E_MPa, double width_mm, double thickness_mm, double length_mm) {
  const double thickness_by_length = thickness_mm / length_mm;
  return 0.25 * E_MPa * width_mm * thickness_by_length * thickness_by_length * thickness_by_length;
}

Vec3 FindPlanarDeepest(const PlanarBlade& blade, const Vec3& n_T) {
  const double length = std::hypot(n_T.x, n_T.y, n_T.z);
  if (blade.swing_radius_mm == 0) {
    if (!(std::abs(n_T.y) > 1e-9 * length)) return Vec3(0);
    return {0, std::copysign(0.5 * blade.edge_mm, n_T.y), 0};
  }
  if (!(std::hypot(n_T.x, n_T.y) > 1e-9 * length)) return Vec3(0);
  const double half_rad = CalcHalfArc(blade);
  const double rad = std::clamp(std::atan2(n_T.y, n_T.x), -half_rad, half_rad);
  return blade.motion().Move(Vec3(0), blade.swing_radius_mm * rad);
}

ToolShape MakePlanarShape(const PlanarBlade& blade, const ShapeSampling& sampling) {
  ToolShape shape;
  shape.passes_per_turn = CountPlanarPasses(blade);
  shape.edge_form = EdgeForm::kChain;
  shape.motion = blade.motion();
  constexpr int kMultiple = 8;  // of the intervals, so that every stride ends at the last point
  const double wanted = std::max(64.0, blade.teeth() * sampling.samples_per_pitch);
  const int intervals = kMultiple * static_cast<int>(std::ceil(wanted / kMultiple));
  for (int i = 0; i <= intervals; ++i) {
    const double along_mm = blade.edge_mm * (static_cast<double>(i) / intervals - 0.5);
    shape.edge.push_back({shape.motion.Move(Vec3(0), along_mm), shape.motion.CalcTurn(along_mm) * Vec3(1, 0, 0),
                          blade.teeth() / intervals});
  }
  const double least_mm = std::min(-blade.back_low.x, -blade.back_high.x);
  const double rim_mm = std::min(sampling.rim_margin_mm, 0.4 * least_mm);
  AddSolids(blade, intervals, rim_mm, shape);
  AddFaces(blade, sampling, rim_mm, shape);
  return shape;
}

std::vector<CoverPlate> MakePlanarCover(const PlanarBlade& blade) {
  const ConvexOutline outline = blade.SweepOutline({-0.5 * blade.stroke_mm, 0.5 * blade.stroke_mm});
  Box3 box;
  for (int i = 0; i < outline.size(); ++i) box.Include({outline.corner(i).x, outline.corner(i).y, 0});
  const int along = box.size().x > box.size().y ? 0 : 1;
  const double along_mm = box.size()[along], across_mm = box.size()[1 - along];
  const int count = static_cast<int>(std::ceil(along_mm / across_mm));
  std::vector<CoverPlate> plates;
  for (int i = 0; i < count; ++i) {
    Vec3 centre_T = box.centre();
    centre_T[along] += along_mm * ((i + 0.5) / count - 0.5);
    plates.push_back(
        {centre_T, std::hypot(0.5 * across_mm, 0.5 * along_mm / count) * (1 + 1e-12), 0.5 * blade.kerf_mm});
  }
  return plates;
}

}  // namespace kerf
