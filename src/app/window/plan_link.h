// Changes of the plan that a peer of the link asks for, such as a plane that is moved in 3D Slicer.
#pragma once

#include <cstdint>
#include <memory>

#include "app/window/plan_document.h"

namespace kerf {

/// Does nothing without a link. Used only by the window's thread.
class PlanLink {
 public:
  PlanLink(ViewerApp& viewer, PlanDocument& document) : viewer_(viewer), document_(document) {}

  /// Accepts changes from now on: a bone is open.
  void Begin(const Box3& bone_W);
  void End();
  /// Carries out what was asked for since the last frame. Changes that follow one another within half a second are
  /// undone together, unless the user changed the plan meanwhile. What is not possible is answered to the peers.
  void Update(double dt_s);

 private:
  ViewerApp& viewer_;
  PlanDocument& document_;
  double since_s_ = 0;         // time since the last change
  std::uint64_t changes_ = 0;  // of the document, after the last change; 0: there was none
};

}  // namespace kerf
