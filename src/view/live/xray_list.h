// Lines, patches and symbols that remain visible, more weakly, where bone hides them. Pure.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "kerf/tool.h"
#include "view/live/overlays.h"

namespace kerf {

/// Colour, and opacity where it is seen directly and where something hides it.
struct XrayStyle {
  Rgb8 colour{0, 0, 0};
  double alpha = 1;
  double hidden_alpha = 0.4;
  bool dashed = false;  // where it is hidden; only lines
};

struct XrayLine {
  std::vector<Vec3> points_W;
  double width_points = 2;  // on the screen
  XrayStyle style;
  double towards_eye_mm = 0;  // shifts only its depth, for lines on the bone's surface
};

struct XrayPatch {
  std::vector<Vec3> points_W;
  std::vector<std::array<std::uint32_t, 3>> triangles;
  XrayStyle style;
  double towards_eye_mm = 0;
};

enum class XrayShape : std::uint8_t { kDisc, kRing, kSquare, kDiamond, kCross };

/// Symbol of constant size on the screen.
struct XraySymbol {
  Vec3 p_W{0};
  XrayShape shape = XrayShape::kDisc;
  double size_points = 10;  // diameter, or edge
  XrayStyle style;
  double towards_eye_mm = 0;
};

/// Drawn in the order patches, lines, symbols; each kind in the order of its list.
struct XrayList {
  std::vector<XrayPatch> patches;
  std::vector<XrayLine> lines;
  std::vector<XraySymbol> symbols;

  bool empty() const { return patches.empty() && lines.empty() && symbols.empty(); }
};

/// Overlays of the plan as lines, patches and symbols. `surface_mm`: how far the drawn surface of the bone may lie in
/// front of the true one.
void AddBridges(const std::vector<BridgeOverlay>& bridges, XrayList& list);
void AddPoints(const std::vector<PointOverlay>& points, XrayList& list);
void AddPlaneHandles(const std::vector<PlaneHandleOverlay>& handles, XrayList& list);
void AddPlaneLines(const std::vector<PlaneLineOverlay>& lines, double surface_mm, XrayList& list);
void AddMeasures(const std::vector<MeasureOverlay>& measures, XrayList& list);
void AddMarkLines(const std::vector<MarkOverlay>& marks, XrayList& list);
/// Adds the closed outline of a blade of that thickness; no outline: nothing.
void AddToolOutline(const std::vector<Vec3>& outline_T, const Pose& X_WT, double thickness_mm, Theme theme,
                    XrayList& list);

Rgb8 PointColour(PointKind kind);
inline constexpr Rgb8 kMeasureColour{120, 40, 110};
inline constexpr Rgb8 kBridgeColour{170, 30, 90};
inline constexpr double kPointSize_points = 11;   // diameter of a point that is not selected
inline constexpr double kHandleSize_points = 15;  // of a handle that is not hot

}  // namespace kerf
