// Events of mouse, keys and window, and who receives them.
#include <algorithm>
#include <cmath>
#include <utility>

#include "app/window/viewer_app.h"

namespace kerf {
namespace {

/// The first frame takes the click, the second one activates what was clicked, and the third one knows that it takes
/// text.
constexpr int kFramesOfClick = 3;
/// After Tab, keys wait until another field has the input, at most for this number of frames: there may be only one.
constexpr int kMaxFramesOfTab = 12;

}  // namespace

void ViewerApp::Take(const WindowEvent& event) {
  using Kind = WindowEvent::Kind;
  switch (event.kind) {
    case Kind::kClose:
      trace_.Write("closed");
      AskToQuit();
      return;
    case Kind::kDrop:
      trace_.Write("dropped", {{"file", event.path}});
      if (dialogs_.is_open()) {  // it asks about the case that is open
        redraws_ = true;
        return Say(Tr("Answer the dialog first, then drop the file again"));
      }
      activity_->Open(event.path);
      return;
    case Kind::kResize:
      if (window_.width() > 0 && window_.height() > 0) {
        view_->Resize(window_.width(), window_.height(), options_.scale);
        ui_.SetSize(window_.width(), window_.height(), options_.scale);
        trace_.Write("resized", {{"width", window_.width()}, {"height", window_.height()}});
      }
      return;
    case Kind::kRefresh:
      redraws_ = true;
      return;
    case Kind::kFocus:
      redraws_ = true;
      trace_.Write("focus", {{"on", event.on}});
      ui_.Take(event);
      if (!event.on) LoseFocus(Tr("The window lost focus: the spindle was stopped"));
      return;
    case Kind::kMinimise:
      redraws_ = true;
      minimised_ = event.on;
      trace_.Write("minimised", {{"on", event.on}});
      if (event.on) LoseFocus(Tr("The window was minimised: the spindle was stopped"));
      return;
    default:
      break;
  }
  using Owner = MouseOwner;
  const bool down = event.kind == Kind::kKeyDown;
  const bool mouse = event.kind == Kind::kMouseDown || event.kind == Kind::kMouseUp || event.kind == Kind::kMouseMove ||
                     event.kind == Kind::kScroll;
  // The mouse does not overtake keys that wait: a click takes the input away from the field that they are meant for.
  if (mouse && panel_frames_ > 0 && !panel_keys_.empty()) {
    panel_keys_.push_back(event);
    return;
  }
  if (mouse) {
    if (event.kind == Kind::kMouseDown && mouse_owner_ == Owner::kNone) {
      mouse_owner_ = dialogs_.is_open() || ui_.IsOnPanel(event.x, event.y) ? Owner::kPanels : Owner::kScene;
      if (mouse_owner_ == Owner::kPanels && !dialogs_.is_open()) {
        panel_frames_ = kFramesOfClick;
        left_field_ = 0;
      }
      pressed_at_ = {event.x, event.y};
      moved_since_press_ = false;
    }
    const Owner owner = mouse_owner_ != Owner::kNone      ? mouse_owner_
                        : ui_.IsOnPanel(event.x, event.y) ? Owner::kPanels
                                                          : Owner::kScene;
    moved_since_press_ = moved_since_press_ || std::abs(event.x - pressed_at_.x) > 4 * options_.scale ||
                         std::abs(event.y - pressed_at_.y) > 4 * options_.scale;
    if (event.kind == Kind::kMouseUp) mouse_owner_ = Owner::kNone;
    // The panels see every motion, so that they notice when the mouse leaves them.
    if (owner == Owner::kPanels || event.kind == Kind::kMouseMove) ui_.Take(event);
    if (owner == Owner::kScene || (event.kind == Kind::kMouseMove && !dialogs_.is_open())) TakeInScene(event);
    return;
  }
  // Taking a picture is always possible, whatever is open.
  if (down && event.key == Key::kF12) {
    actions_.Take(event);
    return;
  }
  if (down && event.control && event.key == Key::kQ) {
    return AskToQuit();
  }
  if (panel_frames_ > 0) {
    // The release of a key that was pressed before is not delayed.
    const bool waits =
        event.kind != Kind::kKeyUp || std::any_of(panel_keys_.begin(), panel_keys_.end(), [&](const WindowEvent& e) {
          return e.kind == Kind::kKeyDown && e.key == event.key;
        });
    if (waits) {
      panel_keys_.push_back(event);
      return;
    }
  }
  if (event.kind == Kind::kText && ignores_text_) return;
  if (dialogs_.is_open()) {
    dialogs_.Take(ui_, event);
    if (!dialogs_.is_open()) ui_.DropText();
    return;
  }
  if (event.kind == Kind::kKeyUp) {
    ui_.Take(event);
    TakeInScene(event);
    return;
  }
  if (ui_.is_popup_open() || ui_.takes_text()) {
    if (down && event.key == Key::kEscape) return ui_.ClosePopups();
    if (ui_.takes_text() || event.kind != Kind::kText) ui_.Take(event);
    // For a few frames, neither the field that is left nor the next one has the input.
    if (ui_.takes_text() && down && event.key == Key::kTab) {
      panel_frames_ = kMaxFramesOfTab;
      left_field_ = ui_.active_item();
    }
    if (!ui_.takes_text() && down) {
      ui_.ClosePopups();
    } else {
      return;
    }
  }
  const bool question = event.kind == Kind::kText && event.character == U'?';
  if (question || (down && event.key == Key::kF1 && !event.repeat)) return ToggleHelp();
  if (help_ && down) {
    if (event.key == Key::kEscape) help_ = false;
    if (event.key == Key::kSpace && spindle_on()) SetSpindle(false);
    return;
  }
  if (down && event.key == Key::kEscape && slices_.is_enlarged()) return slices_.Shrink();
  if (settings_shown_ && down && event.key == Key::kEscape) {
    settings_shown_ = false;
    return;
  }
  // Escape closes only what is on top, and the tour lies below everything else.
  if (down && tour_.is_open() && !activity_->takes_escape() && tour_.Take(event)) return;
  TakeInScene(event);
}

/// Returns true for what only a running session can take: the keys of its actions, and the left mouse button.
bool ViewerApp::WaitsForSession(const WindowEvent& event) const {
  using Kind = WindowEvent::Kind;
  if (!waits()) return false;
  if (event.kind == Kind::kKeyDown) return !event.repeat && actions_.IsDisabled(event);
  if (!activity_->is_restarting()) return false;  // the mouse may interrupt a turn
  if (event.kind == Kind::kMouseDown || event.kind == Kind::kMouseUp) return event.button == MouseButton::kLeft;
  // A drag goes on if its button is still held.
  const bool drags = !waiting_.empty() && std::any_of(waiting_.begin(), waiting_.end(),
                                                      [](const WindowEvent& e) { return e.kind == Kind::kMouseDown; });
  return event.kind == Kind::kMouseMove && drags && mouse_owner_ == MouseOwner::kScene;
}

void ViewerApp::TakeInScene(const WindowEvent& event) {
  using Kind = WindowEvent::Kind;
  if (WaitsForSession(event)) {
    waiting_.push_back(event);
    if (is_turning()) Say(Tr("The saw turns into the plane first; what you asked for follows."));
    return;
  }
  if (activity_->Take(event)) return;
  if (event.kind == Kind::kKeyDown) {
    if (event.key == Key::kEnter && device_ && device_->waits()) {
      if (!event.repeat) device_->Agree();
      return;
    }
    if (actions_.Take(event)) return;
  }
  const bool turns =
      event.kind == Kind::kScroll || (event.kind == Kind::kMouseDown && event.button != MouseButton::kLeft);
  view_changed_ = view_changed_ || turns;
  if (turns) shown_place_.reset();
  // A view that the user turns is no longer the one that was chosen.
  if (event.kind == Kind::kMouseDown && event.button == MouseButton::kRight && said_ == seen_from_) said_until_s_ = 0;
  if (event.kind == Kind::kMouseUp && event.button == MouseButton::kRight && !moved_since_press_) {
    activity_->OpenContextMenu({event.x, event.y});
  }
  if (steers() && controls_->Take(event, MakeKeyBasis())) return;
  camera_mouse_.Take(event, view_->camera());
}

/// Handles the keys that were pressed right after a click on a panel or after Tab in a field. Call once per drawn
/// frame. Returns whether there were any.
bool ViewerApp::RunPanelKeys() {
  if (panel_frames_ == 0 || ui_.has_waiting_events()) return false;
  const bool next_field =
      left_field_ != 0 && ui_.takes_text() && ui_.active_item() != 0 && ui_.active_item() != left_field_;
  if (!next_field && --panel_frames_ > 0) return false;
  panel_frames_ = 0;
  left_field_ = 0;
  const std::vector<WindowEvent> keys = std::exchange(panel_keys_, {});
  for (const WindowEvent& event : keys) Take(event);
  return !keys.empty();
}

/// Handles the keys and clicks that came while the session restarted. One of them may restart it again.
void ViewerApp::RunWaiting() {
  if (!is_running() || !began_ || waits()) return;
  for (const WindowEvent& event : std::exchange(waiting_, {})) TakeInScene(event);
}

void ViewerApp::LoseFocus(const char* why) {
  controls_->Release();
  camera_mouse_.Release();
  waiting_.clear();
  panel_keys_.clear();
  mouse_owner_ = MouseOwner::kNone;
  if (!spindle_on()) return;
  SetSpindle(false);
  Say(why);
}

}  // namespace kerf
