#include "view/picture/offscreen.h"

#include <EGL/egl.h>
#include <EGL/eglext.h>
#include <GL/gl.h>
#include <fmt/format.h>
#include <vtkCallbackCommand.h>
#include <vtkGenericOpenGLRenderWindow.h>
#include <vtkNew.h>
#include <vtkOpenGLState.h>
#include <vtkRendererCollection.h>
#include <vtkUnsignedCharArray.h>

#include <algorithm>
#include <atomic>
#include <vector>

#include "base/files/memory.h"
#include "kerf/error.h"
#include "view/picture/picture.h"
#include "view/picture/vtk_mesh.h"

namespace kerf {
namespace {

/// Throws Error if there is too little memory for Mesa's software driver and its compiler, which would then crash. They
/// keep this memory, so later pictures need little more. Trials with `ulimit` in steps of 40 to 60 MB showed that 0.95
/// and 0.75 GB are enough.
void CheckDriverMemory() {
  static std::atomic<bool> is_started{false};
  if (is_started.load()) return;
  CheckLimits(1.1e9, 0.8e9, "drawing a picture", "free some, or omit pictures");
  is_started.store(true);
}

[[noreturn]] void FailEgl(const char* what) {
  throw Error(
      fmt::format("can't draw pictures on this machine: {} (EGL error 0x{:x}); install Mesa's EGL and software driver: "
                  "apt-get install libegl-mesa0 libgl1-mesa-dri",
                  what, static_cast<unsigned>(eglGetError())));
}

/// Returns the display, which is shared by the whole process.
EGLDisplay StartDisplay() {
  const auto get_display =
      reinterpret_cast<PFNEGLGETPLATFORMDISPLAYEXTPROC>(eglGetProcAddress("eglGetPlatformDisplayEXT"));
  if (get_display == nullptr) FailEgl("EGL does not support platform displays");
  const EGLDisplay display = get_display(EGL_PLATFORM_SURFACELESS_MESA, EGL_DEFAULT_DISPLAY, nullptr);
  if (display == EGL_NO_DISPLAY) FailEgl("EGL provides no surfaceless display");
  if (eglInitialize(display, nullptr, nullptr) != EGL_TRUE) FailEgl("the EGL display can't be started");
  return display;
}

// OpenGL 3.3 core context that is current in this thread during its lifetime.
class EglContext {
 public:
  EglContext() {
    if (eglBindAPI(EGL_OPENGL_API) != EGL_TRUE) FailEgl("EGL does not support desktop OpenGL");
    const EGLint config_wish[] = {EGL_SURFACE_TYPE,
                                  EGL_PBUFFER_BIT,
                                  EGL_RENDERABLE_TYPE,
                                  EGL_OPENGL_BIT,
                                  EGL_RED_SIZE,
                                  8,
                                  EGL_GREEN_SIZE,
                                  8,
                                  EGL_BLUE_SIZE,
                                  8,
                                  EGL_ALPHA_SIZE,
                                  8,
                                  EGL_NONE};
    EGLConfig config = nullptr;
    EGLint count = 0;
    if (eglChooseConfig(display_, config_wish, &config, 1, &count) != EGL_TRUE || count == 0) {
      FailEgl("EGL has no configuration for OpenGL");
    }
    const EGLint context_wish[] = {
        EGL_CONTEXT_MAJOR_VERSION,           3,       EGL_CONTEXT_MINOR_VERSION, 3, EGL_CONTEXT_OPENGL_PROFILE_MASK,
        EGL_CONTEXT_OPENGL_CORE_PROFILE_BIT, EGL_NONE};
    context_ = eglCreateContext(display_, config, EGL_NO_CONTEXT, context_wish);
    if (context_ == EGL_NO_CONTEXT) FailEgl("OpenGL 3.3 is not supported");
    // VTK draws into its own frame buffers; some drivers need a surface nevertheless.
    const EGLint surface_wish[] = {EGL_WIDTH, 16, EGL_HEIGHT, 16, EGL_NONE};
    surface_ = eglCreatePbufferSurface(display_, config, surface_wish);
    if (eglMakeCurrent(display_, surface_, surface_, context_) != EGL_TRUE) FailEgl("the OpenGL context can't be used");
  }
  ~EglContext() {
    eglMakeCurrent(display_, EGL_NO_SURFACE, EGL_NO_SURFACE, EGL_NO_CONTEXT);
    if (surface_ != EGL_NO_SURFACE) eglDestroySurface(display_, surface_);
    eglDestroyContext(display_, context_);
    // The display stays initialised because another thread may be drawing on it.
  }
  EglContext(const EglContext&) = delete;
  EglContext& operator=(const EglContext&) = delete;

  void MakeCurrent() const { eglMakeCurrent(display_, surface_, surface_, context_); }
  bool IsCurrent() const { return eglGetCurrentContext() == context_; }

 private:
  EGLDisplay display_ = StartDisplay();
  EGLContext context_ = EGL_NO_CONTEXT;
  EGLSurface surface_ = EGL_NO_SURFACE;
};

}  // namespace

std::string FindLackOfPictures() {
  try {
    CheckDriverMemory();
  } catch (const Error&) {
    return {};
  }
  try {
    StartDisplay();
  } catch (const Error&) {
    return "No pictures: this machine has no OpenGL driver (apt-get install libegl-mesa0 libgl1-mesa-dri).";
  }
  return {};
}

struct OffscreenWindow::State {
  ExitOnBadAlloc ends;  // destroyed last
  EglContext context;
  vtkNew<vtkGenericOpenGLRenderWindow> window;
  int width = 0;
  int height = 0;

  ~State() { window->Finalize(); }

  // VTK requests the context from its window's owner through events.
  void Observe(unsigned long event, void (*answer)(vtkObject*, unsigned long, void*, void*)) {
    const vtkNew<vtkCallbackCommand> command;
    command->SetClientData(&context);
    command->SetCallback(answer);
    window->AddObserver(event, command);
  }
};

OffscreenWindow::OffscreenWindow(int width, int height) {
  constexpr int kMaxSide = 16384;
  if (width < 1 || height < 1 || width > kMaxSide || height > kMaxSide) {
    throw Error(
        fmt::format("a picture of {} x {} pixels can't be drawn; each side must be 1 to {}", width, height, kMaxSide));
  }
  QuietVtk();
  CheckDriverMemory();
  state_ = std::make_unique<State>();
  state_->width = width;
  state_->height = height;
  state_->Observe(vtkCommand::WindowMakeCurrentEvent, [](vtkObject*, unsigned long, void* context, void*) {
    static_cast<EglContext*>(context)->MakeCurrent();
  });
  state_->Observe(vtkCommand::WindowIsCurrentEvent, [](vtkObject*, unsigned long, void* context, void* answer) {
    *static_cast<bool*>(answer) = static_cast<EglContext*>(context)->IsCurrent();
  });
  state_->Observe(vtkCommand::WindowSupportsOpenGLEvent,
                  [](vtkObject*, unsigned long, void*, void* answer) { *static_cast<int*>(answer) = 1; });
  state_->Observe(vtkCommand::WindowIsDirectEvent,
                  [](vtkObject*, unsigned long, void*, void* answer) { *static_cast<int*>(answer) = 0; });
  state_->Observe(vtkCommand::WindowFrameEvent, [](vtkObject*, unsigned long, void*, void*) {});
  vtkGenericOpenGLRenderWindow& window = *state_->window;
  window.SetMultiSamples(0);
  window.InitializeFromCurrentContext();
  window.SetOwnContext(0);
  window.SetReadyForRendering(true);
  window.SetSize(width, height);
  window.SetFrameBlitModeToNoBlit();
  // VTK keeps OpenGL's default depth function in a context that it did not create; later flat primitives would then lie
  // below earlier ones.
  window.GetState()->vtkglDepthFunc(GL_LEQUAL);
}

OffscreenWindow::~OffscreenWindow() = default;

vtkRenderWindow& OffscreenWindow::window() {
  return *state_->window;
}

Image OffscreenWindow::Draw(int supersampling, int padding) {
  const int n = supersampling;
  const int cut = padding * n;
  const int width = state_->width - 2 * cut;
  const int height = state_->height - 2 * cut;
  if (n < 1 || padding < 0 || width < n || height < n || width % n != 0 || height % n != 0) {
    throw Error(fmt::format("{} x {} pixels can't be averaged {} by {}", width, height, n, n));
  }
  state_->window->Render();
  const vtkNew<vtkUnsignedCharArray> raw;
  state_->window->GetPixelData(cut, cut, cut + width - 1, cut + height - 1, 0, raw.Get(), 0);
  if (raw->GetNumberOfTuples() != vtkIdType{width} * height) {
    throw Error(fmt::format("the driver drew no picture of {} x {} pixels", width, height));
  }
  Image image;
  image.width = width / n;
  image.height = height / n;
  image.pixels.resize(static_cast<std::size_t>(image.width) * static_cast<std::size_t>(image.height));
  const auto values = 3 * static_cast<std::size_t>(width);
  std::vector<int> sums(values);
  auto out = image.pixels.begin();
  for (int row = 0; row < image.height; ++row) {
    std::fill(sums.begin(), sums.end(), 0);
    for (int j = 0; j < n; ++j) {
      // OpenGL counts rows from the bottom.
      const unsigned char* const line =
          raw->GetPointer(0) + values * static_cast<std::size_t>(height - 1 - row * n - j);
      for (std::size_t i = 0; i < values; ++i) sums[i] += line[i];
    }
    const int* sum = sums.data();
    for (int column = 0; column < image.width; ++column, ++out) {
      int of_pixel[3] = {n * n / 2, n * n / 2, n * n / 2};  // rounds to the nearest
      for (int i = 0; i < n; ++i, sum += 3) {
        for (int c = 0; c < 3; ++c) of_pixel[c] += sum[c];
      }
      for (std::size_t c = 0; c < 3; ++c) (*out)[c] = static_cast<std::uint8_t>(of_pixel[c] / (n * n));
    }
  }
  return image;
}

}  // namespace kerf
