#include "app/window/camera_mouse.h"

#include <cmath>
#include <utility>

namespace kerf {

void CameraMouse::Take(const WindowEvent& event, ViewCamera& camera) {
  using Kind = WindowEvent::Kind;
  const bool down = event.kind == Kind::kMouseDown;
  switch (event.kind) {
    case Kind::kMouseDown:
    case Kind::kMouseUp:
      if (down) {
        x_ = event.x;
        y_ = event.y;
      }
      if (event.button == MouseButton::kRight) orbiting_ = down;
      if (event.button == MouseButton::kMiddle) panning_ = down;
      break;
    case Kind::kMouseMove: {
      const double dx = event.x - std::exchange(x_, event.x);
      const double dy = event.y - std::exchange(y_, event.y);
      if (orbiting_ && event.shift) {
        camera.Pan(dx, dy);
      } else if (orbiting_) {
        camera.Orbit(dx, dy);
      }
      if (panning_) camera.Pan(dx, dy);
      break;
    }
    case Kind::kScroll:
      camera.Zoom(std::pow(1.15, event.amount), {event.x, event.y});
      break;
    default:
      break;
  }
}

}  // namespace kerf
