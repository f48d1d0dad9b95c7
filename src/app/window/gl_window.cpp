#include "app/window/gl_window.h"

#define GLFW_INCLUDE_GLCOREARB
#define GL_GLEXT_PROTOTYPES
#include <GLFW/glfw3.h>
#include <fmt/format.h>
#include <vtkCallbackCommand.h>
#include <vtkGenericOpenGLRenderWindow.h>
#include <vtkNew.h>
#include <vtkOpenGLState.h>

#include <cstdlib>
#include <utility>

#include "app/window/stale_window_manager.h"
#include "base/files/memory.h"
#include "kerf/error.h"
#include "view/picture/vtk_mesh.h"

namespace kerf {
namespace {

std::string g_glfw_error;  // GLFW reports errors through a callback without user data

Key KeyOf(int key) {
  if ((key >= GLFW_KEY_A && key <= GLFW_KEY_Z) || (key >= GLFW_KEY_0 && key <= GLFW_KEY_9)) {
    return static_cast<Key>(key);
  }
  if (key >= GLFW_KEY_F1 && key <= GLFW_KEY_F12)
    return static_cast<Key>(static_cast<int>(Key::kF1) + key - GLFW_KEY_F1);
  if (key >= GLFW_KEY_KP_0 && key <= GLFW_KEY_KP_9) return static_cast<Key>('0' + key - GLFW_KEY_KP_0);
  constexpr std::pair<int, Key> kNamed[] = {
      {GLFW_KEY_SPACE, Key::kSpace},
      {GLFW_KEY_MINUS, Key::kMinus},
      {GLFW_KEY_KP_SUBTRACT, Key::kMinus},
      {GLFW_KEY_EQUAL, Key::kEqual},
      {GLFW_KEY_KP_ADD, Key::kEqual},
      {GLFW_KEY_LEFT_BRACKET, Key::kLeftBracket},
      {GLFW_KEY_RIGHT_BRACKET, Key::kRightBracket},
      {GLFW_KEY_ESCAPE, Key::kEscape},
      {GLFW_KEY_ENTER, Key::kEnter},
      {GLFW_KEY_KP_ENTER, Key::kEnter},
      {GLFW_KEY_TAB, Key::kTab},
      {GLFW_KEY_BACKSPACE, Key::kBackspace},
      {GLFW_KEY_DELETE, Key::kDelete},
      {GLFW_KEY_LEFT, Key::kLeft},
      {GLFW_KEY_RIGHT, Key::kRight},
      {GLFW_KEY_UP, Key::kUp},
      {GLFW_KEY_DOWN, Key::kDown},
      {GLFW_KEY_PAGE_UP, Key::kPageUp},
      {GLFW_KEY_PAGE_DOWN, Key::kPageDown},
      {GLFW_KEY_HOME, Key::kHome},
      {GLFW_KEY_END, Key::kEnd},
  };
  for (const auto& [theirs, ours] : kNamed) {
    if (theirs == key) return ours;
  }
  return Key::kNone;
}

}  // namespace

struct GlWindow::State {
  ExitOnBadAlloc ends;  // destroyed last
  GLFWwindow* window = nullptr;
  vtkNew<vtkGenericOpenGLRenderWindow> vtk;
  std::vector<WindowEvent> events;
  int width = 0;
  int height = 0;
  // Position of the last mouse event. glfwGetCursorPos() returns the current position, which may be far from a click
  // that waited while a picture was drawn.
  double mouse_x = 0;
  double mouse_y = 0;
  int place[4] = {0, 0, 0, 0};  // position and size before full screen

  ~State() {
    if (window != nullptr) {
      glfwMakeContextCurrent(window);
      vtk->Finalize();
      glfwDestroyWindow(window);
    }
    glfwTerminate();
  }

  static State& Of(GLFWwindow* window) { return *static_cast<State*>(glfwGetWindowUserPointer(window)); }
  WindowEvent& Add(WindowEvent::Kind kind, int mods = 0) {
    WindowEvent& event = events.emplace_back();
    event.kind = kind;
    event.shift = (mods & GLFW_MOD_SHIFT) != 0;
    event.control = (mods & GLFW_MOD_CONTROL) != 0;
    event.alt = (mods & GLFW_MOD_ALT) != 0;
    return event;
  }
  /// Mouse positions are in screen coordinates, whose unit may be larger than a pixel.
  void SetPlace(WindowEvent& event) const {
    int w = 1;
    int h = 1;
    glfwGetWindowSize(window, &w, &h);
    event.x = w > 0 ? mouse_x * width / w : mouse_x;
    event.y = h > 0 ? mouse_y * height / h : mouse_y;
  }
  void Resize() {
    glfwGetFramebufferSize(window, &width, &height);
    if (width > 0 && height > 0) vtk->SetSize(width, height);
  }
  void Observe(unsigned long event, void (*answer)(vtkObject*, unsigned long, void*, void*)) {
    const vtkNew<vtkCallbackCommand> command;
    command->SetClientData(this);
    command->SetCallback(answer);
    vtk->AddObserver(event, command);
  }
  void Listen();
};

void GlWindow::State::Listen() {
  using Kind = WindowEvent::Kind;
  glfwSetWindowUserPointer(window, this);
  glfwGetCursorPos(window, &mouse_x, &mouse_y);
  glfwSetKeyCallback(window, [](GLFWwindow* w, int key, int, int action, int mods) {
    WindowEvent& event = Of(w).Add(action == GLFW_RELEASE ? Kind::kKeyUp : Kind::kKeyDown, mods);
    event.key = KeyOf(key);
    event.repeat = action == GLFW_REPEAT;
  });
  glfwSetCharCallback(window, [](GLFWwindow* w, unsigned int c) { Of(w).Add(Kind::kText).character = c; });
  glfwSetMouseButtonCallback(window, [](GLFWwindow* w, int button, int action, int mods) {
    if (button > GLFW_MOUSE_BUTTON_MIDDLE) return;
    WindowEvent& event = Of(w).Add(action == GLFW_PRESS ? Kind::kMouseDown : Kind::kMouseUp, mods);
    event.button = button == GLFW_MOUSE_BUTTON_LEFT    ? MouseButton::kLeft
                   : button == GLFW_MOUSE_BUTTON_RIGHT ? MouseButton::kRight
                                                       : MouseButton::kMiddle;
    Of(w).SetPlace(event);
  });
  glfwSetCursorPosCallback(window, [](GLFWwindow* w, double x, double y) {
    int mods = 0;
    const auto held = [w](int a, int b) { return glfwGetKey(w, a) == GLFW_PRESS || glfwGetKey(w, b) == GLFW_PRESS; };
    if (held(GLFW_KEY_LEFT_SHIFT, GLFW_KEY_RIGHT_SHIFT)) mods |= GLFW_MOD_SHIFT;
    if (held(GLFW_KEY_LEFT_CONTROL, GLFW_KEY_RIGHT_CONTROL)) mods |= GLFW_MOD_CONTROL;
    Of(w).mouse_x = x;
    Of(w).mouse_y = y;
    Of(w).SetPlace(Of(w).Add(Kind::kMouseMove, mods));
  });
  glfwSetScrollCallback(window, [](GLFWwindow* w, double, double y) {
    int mods = 0;
    if (glfwGetKey(w, GLFW_KEY_LEFT_SHIFT) == GLFW_PRESS) mods |= GLFW_MOD_SHIFT;
    if (glfwGetKey(w, GLFW_KEY_LEFT_CONTROL) == GLFW_PRESS) mods |= GLFW_MOD_CONTROL;
    WindowEvent& event = Of(w).Add(Kind::kScroll, mods);
    event.amount = y;
    Of(w).SetPlace(event);
  });
  glfwSetDropCallback(window, [](GLFWwindow* w, int count, const char** paths) {
    if (count > 0) Of(w).Add(Kind::kDrop).path = paths[0];
  });
  glfwSetFramebufferSizeCallback(window, [](GLFWwindow* w, int, int) {
    Of(w).Resize();
    Of(w).Add(Kind::kResize);
  });
  glfwSetWindowRefreshCallback(window, [](GLFWwindow* w) { Of(w).Add(Kind::kRefresh); });
  glfwSetWindowFocusCallback(window, [](GLFWwindow* w, int on) { Of(w).Add(Kind::kFocus).on = on != 0; });
  glfwSetWindowIconifyCallback(window, [](GLFWwindow* w, int on) { Of(w).Add(Kind::kMinimise).on = on != 0; });
  glfwSetWindowCloseCallback(window, [](GLFWwindow* w) {
    Of(w).Add(Kind::kClose);
    glfwSetWindowShouldClose(w, GLFW_FALSE);  // the owner of the window decides whether to close it
  });
}

GlWindow::GlWindow(const GlWindowOptions& options) {
  g_glfw_error.clear();
  glfwSetErrorCallback([](int, const char* text) { g_glfw_error = text; });
  const auto fail = [](const std::string& what) {
    throw Error(fmt::format("{}{}; 'kerf loop' and 'kerf run' cut without a window", what,
                            g_glfw_error.empty() ? "" : fmt::format(" ({})", g_glfw_error)));
  };
  RemoveStaleWindowManagerCheck();
  if (glfwInit() != GLFW_TRUE) {
    glfwTerminate();
    fail(std::getenv("DISPLAY") == nullptr ? "no window can be opened: there is no display"
                                           : "no window can be opened on the display that DISPLAY names");
  }
  state_ = std::make_unique<State>();
  glfwWindowHint(GLFW_CONTEXT_VERSION_MAJOR, 3);
  glfwWindowHint(GLFW_CONTEXT_VERSION_MINOR, 3);
  glfwWindowHint(GLFW_OPENGL_PROFILE, GLFW_OPENGL_CORE_PROFILE);
  glfwWindowHint(GLFW_OPENGL_FORWARD_COMPAT, GLFW_TRUE);
  glfwWindowHint(GLFW_FOCUS_ON_SHOW, GLFW_TRUE);
  glfwWindowHint(GLFW_SCALE_TO_MONITOR, GLFW_TRUE);
  glfwWindowHintString(GLFW_X11_CLASS_NAME, "kerf");
  glfwWindowHintString(GLFW_X11_INSTANCE_NAME, "kerf");
  State& s = *state_;
  s.window = glfwCreateWindow(options.width, options.height, options.title.c_str(), nullptr, nullptr);
  if (s.window == nullptr) fail("no window can be opened: the display does not support OpenGL 3.3");
  glfwSetWindowSizeLimits(s.window, static_cast<int>(FindRange<GlWindowOptions>("width").lower),
                          static_cast<int>(FindRange<GlWindowOptions>("height").lower), GLFW_DONT_CARE, GLFW_DONT_CARE);
  glfwMakeContextCurrent(s.window);
  glfwSwapInterval(1);
  s.Listen();
  QuietVtk();
  s.Observe(vtkCommand::WindowMakeCurrentEvent, [](vtkObject*, unsigned long, void* state, void*) {
    glfwMakeContextCurrent(static_cast<State*>(state)->window);
  });
  s.Observe(vtkCommand::WindowIsCurrentEvent, [](vtkObject*, unsigned long, void* state, void* answer) {
    *static_cast<bool*>(answer) = glfwGetCurrentContext() == static_cast<State*>(state)->window;
  });
  s.Observe(vtkCommand::WindowSupportsOpenGLEvent,
            [](vtkObject*, unsigned long, void*, void* answer) { *static_cast<int*>(answer) = 1; });
  s.Observe(vtkCommand::WindowIsDirectEvent,
            [](vtkObject*, unsigned long, void*, void* answer) { *static_cast<int*>(answer) = 1; });
  s.Observe(vtkCommand::WindowFrameEvent, [](vtkObject*, unsigned long, void*, void*) {});
  s.vtk->SetMultiSamples(0);
  if (!s.vtk->InitializeFromCurrentContext()) fail("VTK can't draw in the window's OpenGL context");
  s.vtk->SetOwnContext(0);
  s.vtk->SetReadyForRendering(true);
  s.vtk->SetFrameBlitModeToBlitToCurrent();
  s.Resize();
}

GlWindow::~GlWindow() = default;

vtkRenderWindow& GlWindow::render_window() {
  return *state_->vtk;
}
int GlWindow::width() const {
  return state_->width;
}
int GlWindow::height() const {
  return state_->height;
}

double GlWindow::content_scale() const {
  float x = 1;
  float y = 1;
  glfwGetWindowContentScale(state_->window, &x, &y);
  return x;
}

bool GlWindow::full_screen() const {
  return glfwGetWindowMonitor(state_->window) != nullptr;
}

void GlWindow::set_full_screen(bool on) {
  GLFWwindow* window = state_->window;
  int(&place)[4] = state_->place;
  if (on == full_screen()) return;
  if (!on) return glfwSetWindowMonitor(window, nullptr, place[0], place[1], place[2], place[3], GLFW_DONT_CARE);
  GLFWmonitor* monitor = glfwGetPrimaryMonitor();
  if (monitor == nullptr) return;
  glfwGetWindowPos(window, &place[0], &place[1]);
  glfwGetWindowSize(window, &place[2], &place[3]);
  const GLFWvidmode* mode = glfwGetVideoMode(monitor);
  glfwSetWindowMonitor(window, monitor, 0, 0, mode->width, mode->height, mode->refreshRate);
}

std::vector<WindowEvent> GlWindow::Poll(double wait_s) {
  if (wait_s > 0) {
    glfwWaitEventsTimeout(wait_s);
  } else {
    glfwPollEvents();
  }
  return std::exchange(state_->events, {});
}

void GlWindow::BeginFrame() {
  glfwMakeContextCurrent(state_->window);
  glBindFramebuffer(GL_FRAMEBUFFER, 0);
  state_->vtk->GetState()->Reset();
}

void GlWindow::Present() {
  glfwSwapBuffers(state_->window);
}

}  // namespace kerf
