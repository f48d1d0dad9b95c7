// One step of the tool, in the form used to test the leaves of the bone's grid.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <optional>

#include "bone/grid/leaf_table.h"
#include "cut/removal/carve.h"
#include "cut/tool/planar_blade.h"
#include "cut/tool/round_solid.h"
#include "kerf/geometry.h"
#include "kerf/tool.h"

namespace kerf {

/// Shape of the tool, and the zone about its edge in which it changes phi; mm. Its frame is that of the tool, moved
/// along the spindle to the middle of the tool.
struct EdgeZone {
  std::size_t kind = 0;  // of the tool: index of the alternative of Tool
  ToolForm form = ToolForm::kBlade;
  double radius_mm = 0;              // about the spindle axis
  double half_thickness_mm = 0;      // along the spindle; not for a ball
  double band_mm = 0;                // distance outside the tool to which phi changes
  double outside_mm = 0;             // extent of the zone outside the tool
  double depth_mm = 0;               // extent inside the edge; infinite if all of the tool cuts
  std::optional<PlanarBlade> blade;  // of one that is not round
  ConvexOutline outline;             // of what that blade sweeps; others have none
  double centre_z_mm = 0;            // origin of the zone's frame, tool frame
  std::optional<RoundSolid> solid;
  double ceiling_mm = 1e6;  // of a solid: height up to which it cuts

  bool is_blade() const { return form == ToolForm::kBlade; }
  /// The tool lies in a cylinder about the spindle axis, which the next ones bound.
  bool is_cylinder() const { return form != ToolForm::kBall; }
  double CalcReach() const { return is_cylinder() ? radius_mm + half_thickness_mm : radius_mm; }
  /// Returns a bound on the motion of any point of the zone between two poses, mm. A round tool does not move when it
  /// turns about its spindle.
  double BoundTravel(const Pose& X_a, const Pose& X_b) const {
    const double moved_mm = glm::length(X_b.p_AB - X_a.p_AB);
    if (!is_cylinder()) return moved_mm;
    double turned = glm::length(X_b.Vector({0, 0, 1}) - X_a.Vector({0, 0, 1}));
    if (!outline.empty()) turned += glm::length(X_b.Vector({1, 0, 0}) - X_a.Vector({1, 0, 0}));
    return moved_mm + turned * (radius_mm + half_thickness_mm + outside_mm);
  }
  Pose Centre(const Pose& X_WT) const {
    return centre_z_mm != 0 ? Pose{X_WT.R_AB, X_WT.Point({0, 0, centre_z_mm})} : X_WT;
  }
};

/// Returns a bound on the error of float arithmetic near the tool, with some margin, mm.
inline double CalcRounding(const EdgeZone& zone, double voxel_mm) {
  const double size_mm = zone.solid ? zone.CalcReach() : zone.radius_mm;
  return 1e-6 * (size_mm + 16 * voxel_mm) + 1e-4 * voxel_mm;
}

/// Writes the sides of an outline, if any. Returns their number.
inline int WriteSides(const ConvexOutline& outline, bool all_cut, CarveStep::Side* sides) {
  static_assert(ConvexOutline::kMaxCorners <= CarveStep::kMaxSides);
  for (int i = 0; i < outline.size(); ++i) {
    const ConvexOutline::Point& a = outline.corner(i);
    const ConvexOutline::Point& b = outline.corner(i + 1 < outline.size() ? i + 1 : 0);
    const ConvexOutline::Side side = outline.side(i);
    sides[i] = {static_cast<float>(a.x),
                static_cast<float>(a.y),
                static_cast<float>(side.normal.x),
                static_cast<float>(side.normal.y),
                static_cast<float>(std::hypot(b.x - a.x, b.y - a.y)),
                all_cut || outline.Cuts(side)};
  }
  return outline.size();
}

/// Positions of a grid's voxels in the tool frame.
class GridInTool {
 public:
  GridInTool(const Pose& X_WT, double voxel_mm)
      : origin_T_(X_WT.InversePoint(Vec3(0))),
        step_T_{X_WT.InverseVector({voxel_mm, 0, 0}), X_WT.InverseVector({0, voxel_mm, 0}),
                X_WT.InverseVector({0, 0, voxel_mm})} {}

  /// Step of one voxel along axis i of the grid.
  const Vec3& step_T(int i) const { return step_T_[i]; }
  /// Position of a leaf's lowest voxel.
  Vec3 Corner(const LeafIndex& leaf) const {
    return origin_T_ + (8.0 * leaf.x) * step_T_[0] + (8.0 * leaf.y) * step_T_[1] + (8.0 * leaf.z) * step_T_[2];
  }
  /// Distance from a leaf's middle to its outermost voxel along a unit vector, mm.
  double Extent(const Vec3& e_T) const {
    return 3.5 * (std::abs(glm::dot(step_T_[0], e_T)) + std::abs(glm::dot(step_T_[1], e_T)) +
                  std::abs(glm::dot(step_T_[2], e_T)));
  }

 private:
  Vec3 origin_T_;
  Vec3 step_T_[3];
};

/// Returns the test for leaves with a voxel within `slack_mm` of the zone. The middles of the leaves are relative to
/// `origin_W`, along the world's axes.
inline LeafCull MakeLeafCull(const EdgeZone& zone, const Pose& X_WT, const GridInTool& grid, double voxel_mm,
                             const Vec3& origin_W, double slack_mm) {
  LeafCull cull{};
  const Vec3 origin_T = X_WT.InversePoint(origin_W);
  for (int axis = 0; axis < 3; ++axis) {
    Vec3 e(0);
    e[axis] = 1;
    const Vec3 axis_W = X_WT.Vector(e);
    for (int i = 0; i < 3; ++i) {
      cull.axes[axis][i] = static_cast<float>(axis_W[i]);
      cull.half_edges[i][axis] = static_cast<float>(3.5 * grid.step_T(i)[axis]);
    }
    cull.origin[axis] = static_cast<float>(origin_T[axis]);
  }
  cull.half_leaf2 = static_cast<float>(3 * 3.5 * 3.5 * voxel_mm * voxel_mm);
  cull.behind = cull.receded = LeafCull::kNone;
  const double out_mm = zone.outside_mm + slack_mm + CalcRounding(zone, voxel_mm);
  cull.axial = zone.is_cylinder() ? static_cast<float>(zone.half_thickness_mm + out_mm + grid.Extent({0, 0, 1})) : 1e9f;
  cull.axial_counts = zone.is_cylinder() ? 0.0f : 1.0f;
  cull.inner =
      static_cast<float>(std::max(zone.radius_mm - zone.depth_mm - slack_mm - CalcRounding(zone, voxel_mm), -1e6));
  cull.outer = static_cast<float>(zone.radius_mm + out_mm);
  cull.min_distance = static_cast<float>(1e-3 * voxel_mm);
  if (zone.solid) {
    cull.back[2] = 1;
    const double up_mm = zone.ceiling_mm + slack_mm + CalcRounding(zone, voxel_mm) + grid.Extent({0, 0, 1});
    cull.behind = static_cast<float>(std::min(up_mm, 1e6));
  }
  if (zone.outline.empty()) return cull;
  cull.inner = -1e6f;
  cull.sides = WriteSides(zone.outline, std::isinf(zone.depth_mm), cull.side);
  cull.side_out = static_cast<float>(out_mm);
  cull.side_in = 1e6f;
  cull.side_depth = static_cast<float>(std::min(zone.depth_mm + slack_mm + CalcRounding(zone, voxel_mm), 1e6));
  cull.half_diagonal = static_cast<float>(3.5 * std::sqrt(3.0) * voxel_mm);
  return cull;
}

/// Sweep from X_from to X_to, the poses of the zone, with the orientation of X_to. For a blade, the component of the
/// motion along its spindle is ignored; the caller keeps it small by using substeps. A blade with an outline sweeps the
/// hull of its outlines at both poses, each at all displacements of `slide`.
struct Sweep {
  Sweep(const EdgeZone& the_zone, const Pose& X_from, const Pose& the_X_to, const SlideRange& slide,
        double the_voxel_mm, double the_flank_slack_mm, bool new_only, bool whole_voxels, int precision_bits)
      : zone(the_zone),
        X_to(the_X_to),
        voxel_mm(the_voxel_mm),
        flank_slack_mm(the_flank_slack_mm),
        grid(X_to, voxel_mm) {
    Vec3 back_T = X_to.InverseVector(X_from.p_AB - X_to.p_AB);
    if (zone.is_blade()) back_T.z = 0;
    length_mm = glm::length(back_T);
    back = length_mm > 0 ? back_T / length_mm : Vec3(0);
    if (!zone.outline.empty()) SweepOutline(X_from, slide);

    step.kind = zone.kind;
    step.whole_voxels = whole_voxels;
    step.precision_bits = precision_bits;
    step.new_only = new_only;
    step.radius = static_cast<float>(zone.radius_mm);
    step.half_thickness = static_cast<float>(zone.half_thickness_mm);
    step.edge_depth = static_cast<float>(std::min(zone.depth_mm, 1e6));
    step.length = static_cast<float>(length_mm);
    step.flank_slack = static_cast<float>(flank_slack_mm);
    step.band = static_cast<float>(zone.band_mm);
    step.voxel = static_cast<float>(voxel_mm);
    step.rounding = static_cast<float>(CalcRounding(zone, voxel_mm));
    if (zone.solid) SetFaces();
    for (int axis = 0; axis < 3; ++axis) {
      step.back[axis] = static_cast<float>(back[axis]);
      for (int i = 0; i < 3; ++i) step.grid[i][axis] = static_cast<float>(grid.step_T(i)[axis]);
    }
    step.Prepare();
  }

  /// Replaces the outline by the hull that it sweeps, and the length by a bound on the way of its corners.
  void SweepOutline(const Pose& X_from, const SlideRange& slide) {
    std::array<ConvexOutline::Point, 2 * ConvexOutline::kMaxCorners> points{};
    std::size_t count = 0;
    const ConvexOutline slid = zone.blade->SweepOutline(slide);
    double most_mm = 0;
    for (int i = 0; i < slid.size(); ++i) {
      const ConvexOutline::Point& to = slid.corner(i);
      const Vec3 from = X_to.InversePoint(X_from.Point({to.x, to.y, 0}));
      points[count++] = to;
      points[count++] = {from.x, from.y};
      most_mm = std::max(most_mm, std::hypot(from.x - to.x, from.y - to.y));
    }
    length_mm = most_mm + slide.size_mm();
    zone.outline = ConvexOutline::MakeHull({points.data(), count}, slid.cutting());
    step.sides = WriteSides(zone.outline, std::isinf(zone.depth_mm), step.side);
  }

  /// Returns the test for leaves that the step may change.
  LeafCull MakeCull(const Vec3& origin_W) const {
    EdgeZone swept = zone;
    if (step.new_only && !zone.solid) {
      // Further inside, the previous step has carved as deeply: the flats are nearer than the rim, or there is only
      // air.
      const double in_mm = zone.is_blade() ? zone.half_thickness_mm + flank_slack_mm : zone.band_mm;
      swept.depth_mm = std::min(zone.depth_mm, in_mm + length_mm);
    }
    if (!zone.outline.empty()) {
      // The outline is that of the whole sweep already.
      LeafCull cull = MakeLeafCull(zone, X_to, grid, voxel_mm, origin_W, 0);
      if (step.new_only) {
        cull.side_in =
            static_cast<float>(zone.half_thickness_mm + flank_slack_mm + length_mm + CalcRounding(zone, voxel_mm));
      }
      return cull;
    }
    LeafCull cull = MakeLeafCull(swept, X_to, grid, voxel_mm, origin_W, length_mm);
    if (step.new_only && !zone.solid) {
      for (int axis = 0; axis < 3; ++axis) cull.back[axis] = step.back[axis];
      cull.behind = static_cast<float>(length_mm + grid.Extent(back) + CalcRounding(zone, voxel_mm));
    }
    if (step.new_only && zone.solid) LeaveOutReceded(cull);
    return cull;
  }

  /// Leaves out the leaves from all of whose voxels the sides of a solid move away by more than its rotation and the
  /// rounding. For a point whose coordinate along the way across the axis is s, the distance from the axis rises by
  /// (2 s - way) way / (r0 + r1), and if s is at least the way, it is least at the start. A face across the axis counts
  /// only where it is not deeper than the band.
  void LeaveOutReceded(LeafCull& cull) const {
    const double across = std::hypot(back.x, back.y);
    const double way_mm = across * length_mm;
    if (!(way_mm > 0)) return;
    const double rounding_mm = CalcRounding(zone, voxel_mm);
    const double largest_mm =
        zone.radius_mm + zone.outside_mm + length_mm + rounding_mm + 7 * std::sqrt(3.0) * voxel_mm;
    const double up_mm = grid.Extent({0, 0, 1}) + length_mm + flank_slack_mm + 2 * rounding_mm;
    double receded_mm = way_mm;
    double low_mm = -1e6;
    const auto faces = zone.solid->CalcFaces();
    for (int i = 0; i < 2; ++i) {
      const RoundSolid::Face& face = faces[static_cast<std::size_t>(i)];
      if (face.r < 1e-6) {
        low_mm = zone.solid->corner_z_mm - zone.centre_z_mm + zone.band_mm + up_mm;
        continue;
      }
      const double rise_mm = std::max(0.0, flank_slack_mm + rounding_mm - face.z * length_mm * back.z) / face.r;
      receded_mm = std::max(receded_mm, 0.5 * way_mm + rise_mm * (2 * largest_mm + way_mm) / (2 * way_mm));
    }
    const Vec3 e(back.x / across, back.y / across, 0);
    for (int axis = 0; axis < 2; ++axis) cull.across[axis] = static_cast<float>(e[axis]);
    cull.receded = static_cast<float>(std::min(receded_mm + grid.Extent(e) + rounding_mm, 1e6));
    cull.receded_low = static_cast<float>(low_mm);
    cull.receded_high =
        static_cast<float>(std::min(zone.solid->top_z_mm - zone.centre_z_mm - zone.band_mm, zone.ceiling_mm) - up_mm);
  }

  void SetFaces() {
    step.ceiling = static_cast<float>(zone.ceiling_mm);
    const auto faces = zone.solid->CalcFaces();
    for (std::size_t i = 0; i < faces.size(); ++i) {
      step.faces[i] = {static_cast<float>(faces[i].r), static_cast<float>(faces[i].z),
                       static_cast<float>(-faces[i].CalcDistance(0, zone.centre_z_mm))};
    }
  }

  EdgeZone zone;
  Pose X_to;
  double voxel_mm;
  double flank_slack_mm;
  GridInTool grid;
  Vec3 back{0};  // unit vector from the end to the start, tool frame; zero if the tool does not move
  double length_mm = 0;
  CarveStep step;
};

}  // namespace kerf
