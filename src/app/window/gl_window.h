// Window on the screen with an OpenGL picture drawn by VTK. Only gl_window.cpp uses GLFW.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "kerf/describe.h"
#include "view/ui/event.h"

class vtkRenderWindow;

namespace kerf {

struct GlWindowOptions {
  std::string title;
  int width = 1280;
  int height = 720;
};
template <typename V>
void Describe(GlWindowOptions& p, V&& visit) {
  visit("width", p.width, Range{640, 16384},
        "width of the window's content area in screen coordinates, on a display of scale 1; multiplied by its scale");
  visit("height", p.height, Range{400, 16384}, "its height");
}

/// Window of the program. At most one may exist, in the program's main thread.
class GlWindow {
 public:
  /// Throws Error with advice if there is no display, or if it does not support OpenGL 3.3.
  explicit GlWindow(const GlWindowOptions& options);
  ~GlWindow();
  GlWindow(const GlWindow&) = delete;
  GlWindow& operator=(const GlWindow&) = delete;

  /// VTK window to draw into; its size follows that of the picture.
  vtkRenderWindow& render_window();
  int width() const;  // pixels of the picture; on some systems 0 while minimised
  int height() const;
  /// Returns the factor by which text must be enlarged relative to a standard display: 2 on a "2x" display.
  double content_scale() const;

  /// Covers the whole monitor, or returns to the previous place and size.
  void set_full_screen(bool on);
  bool full_screen() const;

  /// Returns the events since the last call. Waits at most `wait_s` for one.
  std::vector<WindowEvent> Poll(double wait_s);
  /// Must be called before a frame is drawn.
  void BeginFrame();
  /// Presents the drawn frame.
  void Present();

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace kerf
