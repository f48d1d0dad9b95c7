// The window of kerf for tests, in place of src/app/window/gl_window.cpp: it needs no display. Its events are made up:
// each line of standard input is an array of JSON, the events of one frame: objects with members of a WindowEvent.
#include "app/window/gl_window.h"

#include <poll.h>
#include <unistd.h>
#include <vtkRenderWindow.h>

#include <algorithm>
#include <chrono>
#include <nlohmann/json.hpp>
#include <string>
#include <thread>

#include "kerf/error.h"
#include "view/picture/offscreen.h"

namespace kerf {
namespace {

WindowEvent ReadEvent(const nlohmann::json& json) {
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
  std::chrono::steady_clock::time_point polled;  // the last time
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
  // Fewer frames than on a display, because software draws them: a line of events has one at once, other frames wait.
  constexpr std::chrono::milliseconds kPause{30};
  constexpr std::chrono::milliseconds kFrame{100};
  std::vector<WindowEvent> events;
  pollfd input{STDIN_FILENO, POLLIN, 0};
  const auto left =
      std::chrono::ceil<std::chrono::milliseconds>(state_->polled + kFrame - std::chrono::steady_clock::now());
  const int wait_ms = std::max(static_cast<int>(1e3 * wait_s), static_cast<int>(left.count()));
  const bool more = poll(&input, 1, std::max(wait_ms, 0)) > 0;
  if (more) {
    // Each line has a frame of its own, however many wait.
    std::this_thread::sleep_until(state_->polled + kPause);
    std::string line;
    for (char c = 0; c != '\n'; line += c) {
      if (read(STDIN_FILENO, &c, 1) != 1) throw Error("the test that makes the events has ended");
    }
    for (const nlohmann::json& event : nlohmann::json::parse(line)) events.push_back(ReadEvent(event));
  }
  state_->polled = std::chrono::steady_clock::now();
  return events;
}

void GlWindow::BeginFrame() {
  render_window().MakeCurrent();
}
void GlWindow::Present() {}

}  // namespace kerf
