#include "view/live/xray_list.h"

#include <cmath>
#include <numbers>

namespace kerf {
namespace {

constexpr Rgb8 kXrayWhite{255, 255, 255};
constexpr Rgb8 kInk{26, 29, 36};
constexpr Rgb8 kHandleColour{0, 92, 150};
constexpr Rgb8 kHotColour{213, 94, 0};

// A symbol with a white edge, which keeps it visible on every background.
void AddSymbol(const Vec3& p_W, XrayShape shape, double size, const Rgb8& colour, XrayList& list) {
  const double edge = shape == XrayShape::kRing ? 0 : 3;
  if (edge > 0) list.symbols.push_back({p_W, shape, size + edge, {kXrayWhite, 0.95, 0.35, false}, 0});
  list.symbols.push_back({p_W, shape, size, {colour, 1, 0.45, false}, 0});
}

void AddCasedLine(const std::vector<Vec3>& points_W, double width, const XrayStyle& style, double towards_eye_mm,
                  const Rgb8& casing, XrayList& list) {
  list.lines.push_back({points_W, width + 2.4, {casing, 0.7 * style.alpha, 0, style.dashed}, towards_eye_mm});
  list.lines.push_back({points_W, width, style, towards_eye_mm});
}

}  // namespace

Rgb8 PointColour(PointKind kind) {
  switch (kind) {
    case PointKind::kPlan:
      return {0, 114, 178};
    case PointKind::kMark:
      return {150, 40, 110};
    case PointKind::kMeasure:
      break;
  }
  return kMeasureColour;
}

void AddBridges(const std::vector<BridgeOverlay>& bridges, XrayList& list) {
  for (const BridgeOverlay& bridge : bridges) {
    if (bridge.points_W.size() < 3) continue;
    XrayPatch patch{bridge.points_W, bridge.triangles, {kBridgeColour, 0.55, 0.45, false}, 0};
    const bool outlined = patch.triangles.empty();
    if (outlined) {
      for (std::uint32_t i = 2; i < patch.points_W.size(); ++i) patch.triangles.push_back({0, i - 1, i});
      std::vector<Vec3> closed = bridge.points_W;
      closed.push_back(closed.front());
      list.lines.push_back({closed, 2, {kBridgeColour, 1, 0.8, false}, 0});
    }
    list.patches.push_back(std::move(patch));
    AddSymbol(bridge.centre_W, XrayShape::kCross, 13, kBridgeColour, list);
  }
}

void AddPoints(const std::vector<PointOverlay>& points, XrayList& list) {
  for (const PointOverlay& point : points) {
    const XrayShape shape = point.kind == PointKind::kPlan   ? XrayShape::kDisc
                            : point.kind == PointKind::kMark ? XrayShape::kDiamond
                                                             : XrayShape::kSquare;
    const double size = kPointSize_points + (point.selected ? 3 : 0);
    AddSymbol(point.p_W, shape, size, PointColour(point.kind), list);
    if (point.selected) AddSymbol(point.p_W, XrayShape::kRing, size + 10, PointColour(point.kind), list);
  }
}

void AddPlaneHandles(const std::vector<PlaneHandleOverlay>& handles, XrayList& list) {
  for (const PlaneHandleOverlay& handle : handles) {
    const Rgb8 colour = handle.hot ? kHotColour : kHandleColour;
    const double size = kHandleSize_points * (handle.hot ? 1.3 : 1);
    // Handles must be seen to be grasped: behind bone they are hardly weaker.
    const auto add = [&](XrayShape shape, double of, const Rgb8& c) {
      list.symbols.push_back({handle.p_W, shape, of, {c, 1, 0.7, false}, 0});
    };
    switch (handle.kind) {
      case HandleKind::kMove:
        add(XrayShape::kDisc, size + 3, kXrayWhite);
        add(XrayShape::kDisc, size, colour);
        add(XrayShape::kCross, 0.62 * size, kXrayWhite);
        break;
      case HandleKind::kTilt:
        add(XrayShape::kDisc, size + 3, kXrayWhite);
        add(XrayShape::kRing, size + 1, colour);
        break;
      case HandleKind::kSize:
        add(XrayShape::kSquare, 0.8 * size + 3, kXrayWhite);
        add(XrayShape::kSquare, 0.8 * size, colour);
        break;
    }
  }
}

void AddPlaneLines(const std::vector<PlaneLineOverlay>& lines, double surface_mm, XrayList& list) {
  for (const PlaneLineOverlay& plane : lines) {
    for (const std::vector<Vec3>& line : plane.lines_W) {
      if (line.size() < 2) continue;
      AddCasedLine(line, plane.selected ? 3.6 : 2.4, {plane.colour, 1, 0.3, true}, surface_mm, kXrayWhite, list);
    }
  }
}

void AddMeasures(const std::vector<MeasureOverlay>& measures, XrayList& list) {
  for (const MeasureOverlay& measure : measures) {
    if (measure.points_W.size() > 1) {
      // The casing, too, is visible through bone: the ends lie on it, and the line mostly within.
      list.lines.push_back({measure.points_W, 6, {kXrayWhite, 0.9, 0.5, false}, 0});
      list.lines.push_back({measure.points_W, 3.2, {kMeasureColour, 1, 0.8, true}, 0});
    }
    for (const Vec3& p_W : measure.points_W) {
      AddSymbol(p_W, XrayShape::kSquare, kPointSize_points - 2, kMeasureColour, list);
    }
  }
}

void AddMarkLines(const std::vector<MarkOverlay>& marks, XrayList& list) {
  for (const MarkOverlay& mark : marks) {
    if ((!mark.selected && !mark.shows_through) || mark.points_W.size() < 2) continue;
    list.lines.push_back({mark.points_W, 2.4, {mark.colour, 0, 0.75, true}, 0});
  }
}

void AddToolOutline(const std::vector<Vec3>& outline_T, const Pose& X_WT, double thickness_mm, Theme theme,
                    XrayList& list) {
  if (outline_T.empty()) return;
  const double nearer = thickness_mm + 0.4;  // in front of the blade itself, however it is seen
  std::vector<Vec3> rim;
  for (const Vec3& p_T : outline_T) rim.push_back(X_WT.Point(p_T));
  rim.push_back(rim.front());
  // Where bone hides it, it lies over bone, which is light in both themes.
  const Rgb8 seen = theme == Theme::kDark ? Rgb8{200, 208, 218} : kInk;
  list.lines.push_back({rim, 1.6, {seen, 0.55, 0, false}, nearer});
  list.lines.push_back({rim, 3.6, {kXrayWhite, 0, 0.5, true}, nearer});
  list.lines.push_back({rim, 1.8, {kInk, 0, 0.85, true}, nearer});
}

}  // namespace kerf
