#include "app/window/stale_window_manager.h"

#include <X11/Xatom.h>
#include <X11/Xlib.h>

#include <memory>
#include <optional>

namespace kerf {
namespace {

int IgnoreXError(Display*, XErrorEvent*) {
  return 0;
}

/// Ignores X errors, such as that a window does not exist, which would otherwise end the program.
class IgnoredXErrors {
 public:
  explicit IgnoredXErrors(Display* display) : display_(display), before_(XSetErrorHandler(IgnoreXError)) {}
  ~IgnoredXErrors() {
    XSync(display_, False);
    XSetErrorHandler(before_);
  }
  IgnoredXErrors(const IgnoredXErrors&) = delete;
  IgnoredXErrors& operator=(const IgnoredXErrors&) = delete;

 private:
  Display* display_;
  XErrorHandler before_;
};

/// Returns the window that a property names; nullopt if the window `of` or the property does not exist.
std::optional<Window> ReadWindowProperty(Display* display, Window of, Atom property) {
  Atom type = 0;
  int format = 0;
  unsigned long count = 0;
  unsigned long left = 0;
  unsigned char* data = nullptr;
  const int result =
      XGetWindowProperty(display, of, property, 0, 1, False, XA_WINDOW, &type, &format, &count, &left, &data);
  const std::unique_ptr<unsigned char, int (*)(void*)> owner(data, XFree);
  if (result != Success || type != XA_WINDOW || format != 32 || count != 1) return std::nullopt;
  return *reinterpret_cast<const Window*>(data);
}

}  // namespace

bool RemoveStaleWindowManagerCheck() {
  const std::unique_ptr<Display, int (*)(Display*)> display(XOpenDisplay(nullptr), XCloseDisplay);
  if (display == nullptr) return false;
  const Atom property = XInternAtom(display.get(), "_NET_SUPPORTING_WM_CHECK", True);
  if (property == None) return false;
  const Window root = DefaultRootWindow(display.get());
  const IgnoredXErrors ignored(display.get());
  const std::optional<Window> named = ReadWindowProperty(display.get(), root, property);
  if (!named || ReadWindowProperty(display.get(), *named, property) == *named) return false;
  XDeleteProperty(display.get(), root, property);
  return true;
}

}  // namespace kerf
