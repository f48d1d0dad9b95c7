// Axes in patient coordinates around the shapes of a picture.
#pragma once

#include <vector>

#include "view/picture/layout.h"
#include "view/picture/overlay.h"

class vtkRenderer;

namespace kerf {

/// Box with a grid on its back faces, numbers in mm along its edges, and the names of its axes.
class PatientAxes {
 public:
  /// Makes axes around `box_W`, seen in `frame`.
  PatientAxes(const Box3& box_W, const ViewFrame& frame, const Layout& layout, bool dark);

  /// Adds the grid behind the contents of the renderer.
  void AddGrid(vtkRenderer& scene) const;
  /// Adds numbers and names. If the view is along an axis, the grid is also drawn faintly over everything, because the
  /// box's other faces are not visible.
  void AddNumbers(Overlay& overlay) const;

 private:
  struct Line {
    Vec3 from_W, to_W;
    bool strong;
  };
  std::vector<Line> ListLines() const;
  bool IsSeenAlong(int axis) const;  // lines along the axis appear as points
  void AddNumbersOf(int axis, Overlay& overlay) const;

  const Box3 box_W_;
  const ViewFrame& frame_;
  const Layout& layout_;
  const bool dark_;
  double line_mm_;
  double number_mm_;
};

}  // namespace kerf
