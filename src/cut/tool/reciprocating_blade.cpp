#include "cut/tool/reciprocating_blade.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace kerf {
namespace {

/// Adds a pair of points of the flats, one on each side.
void AddFacePair(const ReciprocatingBlade& blade, double x, double y, bool while_stopped, ToolShape& shape) {
  for (const double side : {-1.0, 1.0}) {
    shape.faces.push_back({{x, y, side * 0.5 * blade.thickness_mm}, {0, 0, side}, while_stopped});
  }
}

}  // namespace

ConvexOutline ToolKind<ReciprocatingBlade>::MakeOutline(const ReciprocatingBlade& blade) {
  const double half_mm = 0.5 * blade.length_mm;
  const ConvexOutline::Point corners[] = {
      {0, -half_mm}, {0, half_mm}, {-blade.taper * blade.width_mm, half_mm}, {-blade.width_mm, -half_mm}};
  return ConvexOutline::MakeHull(corners);
}

std::string ToolKind<ReciprocatingBlade>::Name(const ReciprocatingBlade& blade) {
  return fmt::format("reciprocating blade {:g} x {:g} x {:g} mm, teeth {:g} mm apart, stroke {:g} mm", blade.length_mm,
                     blade.width_mm, blade.thickness_mm, blade.pitch_mm, blade.stroke_mm);
}

std::string ToolKind<ReciprocatingBlade>::ShortName(const ReciprocatingBlade& blade) {
  return fmt::format("{:g} mm reciprocating blade", blade.length_mm);
}

double ToolKind<ReciprocatingBlade>::CalcReach(const ReciprocatingBlade& blade) {
  return std::hypot(0.5 * (blade.length_mm + blade.stroke_mm), blade.width_mm, 0.5 * blade.kerf_mm());
}

int ToolKind<ReciprocatingBlade>::CountPassesPerTurn(const ReciprocatingBlade& blade) {
  return std::max(1, static_cast<int>(std::lround(2 * blade.stroke_mm / blade.pitch_mm)));
}

Tooth ToolKind<ReciprocatingBlade>::CalcTooth(const ReciprocatingBlade& blade) {
  return {0.5 * blade.length_mm, blade.pitch_mm, blade.thickness_mm, blade.rake_deg, 1e-3 * blade.edge_radius_um};
}

double ToolKind<ReciprocatingBlade>::CalcSideStiffness(const ReciprocatingBlade& blade) {
  const double thickness_by_length = blade.thickness_mm / blade.length_mm;
  return 0.25 * blade.E_MPa * blade.width_mm * thickness_by_length * thickness_by_length * thickness_by_length;
}

Vec3 ToolKind<ReciprocatingBlade>::FindNearest(const ReciprocatingBlade& blade, const Vec3& p_T) {
  const ConvexOutline::Point nearest = MakeOutline(blade).FindNearest({p_T.x, p_T.y});
  const double half_mm = 0.5 * blade.thickness_mm;
  return {nearest.x, nearest.y, std::clamp(p_T.z, -half_mm, half_mm)};
}

double ToolKind<ReciprocatingBlade>::CalcSignedDistance(const ReciprocatingBlade& blade, const Vec3& p_T) {
  const double out = MakeOutline(blade).CalcSignedDistance({p_T.x, p_T.y});
  const double across = std::abs(p_T.z) - 0.5 * blade.thickness_mm;
  return out > 0 && across > 0 ? std::hypot(out, across) : std::max(out, across);
}

Vec3 ToolKind<ReciprocatingBlade>::FindDeepest(const ReciprocatingBlade& blade, const Vec3& n_T) {
  const double length = std::hypot(n_T.x, n_T.y, n_T.z);
  if (!(std::abs(n_T.y) > 1e-9 * length)) return Vec3(0);
  return {0, std::copysign(0.5 * blade.length_mm, n_T.y), 0};
}

ToolShape ToolKind<ReciprocatingBlade>::MakeShape(const ReciprocatingBlade& blade, const ShapeSampling& sampling) {
  ToolShape shape;
  shape.passes_per_turn = CountPassesPerTurn(blade);
  shape.edge_is_chain = true;
  constexpr int kMultiple = 8;  // of the intervals, so that every stride ends at the last point
  const double wanted = std::max(64.0, blade.teeth() * sampling.samples_per_pitch);
  const int intervals = kMultiple * static_cast<int>(std::ceil(wanted / kMultiple));
  for (int i = 0; i <= intervals; ++i) {
    shape.edge.push_back(
        {{0, blade.length_mm * (static_cast<double>(i) / intervals - 0.5), 0}, {1, 0, 0}, blade.teeth() / intervals});
  }
  const ConvexOutline outline = MakeOutline(blade);
  const auto add_solids = [&](const ConvexOutline::Side& side, const ConvexOutline::Point& from,
                              const ConvexOutline::Point& to, bool while_stopped) {
    const double length_mm = std::hypot(to.x - from.x, to.y - from.y);
    const int count = std::max(2, static_cast<int>(std::ceil(length_mm * intervals / blade.length_mm)));
    for (int i = 0; i < count; ++i) {
      const double at = (i + 0.5) / count;
      shape.solids.push_back({{from.x + at * (to.x - from.x), from.y + at * (to.y - from.y), 0},
                              {side.normal.x, side.normal.y, 0},
                              while_stopped});
    }
  };
  for (int i = 0; i < outline.size(); ++i) {
    const ConvexOutline::Side side = outline.side(i);
    const ConvexOutline::Point& to = outline.corner(i + 1 < outline.size() ? i + 1 : 0);
    if (side.normal.x < -0.5) add_solids(side, outline.corner(i), to, false);                        // back
    if (side.normal.y > 0.5 && side.normal.x > -0.5) add_solids(side, outline.corner(i), to, true);  // tip
  }
  const double rim_mm = std::min(sampling.rim_margin_mm, 0.4 * blade.taper * blade.width_mm);
  const double stopped_mm = std::min(sampling.stopped_margin_mm, rim_mm);
  const int columns = std::max(2, static_cast<int>(std::ceil(blade.length_mm / sampling.face_spacing_mm)));
  const auto add_row = [&](double x, double inside_mm, bool while_stopped) {
    for (int i = 0; i < columns; ++i) {
      const double y = blade.length_mm * ((i + 0.5) / columns - 0.5);
      if (!while_stopped && y > 0.5 * blade.length_mm - rim_mm) continue;  // the tip cuts too
      if (outline.CalcSignedDistance({x, y}) <= -inside_mm + 1e-9) AddFacePair(blade, x, y, while_stopped, shape);
    }
  };
  if (stopped_mm < rim_mm) add_row(-stopped_mm, stopped_mm, true);
  // Rows are twice as close as points along a row: in a shallow kerf only a few rows hold the blade against tilting.
  const int rows =
      std::max(1, static_cast<int>(std::ceil((blade.width_mm - rim_mm) / (0.5 * sampling.face_spacing_mm))));
  for (int row = 0; row < rows; ++row) {
    add_row(-rim_mm - (blade.width_mm - rim_mm) * row / rows, row == 0 ? rim_mm : 0, false);
  }
  return shape;
}

std::vector<CoverPlate> ToolKind<ReciprocatingBlade>::MakeCover(const ReciprocatingBlade& blade) {
  const double along_mm = blade.length_mm + blade.stroke_mm;
  const int count = static_cast<int>(std::ceil(along_mm / blade.width_mm));
  std::vector<CoverPlate> plates;
  for (int i = 0; i < count; ++i) {
    plates.push_back({{-0.5 * blade.width_mm, along_mm * ((i + 0.5) / count - 0.5), 0},
                      std::hypot(0.5 * blade.width_mm, 0.5 * along_mm / count) * (1 + 1e-12),
                      0.5 * blade.kerf_mm()});
  }
  return plates;
}

}  // namespace kerf
