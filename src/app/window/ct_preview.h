// Slices of a CT whose bone is not made yet: small in the right column, and one of them large.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "bone/import/ct_view.h"
#include "view/picture/image.h"
#include "view/ui/panels.h"

namespace kerf {

/// A point that is drawn in the slices.
struct CtMark {
  Vec3 p_W;
  Rgb8 colour;
  bool square = false;  // otherwise a disc
  std::string label;
};

class CtPreview {
 public:
  /// Draws the column. A click chooses the slice for DrawLarge(). `volume`: null if there is none yet.
  void Draw(Ui& ui, const UiBox& area, const std::shared_ptr<const Volume>& volume,
            const std::vector<CtMark>& marks = {});
  /// Draws the chosen slice into the current window, with its name and position, at most as large as given, pixels.
  /// Returns the point that was clicked.
  std::optional<Vec3> DrawLarge(Ui& ui, float width, float height, const std::shared_ptr<const Volume>& volume,
                                const std::vector<CtMark>& marks);
  /// Begins with a scan, or goes on with it. Called by the functions that draw, too.
  void Follow(const std::shared_ptr<const Volume>& volume);
  /// Lets all slices go through a point.
  void Show(const Vec3& p_W);
  /// Sets the grey levels of slices that are drawn from now on.
  void set_greys(const CtGreys& greys) { greys_ = greys; }
  /// Tints voxels from this value on, in all slices.
  void Tint(double from);
  /// Shows only this part of the scan, LPS, mm.
  void set_box(const Box3& box_W);

 private:
  struct Slice {
    CtView view;
    Image image;
    std::uint64_t version = 0;
    double at_mm = 0;
  };
  /// Edges of what is shown of a slice.
  struct Edges {
    double left_mm, right_mm, top_mm, bottom_mm;
  };
  Edges CalcEdges(std::size_t i) const;
  float CalcShape(std::size_t i) const;
  void Update(std::size_t i);
  /// Draws a slice of this size. Returns the point that was clicked.
  std::optional<Vec3> DrawSlice(Ui& ui, std::size_t i, float width, float height, const std::vector<CtMark>& marks);
  void DrawPosition(Ui& ui, std::size_t i, float width);

  std::array<Slice, 3> slices_;  // axial, coronal, sagittal
  CtGreys greys_;                // of all slices
  Box3 scan_W_;                  // box of the scan
  Box3 box_W_;                   // part of it that is shown
  std::shared_ptr<const Volume> volume_;
  std::size_t large_ = 1;
  bool uses_wheel_ = false;  // the mouse is over a slice
};

}  // namespace kerf
