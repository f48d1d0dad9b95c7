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
};

class SlicesPanel {
 public:
  /// Centres the slices in a new bone. The grey levels stay.
  void Reset(const Box3& bounds_W);
  /// Requests slices that have changed, and takes those that are finished. `contents`: what is drawn in them;
  /// `focus_W`: point through which the slices go unless there is a cursor; `point_W`: point through which they go in
  /// any case; `renew`: the bone has changed since the last call.
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
  };
  void DrawOne(Ui& ui, std::size_t i, float side, const SliceScene& contents, const SlicePoints& points);

  std::array<SliceView, 4> views_;
  std::optional<std::size_t> enlarged_;
  float side_px_ = 200;  // of a slice in the column
  float large_side_px_ = 600;
  std::optional<Vec3> cursor_W_;
  std::optional<Vec3> point_W_;  // of the latest Update()
  CtWindow window_;
  bool took_point_ = false;  // with the latest click
  bool has_wheel_ = false;   // a slice in the column is under the mouse
};

/// Scrolls the current panel, which was begun without scrolling by the mouse, by the wheel, unless a slice under the
/// mouse uses it.
void ScrollColumn(bool wheel_is_used);

/// Draws a slice of a CT into the current panel. `image` and its version; `at_mm`: its position between `lower_mm` and
/// `upper_mm`. Returns the position that the user wants, by wheel or slider. Sets `uses_wheel` if the mouse is over the
/// slice.
double DrawCtView(Ui& ui, std::size_t i, const std::pair<Image, std::uint64_t>& image, double lower_mm, double upper_mm,
                  double at_mm, bool& uses_wheel);

}  // namespace kerf
