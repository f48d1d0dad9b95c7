// Keys and mouse that select and move pieces.
#include <algorithm>
#include <numbers>
#include <utility>

#include "app/window/pieces_mode.h"
#include "kerf/error.h"

namespace kerf {
namespace {

constexpr double kNudge_mm = 0.5;
constexpr double kNudge_deg = 1;
constexpr double kTurnByPixel_deg = 0.25;

}  // namespace

bool PiecesMode::Take(const WindowEvent& event) {
  using Kind = WindowEvent::Kind;
  if (menu_) {
    const Menu::State state = menu_->Take(event);
    if (state == Menu::State::kOpen) return event.kind != Kind::kScroll;
    const Menu done = *std::exchange(menu_, std::nullopt);
    if (state == Menu::State::kChosen) done.chosen().choose();
    return true;
  }
  if (!is_ready()) return false;
  const bool measuring = asking_ != Asking::kNothing || !measured_.empty();
  if (event.kind == Kind::kKeyDown && event.key == Key::kEscape && measuring) {
    EndMeasuring();
    return true;
  }
  // A measurement has ended as soon as something else is done.
  if (event.kind == Kind::kMouseDown && event.button == MouseButton::kLeft) measured_.clear();
  if (event.kind == Kind::kKeyDown) return TakeKey(event);
  const bool mouse = event.kind == Kind::kMouseDown || event.kind == Kind::kMouseUp || event.kind == Kind::kMouseMove;
  if (!mouse) return false;
  // Before pieces are changed, wait until no other thread reads them.
  if (finding_.valid() && (event.kind == Kind::kMouseDown || dragging_)) finding_.wait();
  try {
    return TakeMouse(event);
  } catch (const Error& e) {
    viewer_.Say(e.what());
    return true;
  }
}

bool PiecesMode::TakeMouse(const WindowEvent& event) {
  using Kind = WindowEvent::Kind;
  if (event.kind == Kind::kMouseMove) {
    if (dragging_ && selected_ >= 0) Drag(event);
    return dragging_;
  }
  if (event.button != MouseButton::kLeft) return false;
  if (event.kind == Kind::kMouseUp) {
    if (!std::exchange(dragging_, false)) return false;
    if (std::exchange(dragged_, false)) {
      describes_ = true;
      Changed();
    }
    return true;
  }
  const ScreenPoint at{event.x, event.y};
  if (asking_ != Asking::kNothing) return TakePoint(at), true;
  const Ray ray = viewer_.view().camera().CalcRay(at);
  if (const std::optional<PiecePick> hit = pieces_->Pick(ray.origin_W, ray.direction_W)) {
    if (hit->piece != selected_) Select(hit->piece);
    dragging_ = true;
    last_x_ = event.x;
    last_y_ = event.y;
  }
  return true;
}

void PiecesMode::Drag(const WindowEvent& event) {
  const double dx = event.x - std::exchange(last_x_, event.x);
  const double dy = event.y - std::exchange(last_y_, event.y);
  if (dx == 0 && dy == 0) return;
  dragged_ = true;
  unsaved_ = true;
  const ViewCamera& camera = viewer_.view().camera();
  const Vec3 centre_W = pieces_->CalcCentroid(selected_);
  const std::optional<Vec3> along = axis();
  if (event.control) {
    if (along) {
      pieces_->RotateAbout(selected_, centre_W, *along, kTurnByPixel_deg * (dx - dy), gesture_);
    } else {
      const Vec3 turn = kTurnByPixel_deg * (dx * camera.up_W() + dy * camera.right_W());
      const double angle_rad = glm::length(turn) * std::numbers::pi / 180;
      pieces_->Rotate(selected_, centre_W, glm::angleAxis(angle_rad, glm::normalize(turn)), gesture_);
    }
  } else {
    const Vec3 by_W_mm =
        event.shift ? -dy * camera.WorldPerPixel(centre_W) * camera.forward_W() : camera.WorldMotion(dx, dy, centre_W);
    if (along) {
      // Move the piece along the axis by the component of the mouse's motion in that direction.
      pieces_->MoveAlong(selected_, *along, glm::dot(by_W_mm, *along), gesture_);
    } else {
      pieces_->Move(selected_, by_W_mm, gesture_);
    }
  }
  contacts_.reset();
  Show();
}

bool PiecesMode::TakeKey(const WindowEvent& event) {
  if (event.control || selected_ < 0 || pieces_->state(selected_).deleted) return false;
  const ViewCamera& camera = viewer_.view().camera();
  const auto nudge = [&](const Vec3& by_W) {
    describes_ = true;
    Do([&] {
      if (const std::optional<Vec3> along = axis()) {
        const double by_mm = glm::dot(by_W, *along);
        if (by_mm != 0) pieces_->MoveAlong(selected_, *along, kNudge_mm * (by_mm > 0 ? 1 : -1));
      } else {
        pieces_->Move(selected_, kNudge_mm * by_W);
      }
    });
    return true;
  };
  const auto turn = [&](double sign) {
    describes_ = true;
    Do([&] {
      pieces_->RotateAbout(selected_, pieces_->CalcCentroid(selected_), axis().value_or(camera.forward_W()),
                           sign * kNudge_deg);
    });
    return true;
  };
  switch (event.key) {
    case Key::kLeft:
      return nudge(-camera.right_W());
    case Key::kRight:
      return nudge(camera.right_W());
    case Key::kUp:
      return nudge(camera.up_W());
    case Key::kDown:
      return nudge(-camera.up_W());
    case Key::kPageUp:
      return nudge(camera.forward_W());
    case Key::kPageDown:
      return nudge(-camera.forward_W());
    case Key::kQ:
      return turn(-1);
    case Key::kE:
      return turn(1);
    default:
      return false;
  }
}

void PiecesMode::PickMenuRow(int row) {
  if (!menu_ || menu_->Pick(row) != Menu::State::kChosen) return;
  const Menu done = *std::exchange(menu_, std::nullopt);
  done.chosen().choose();
}

void PiecesMode::PickPieceRow(int row) {
  int shown = 0;
  for (int i = 0; i < pieces_->size(); ++i) {
    if (!pieces_->state(i).deleted && shown++ == row) Select(i);
  }
}

}  // namespace kerf
