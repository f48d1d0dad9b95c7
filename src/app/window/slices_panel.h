// Slices through the bone in the right column, one of which can be enlarged.
#pragma once

#include <array>
#include <functional>
#include <optional>

#include "view/live/slice_view.h"
#include "view/live/surface_worker.h"
#include "view/ui/panels.h"

namespace kerf {

/// Who receives the points that are clicked in slices.
struct SlicePoints {
  bool wanted = false;  // otherwise a click sets the cursor, through which all slices go
  std::function<void(const Vec3&)> take;
  std::function<void()> take_back;  // the last one, which was the first click of a double click
  /// Moves a point of SliceScene::points. `first`: of a drag.
  std::function<void(std::size_t i, const Vec3& p_W, bool first)> move;
};

class SlicesPanel {
 public:
  /// Centres the slices in a new bone. The grey levels stay.
  void Reset(const Box3& bounds_W);
  /// Requests slices that have changed, and takes those that are finished. `contents`: what is drawn in them;
  /// `focus_W`: point through which the slices go unless there is a cursor; `point_W`: point through which they go in
  /// any case; `renew`: the bone has changed since the last call. The slice in which a point or the cursor was set by a
  /// click stays as it is, and only the others follow.
  void Update(SurfaceWorker& surface, const SliceScene& contents, const Vec3& focus_W,
              const std::optional<Vec3>& point_W, bool renew);
  /// Draws the column, and the enlarged slice over the scene.
  void Draw(Ui& ui, const UiBox& column, const UiBox& scene, const SliceScene& contents, const SlicePoints& points);
  bool is_enlarged() const { return enlarged_.has_value(); }
  void Shrink() { enlarged_.reset(); }
  const std::optional<Vec3>& cursor_W() const { return cursor_W_; }
  bool has_slices() const { return views_[0].image.has_value(); }
  /// Offset of a slice from its middle, for tests.
  double offset_mm(std::size_t view) const { return views_[view].spec.offset_mm; }
  /// Middle of a slice before its offset, for tests.
  const Vec3& middle_W(std::size_t view) const { return views_[view].spec.centre_W; }
  const CtWindow& window() const { return window_; }
  static constexpr Range kWindowRange_HU{50, 100'000};  // of its width
  /// Sets the grey levels. The width must be in the range.
  void set_window(const CtWindow& window) { window_ = window; }

 private:
  struct SliceView {
    SliceSpec spec;
    std::optional<SliceSpec> requested;
    std::optional<SliceImage> image;
    std::uint64_t version = 0;
    std::optional<Vec3> still_W;  // middle of a slice that stays as it is
  };
  /// Point that is being dragged.
  struct Drag {
    std::size_t view;
    bool large;
    std::size_t point;
    bool moved = false;
  };
  /// What a click changes, so that a double click can take it back.
  struct BeforeClick {
    std::optional<Vec3> cursor_W;
    std::array<std::pair<double, std::optional<Vec3>>, 4> views;  // offset and middle
  };
  void DrawOne(Ui& ui, std::size_t i, float side, const SliceScene& contents, const SlicePoints& points);
  void TakeMouse(std::size_t i, const OverlayPoint& under, double pixels_per_point, bool large,
                 const SliceScene& contents, const SlicePoints& points);
  void HoldOnly(std::size_t i);
  BeforeClick NoteBeforeClick() const;
  void GoBackTo(const BeforeClick& before);

  std::array<SliceView, 4> views_;
  std::optional<std::size_t> enlarged_;
  float side_px_ = 200;  // of a slice in the column
  float large_side_px_ = 600;
  std::optional<Vec3> cursor_W_;
  std::optional<Vec3> point_W_;  // of the latest Update()
  CtWindow window_;
  bool took_point_ = false;  // with the latest click
  BeforeClick before_click_;
  bool keeps_offsets_ = false;  // at the next change of the point
  std::optional<Drag> drag_;
  bool has_wheel_ = false;  // a slice in the column is under the mouse
};

/// Scrolls the current panel, which was begun without scrolling by the mouse, by the wheel, unless a slice under the
/// mouse uses it.
void ScrollColumn(bool wheel_is_used);

/// Returns the kind and the place of a slice perpendicular to an axis (0 to 2), such as "axial, 35.1 mm up".
std::string DescribeSliceAt(SliceKind kind, int axis, double at_mm);

/// Changes the grey levels by a drag, in points.
void DragGreys(float right, float down, double& level_HU, double& width_HU);

/// Returns the length of the scale bar, of kSliceBar_mm, in a slice of this width; none if it is too short to be seen
/// or longer than 0.6 of the slice. `scale`: pixels per point.
inline constexpr double kSliceBar_mm = 10;
std::optional<double> CalcSliceBar(double width_mm, double side_px, float scale);

/// Returns the kind's name for the user.
const char* NameOf(SliceKind kind);

}  // namespace kerf
