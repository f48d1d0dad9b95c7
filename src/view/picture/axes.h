// Patient coordinates around what a picture shows.
#pragma once

#include <vector>

#include "view/picture/layout.h"
#include "view/picture/overlay.h"

class vtkRenderer;

namespace kerf {

/// A box with a grid on its back faces, numbers in mm along its edges, and the names of its axes.
class PatientAxes {
 public:
  /// Around `box_W`, seen as by `frame`.
  PatientAxes(const Box3& box_W, const ViewFrame& frame, const Layout& layout, bool dark);

  /// The grid, behind what the renderer shows.
  void AddGrid(vtkRenderer& scene) const;
  /// The numbers and names; where the eye looks along an axis also the grid, faintly over everything, as the box's
  /// other faces are not seen.
  void AddNumbers(Overlay& overlay) const;

 private:
  struct Line {
    Vec3 from_W, to_W;
    bool strong;
  };
  std::vector<Line> ListLines() const;
  bool IsSeenAlong(int axis) const;  // its lines are points
  void AddNumbersOf(int axis, Overlay& overlay) const;

  const Box3 box_W_;
  const ViewFrame& frame_;
  const Layout& layout_;
  const bool dark_;
  double line_mm_;
  double number_mm_;
};

}  // namespace kerf
