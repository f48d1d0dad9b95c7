// Offscreen OpenGL window.
#pragma once

#include <memory>

#include "view/picture/image.h"

class vtkRenderWindow;

namespace kerf {

/// VTK render window on an EGL surfaceless context; needs no display, X server or graphics card. Use it only in the
/// thread that created it, and only one at a time per thread.
class OffscreenWindow {
 public:
  /// Throws Error if this machine cannot draw, or a side is not 1 to 16384 pixels.
  OffscreenWindow(int width, int height);
  ~OffscreenWindow();
  OffscreenWindow(const OffscreenWindow&) = delete;
  OffscreenWindow& operator=(const OffscreenWindow&) = delete;

  vtkRenderWindow& window();
  /// Renders and reads back the pixels. Each pixel of the image is the mean of `supersampling` x `supersampling` pixels
  /// of the window, whose sides must be multiples of it. `padding` pixels of the image are cut off on each side.
  Image Draw(int supersampling = 1, int padding = 0);

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace kerf
