// Flat marks over the picture, below the panels: labels, rings and the border of an alarm, the scale bar.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "view/ui/hud.h"
#include "view/ui/ui.h"

namespace kerf {

/// Scale bar: `points` on the screen correspond to `mm` at the depth of the camera's target.
struct ScaleBar {
  double mm = 10;
  double points = 100;
};
/// Returns the longest bar that is at most `max_points` long and represents 1, 2 or 5 times a power of ten mm.
ScaleBar CalcScaleBar(double mm_per_point, double max_points);

/// Label of a spot in the picture, pixels.
struct UiLabel {
  std::string text;
  double x = 0;
  double y = 0;
  Rgb8 colour{40, 44, 52};  // of the bar at its left edge and the line to its spot
  bool yields = false;      // left out rather than drawn over what labels avoid
};
/// A place in the picture, pixels.
struct UiSpot {
  double x = 0;
  double y = 0;
};
/// Returns the labels without those that would cover a cut: of the labels whose spots are nearer to it than
/// `radius_px`, only the first `count` are kept.
std::vector<UiLabel> ThinOutLabels(const std::vector<UiLabel>& labels, const UiSpot& cut, double radius_px,
                                   std::size_t count);
struct UiSize {
  double width = 0;
  double height = 0;
};
/// Finds a place near its spot for each label, in order, so that labels overlap neither each other nor `panels` and lie
/// within the area. If possible, they also avoid `soft`, such as the saw; labels that yield always do. `sizes`: of the
/// labels. `scale`: pixels per point. The box of a label without a place is empty.
std::vector<UiBox> PlaceLabels(const std::vector<UiLabel>& labels, const std::vector<UiSize>& sizes,
                               const std::vector<UiBox>& panels, const std::vector<UiBox>& soft, const UiBox& area,
                               double scale);

/// Ring around the place of an alarm, pixels. kPlain: the place is near, but not too near.
struct UiRing {
  double x = 0;
  double y = 0;
  HudLevel level = HudLevel::kPlain;
};
/// Radius of a ring, points; grows with the level.
double RingRadius(HudLevel level);
/// Thickness of the border around the picture, points; grows with the level. 0: no border.
double BorderThickness(HudLevel level);

/// Arrow at the border of a box.
struct UiArrow {
  UiSpot tip;
  double dx = 0, dy = 0;  // its direction, of length 1
};
/// Returns the arrow, `inset` within the box, that points from its middle to a spot outside.
UiArrow FindBorderArrow(const UiBox& box, const UiSpot& beyond, double inset);

/// Height that the scale bar takes at the bottom of the scene, points.
inline constexpr double kScaleBarRoom = 58;

struct PictureMarks {
  std::vector<UiLabel> labels;
  std::vector<UiRing> rings;
  HudLevel alarm = HudLevel::kPlain;  // of the border
  bool injured = false;               // something was cut that must not be: a border even without an alarm
  UiBox tool;                         // labels avoid it if possible
  std::vector<UiBox> kept_clear{};    // and these
  std::optional<UiSpot> cut;          // where the tool cuts: few labels are drawn around it
  bool avoids_panels = true;          // false for a picture without panels
  double mm_per_pixel = 0;            // for the scale bar; 0: none
  std::optional<UiSpot> beyond;       // of a tool outside the scene: an arrow at the border points to it
  UiBox keep_clear = {};              // the scale bar does not cover this
};
/// Returns where a box of this size lies over none of the others, near the lower left corner of the scene or, higher
/// up, near its right edge; none: nowhere in its lower half.
std::optional<UiBox> PlaceScaleBar(const UiSize& size, const UiBox& scene, const std::vector<UiBox>& others,
                                   double scale);
/// Draws the marks. A level is readable without colour: rings and border differ in size and pattern.
void DrawPictureMarks(Ui& ui, const PictureMarks& marks, const UiBox& scene);

}  // namespace kerf
