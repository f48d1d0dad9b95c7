// What a window manager that died has left on the display.
#pragma once

namespace kerf {

/// Removes the property _NET_SUPPORTING_WM_CHECK from the root window of the X display that DISPLAY names if it is
/// stale: the window that it names does not exist, or does not name itself as the specification of the window manager
/// hints demands. Otherwise GLFW 3.3 aborts the program when it reads the property. Does nothing without an X display.
/// Call it before glfwInit(). Returns true if the property was removed.
bool RemoveStaleWindowManagerCheck();

}  // namespace kerf
