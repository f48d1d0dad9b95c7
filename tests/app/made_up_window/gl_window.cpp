// The window of kerf for tests, in place of src/app/window/gl_window.cpp: it needs no display. Its events are made up:
// each line of standard input is an object of JSON with members of a WindowEvent.
#include "app/window/gl_window.h"

#include <poll.h>
#include <unistd.h>
#include <vtkRenderWindow.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "kerf/error.h"
#include "view/picture/offscreen.h"

namespace kerf {
namespace {

WindowEvent ReadEvent(const std::string& line) {
  const nlohmann::json json = nlohmann::json::parse(line);
  WindowEvent event;
  event.kind = static_cast<WindowEvent::Kind>(json.at("kind").get<int>());
  event.key = static_cast<Key>(json.value("key", 0));
  event.character = json.value("character", char32_t{0});
  event.button = static_cast<MouseButton>(json.value("button", 0));
  event.x = json.value("x", 0.0);
  event.y = json.value("y", 0.0);
  event.amount = json.value("amount", 0.0);
  event.on = json.value("on", false);
  event.path = json.value("path", "");
  event.shift = json.value("shift", false);
  event.control = json.value("control", false);
  return event;
}

}  // namespace

struct GlWindow::State {
  explicit State(const GlWindowOptions& options)
      : window(options.width, options.height), width(options.width), height(options.height) {}

  OffscreenWindow window;
  int width;
  int height;
  bool full_screen = false;
  std::string unread;  // begins with a line whose end has not come yet
};

GlWindow::GlWindow(const GlWindowOptions& options) : state_(std::make_unique<State>(options)) {}
GlWindow::~GlWindow() = default;

vtkRenderWindow& GlWindow::render_window() {
  return state_->window.window();
}
int GlWindow::width() const {
  return state_->width;
}
int GlWindow::height() const {
  return state_->height;
}
double GlWindow::content_scale() const {
  return 1;
}
void GlWindow::set_full_screen(bool on) {
  state_->full_screen = on;
}
bool GlWindow::full_screen() const {
  return state_->full_screen;
}

std::vector<WindowEvent> GlWindow::Poll(double wait_s) {
  std::vector<WindowEvent> events;
  std::string& unread = state_->unread;
  // Fewer frames than on a display: software draws them, and only pictures and the places of the panels are looked at.
  constexpr double kPause_s = 0.03;
  pollfd input{STDIN_FILENO, POLLIN, 0};
  if (poll(&input, 1, wait_s > 0 ? static_cast<int>(1e3 * std::max(wait_s, kPause_s)) : 0) <= 0) return events;
  char bytes[4096];
  const ssize_t count = read(STDIN_FILENO, bytes, sizeof(bytes));
  if (count <= 0) throw Error("the test that makes the events has ended");
  unread.append(bytes, static_cast<std::size_t>(count));
  for (std::size_t end = 0; (end = unread.find('\n')) != std::string::npos; unread.erase(0, end + 1)) {
    events.push_back(ReadEvent(unread.substr(0, end)));
  }
  return events;
}

void GlWindow::BeginFrame() {
  render_window().MakeCurrent();
}
void GlWindow::Present() {}

}  // namespace kerf
