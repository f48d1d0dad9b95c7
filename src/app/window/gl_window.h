// A window on the screen with an OpenGL picture that VTK draws. GLFW is seen in gl_window.cpp alone.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "app/window/event.h"

class vtkRenderWindow;

namespace kerf {

struct GlWindowOptions {
  std::string title;
  int width = 1280;  // of the picture's frame in the screen's own units, 640 to 16384
  int height = 720;  // 400 to 16384
};

/// One at a time, in the program's main thread.
class GlWindow {
 public:
  /// Throws Error with what to do when there is no display, or it has no OpenGL 3.3.
  explicit GlWindow(const GlWindowOptions& options);
  ~GlWindow();
  GlWindow(const GlWindow&) = delete;
  GlWindow& operator=(const GlWindow&) = delete;

  /// Where to draw; its size is kept that of the picture.
  vtkRenderWindow& render_window();
  int width() const;  // pixels of the picture; 0 while it is minimised on some systems
  int height() const;
  /// Pixels of the picture for one that text is legible in on a plain screen: 2 on a "2x" display.
  double content_scale() const;

  /// What has happened since the last call; waits for something for at most `wait_s`.
  std::vector<WindowEvent> Poll(double wait_s);
  /// Before a frame is drawn.
  void BeginFrame();
  /// Shows what was drawn.
  void Present();
  void SetTitle(const std::string& title);

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace kerf
