// Turning, shifting and zooming of the view with the mouse.
#pragma once

#include "view/live/camera.h"
#include "view/ui/event.h"

namespace kerf {

/// The right button turns the view, or shifts it together with Shift; the middle button shifts it; the wheel zooms.
class CameraMouse {
 public:
  /// Changes the camera if the event is for it.
  void Take(const WindowEvent& event, ViewCamera& camera);
  void Release() { orbiting_ = panning_ = false; }

 private:
  bool orbiting_ = false;
  bool panning_ = false;
  double x_ = 0;
  double y_ = 0;
};

}  // namespace kerf
