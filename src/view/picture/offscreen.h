// An OpenGL window that is on no screen.
#pragma once

#include <memory>

#include "view/picture/image.h"

class vtkRenderWindow;

namespace kerf {

/// A VTK render window on an EGL surfaceless context: no display, X server or graphics card needed. Use it from the
/// thread that made it, and one at a time in a thread.
class OffscreenWindow {
 public:
  /// Throws Error when this machine can't draw, or the sides are not 1 to 16384 pixels.
  OffscreenWindow(int width, int height);
  ~OffscreenWindow();
  OffscreenWindow(const OffscreenWindow&) = delete;
  OffscreenWindow& operator=(const OffscreenWindow&) = delete;

  vtkRenderWindow& window();
  /// Renders and reads the pixels; each pixel of the image is the mean of `supersampling` x `supersampling` of the
  /// window's (which must divide its sides). `padding` pixels of the image are cut off on each side.
  Image Draw(int supersampling = 1, int padding = 0);

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace kerf
