#include "app/window/pieces_mode.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <exception>
#include <numbers>
#include <utility>

#include "app/window/is_ready.h"
#include "bone/pieces/measure.h"
#include "kerf/error.h"
#include "view/ui/translate.h"

namespace kerf {
namespace {

constexpr double kNudge_mm = 0.5;
constexpr double kNudge_deg = 1;
constexpr double kTurnByPixel_deg = 0.25;
constexpr std::array<const char*, 3> kAxes{Msg("left - right"), Msg("front - back"), Msg("up - down")};
// A software renderer needs 0.2 us per triangle: the drawn surface is coarser than the measured one.
constexpr std::size_t kMaxTriangles = 200'000;

}  // namespace

void PiecesMode::Enter() {
  entered_ = true;
  viewer_.view().ClearTool();
  viewer_.view().SetGhost(std::nullopt);
  viewer_.view().SetForce(std::nullopt);
  const std::uint64_t changes = viewer_.session()->figures().changes;
  if (is_up_to_date()) {
    viewer_.view().set_bone_hidden(true);
    Show();
    return;
  }
  session_ = viewer_.sessions();
  changes_ = changes;
  contacts_.reset();
  splitting_ = std::async(std::launch::async, [bone = viewer_.session()->AskBone(), start = viewer_.uncut_bone(),
                                               earlier = FormatArrangement()]() mutable {
    Split split;
    split.pieces = std::make_shared<PieceSet>(bone.get(), 1.0);
    split.pieces->Prepare();
    for (int i = 0; i < split.pieces->size(); ++i) {
      const Piece& piece = split.pieces->piece(i);
      split.meshes.push_back(std::make_shared<const PieceMesh>(
          MakePieceMesh(start ? *start : piece.bone, piece.mesh, PieceColour(i), kMaxTriangles)));
    }
    if (earlier.empty()) return split;
    try {
      split.pieces->Restore(earlier, "the previous pieces");
    } catch (const Error&) {
      // The bone has been cut since, so the pieces stay where they were cut off.
      split.not_restored = std::move(earlier);
    }
    return split;
  });
}

/// Returns true if the positions of earlier pieces are still the latest ones: those after them were not moved.
bool PiecesMode::uses_earlier() const {
  return !earlier_json_.empty() && (!pieces_ || pieces_->actions().empty());
}

std::string PiecesMode::FormatArrangement() const {
  return uses_earlier() || !pieces_ ? earlier_json_ : pieces_->FormatJson();
}

bool PiecesMode::is_up_to_date() const {
  LiveSession* session = viewer_.session();
  return pieces_ && session != nullptr && session_ == viewer_.sessions() && changes_ == session->figures().changes;
}

void PiecesMode::Leave() {
  entered_ = false;
  asking_ = Asking::kNothing;
  measured_.clear();
  dragging_ = false;
  menu_.reset();
  viewer_.view().SetPieces({});
  viewer_.view().SetMeasures({});
  viewer_.view().set_bone_hidden(false);
  if (LiveSession* session = viewer_.session()) viewer_.view().SetTool(MakeTool(session->scene()));
}

void PiecesMode::Reset() {
  splitting_ = {};
  finding_ = {};
  pieces_.reset();
  unsaved_ = false;
  earlier_json_.clear();
  meshes_.clear();
  contacts_.reset();
  points_.clear();
  measured_.clear();
  measures_.clear();
  earlier_measures_.clear();
  session_ = 0;
  selected_ = axis_ = -1;
  stale_ = false;
}

void PiecesMode::TakeSplit() {
  Split split = splitting_.get();
  const bool earlier = uses_earlier();
  pieces_ = std::move(split.pieces);
  meshes_ = std::move(split.meshes);
  if (split.not_restored.empty()) {
    if (earlier) measures_ = std::move(earlier_measures_);
    earlier_measures_.clear();
  } else if (!earlier) {
    earlier_measures_ = std::exchange(measures_, {});
  }
  earlier_json_ = std::move(split.not_restored);
}

void PiecesMode::Update() {
  if (IsReady(splitting_)) {
    try {
      TakeSplit();
    } catch (const std::exception& e) {  // the session has ended in the meantime
      viewer_.Say(fmt::format(fmt::runtime(Tr("The bone could not be split: {}")), e.what()));
      return;
    }
    selected_ = pieces_->size() > 1 ? 1 : pieces_->size() - 1;
    viewer_.view().set_bone_hidden(true);
    viewer_.Say(!earlier_json_.empty()
                    ? Tr("The bone was cut since its pieces were moved, so the pieces are where they were cut off.")
                : pieces_->size() == 1
                    ? Tr("The bone is in one piece")
                    : fmt::format(fmt::runtime(Tr("{} pieces; click one to pick it, F1 for help")), pieces_->size()));
    viewer_.trace().Write("pieces", {{"count", pieces_->size()}});
    Show();
    Changed();
  }
  if (is_ready()) ShowMeasures();  // the language may have changed
  if (IsReady(finding_)) {
    contacts_ = finding_.get();
    for (const PieceContact& contact : contacts_->with) {
      viewer_.trace().Write("contact", {{"piece", pieces_->piece(contacts_->piece).name},
                                        {"other", pieces_->piece(contact.other).name},
                                        {"overlap_mm3", contact.overlap_mm3},
                                        {"gap_mm", contact.gap ? nlohmann::json(contact.gap->gap_mm) : nullptr}});
    }
  }
  if (stale_ && !finding_.valid() && !dragging_ && pieces_ && selected_ >= 0) {
    stale_ = false;
    if (pieces_->state(selected_).deleted) return;
    finding_ = std::async(std::launch::async, [pieces = pieces_, piece = selected_] {
      return Contacts{.piece = piece, .with = pieces->CalcContacts(piece, 20)};
    });
  }
}

std::optional<Vec3> PiecesMode::axis() const {
  if (axis_ < 0) return std::nullopt;
  Vec3 axis{0};
  axis[axis_] = 1;
  return axis;
}

void PiecesMode::Show() {
  if (!pieces_) return;
  std::vector<PieceShape> shapes;
  for (int i = 0; i < pieces_->size(); ++i) {
    const PieceState& state = pieces_->state(i);
    if (state.deleted) continue;
    PieceShape shape;
    shape.id = i + 1;
    const std::shared_ptr<const PieceMesh>& mesh = meshes_[static_cast<std::size_t>(i)];
    shape.mesh_W = std::shared_ptr<const TriangleMesh>(mesh, &mesh->mesh_P);
    shape.point_colours = std::shared_ptr<const std::vector<Rgb8>>(mesh, &mesh->colours);
    shape.X_WP = state.X_WP;
    shape.colour = PieceColour(i);
    shape.selected = i == selected_;
    shape.hidden = state.hidden;
    shapes.push_back(std::move(shape));
  }
  viewer_.view().SetPieces(shapes);
  for (Measure& m : measures_) m.now = MeasurePieces(*pieces_, m.points);
  ShowMeasures();
}

void PiecesMode::ShowMeasures() {
  std::vector<MeasureOverlay> measures;
  for (const Measure& m : measures_) {
    if (!m.now) continue;
    const std::string value = ShowNumber(m.now->value, 1);
    measures.push_back({.points_W = m.now->points_W,
                        .label = m.points.size() == 2 ? fmt::format("{} mm", value) : fmt::format("{}°", value)});
  }
  MeasureOverlay begun;
  for (const PiecePoint& point : points_) {
    if (const std::optional<Vec3> p_W = CalcPlace(*pieces_, point)) begun.points_W.push_back(*p_W);
  }
  if (!begun.points_W.empty()) measures.push_back(std::move(begun));
  viewer_.view().SetMeasures(measures);
}

void PiecesMode::Changed() {
  contacts_.reset();
  stale_ = true;
  ++gesture_;
  Show();
}

void PiecesMode::Select(int piece) {
  selected_ = piece;
  Changed();
}

void PiecesMode::SelectNext(int by) {
  const int count = pieces_->size();
  if (count == 0) return;
  for (int tried = 0; tried < count; ++tried) {
    selected_ = (selected_ + by + count) % count;
    if (!pieces_->state(selected_).deleted) break;
  }
  Changed();
}

void PiecesMode::TakePoint(const ScreenPoint& at) {
  const Ray ray = viewer_.view().camera().CalcRay(at);
  const std::optional<PiecePick> hit = pieces_->Pick(ray.origin_W, ray.direction_W);
  if (!hit) return viewer_.Say(Tr("There is no piece under the mouse"));
  points_.push_back(MakePiecePoint(*pieces_, *hit));
  const std::size_t wanted = asking_ == Asking::kDistance ? 2 : 3;
  if (points_.size() == wanted) {
    Measure measure{.points = std::exchange(points_, {}), .now = {}};
    measure.now = MeasurePieces(*pieces_, measure.points);
    const double value = measure.now ? measure.now->value : 0;
    viewer_.trace().Write("measure",
                          {{"label", fmt::format("{:.1f}{}", value, asking_ == Asking::kDistance ? " mm" : "°")}});
    measured_ = asking_ == Asking::kDistance
                    ? fmt::format(fmt::runtime(Tr("The distance is {} mm.")), ShowNumber(value, 1))
                    : fmt::format(fmt::runtime(Tr("The angle is {}°.")), ShowNumber(value, 1));
    measures_.push_back(std::move(measure));
    asking_ = Asking::kNothing;
  }
  Show();
}

std::vector<ExportMeasure> PiecesMode::measures() const {
  std::vector<ExportMeasure> taken;
  for (const Measure& m : uses_earlier() ? earlier_measures_ : measures_) {
    if (!m.now) continue;
    const bool distance = m.points.size() == 2;
    taken.push_back({.name = fmt::format("{} {}", distance ? "distance" : "angle", taken.size() + 1),
                     .unit = distance ? "mm" : "deg",
                     .value = m.now->value,
                     .points_W_mm = m.now->points_W});
  }
  return taken;
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

bool PiecesMode::TakeMouse(const WindowEvent& event) {
  using Kind = WindowEvent::Kind;
  if (event.kind == Kind::kMouseMove) {
    if (dragging_ && selected_ >= 0) Drag(event);
    return dragging_;
  }
  if (event.button != MouseButton::kLeft) return false;
  if (event.kind == Kind::kMouseUp) {
    if (!std::exchange(dragging_, false)) return false;
    if (std::exchange(dragged_, false)) Changed();
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

void PiecesMode::ShowCheckpoints() {
  std::vector<MenuItem> items;
  for (const std::string& name : pieces_->checkpoints()) {
    items.push_back({.name = name, .detail = "", .enabled = true, .choose = [this, name] {
                       pieces_->GoTo(name);
                       Changed();
                     }});
  }
  if (items.empty()) return viewer_.Say(Tr("There is no checkpoint of the pieces yet; press C to make one"));
  menu_.emplace(Tr("Return pieces to"), std::move(items));
}

void PiecesMode::Do(const std::function<void()>& change) {
  // Before pieces are changed, wait until no other thread reads them.
  if (finding_.valid()) finding_.wait();
  unsaved_ = true;
  measured_.clear();
  try {
    change();
  } catch (const Error& e) {
    viewer_.Say(e.what());
  }
  Changed();
}

bool PiecesMode::is_ready() const {
  return entered_ && pieces_ && !splitting_.valid();
}

void PiecesMode::AddActions(ActionList& actions) {
  const auto ready = [this] { return is_ready() && !menu_; };
  const auto any = [this, ready] { return ready() && selected_ >= 0 && !pieces_->state(selected_).deleted; };
  const auto ask = [this](Asking what) {
    EndMeasuring();
    asking_ = what;
  };
  actions.Add({.id = "pieces.next",
               .menu = Msg("Pieces"),
               .label = Msg("Pick the next piece"),
               .shortcut = {Key::kTab},
               .run = [this] { SelectNext(1); },
               .enabled = ready,
               .begins_group = true});
  actions.Add({.id = "pieces.axis",
               .menu = Msg("Pieces"),
               .label = Msg("One axis only: left, front, up, any"),
               .shortcut = {Key::kA},
               .tip = Msg("Restricts motion to one of the patient's axes, and rotation to that axis"),
               .run =
                   [this] {
                     axis_ = axis_ == 2 ? -1 : axis_ + 1;
                     viewer_.Say(axis_ < 0 ? std::string(Tr("Pieces move freely"))
                                           : fmt::format(fmt::runtime(Tr("Pieces move along {} and turn about it")),
                                                         Tr(kAxes[static_cast<std::size_t>(axis_)])));
                   },
               .enabled = ready,
               .on = [this] { return axis_ >= 0; },
               .relevant = [this] { return entered_; },
               .indicator = Msg("One axis")});
  actions.Add({.id = "pieces.hide",
               .menu = Msg("Pieces"),
               .label = Msg("Hide or show the piece"),
               .shortcut = {Key::kH},
               .run = [this] { Do([this] { pieces_->SetHidden(selected_, !pieces_->state(selected_).hidden); }); },
               .enabled = any});
  actions.Add({.id = "pieces.delete",
               .menu = Msg("Pieces"),
               .label = Msg("Delete the piece"),
               .shortcut = {Key::kDelete},
               .run =
                   [this] {
                     Do([this] { pieces_->Delete(selected_); });
                     SelectNext(1);
                   },
               .enabled = any});
  actions.Add({.id = "pieces.reset",
               .menu = Msg("Pieces"),
               .label = Msg("Return the piece to its place"),
               .shortcut = {Key::kR},
               .run = [this] { Do([this] { pieces_->Reset(selected_); }); },
               .enabled = any});
  actions.Add({.id = "pieces.reset_all",
               .menu = Msg("Pieces"),
               .label = Msg("Return all pieces"),
               .shortcut = {.key = Key::kR, .shift = true},
               .run = [this] { Do([this] { pieces_->ResetAll(); }); },
               .enabled = ready});
  actions.Add({.id = "pieces.distance",
               .menu = Msg("Pieces"),
               .label = Msg("Measure a distance"),
               .shortcut = {Key::kD},
               .run = [ask] { ask(Asking::kDistance); },
               .enabled = ready,
               .begins_group = true});
  actions.Add({.id = "pieces.angle",
               .menu = Msg("Pieces"),
               .label = Msg("Measure an angle"),
               .shortcut = {Key::kJ},
               .run = [ask] { ask(Asking::kAngle); },
               .enabled = ready});
  actions.Add({.id = "pieces.clear",
               .menu = Msg("Pieces"),
               .label = Msg("Delete the measurements"),
               .shortcut = {Key::kBackspace},
               .run =
                   [this] {
                     measures_.clear();
                     EndMeasuring();
                   },
               .enabled = ready});
}

void PiecesMode::Undo() {
  Do([this] {
    if (!pieces_->Undo()) viewer_.Say(Tr("There is nothing to undo"));
  });
}

void PiecesMode::Redo() {
  Do([this] {
    if (!pieces_->Redo()) viewer_.Say(Tr("There is nothing to redo"));
  });
}

void PiecesMode::AskCheckpoint() {
  viewer_.AskText(Tr("Name of the checkpoint:"), fmt::format("pieces {}", pieces_->checkpoints().size() + 1),
                  [this](const std::optional<std::string>& name) {
                    if (!name || name->empty()) return;
                    pieces_->Checkpoint(*name);
                    viewer_.Say(fmt::format(fmt::runtime(Tr("Checkpoint: {}")), *name));
                  });
}

bool PiecesMode::TakeKey(const WindowEvent& event) {
  if (event.control || selected_ < 0 || pieces_->state(selected_).deleted) return false;
  const ViewCamera& camera = viewer_.view().camera();
  const auto nudge = [&](const Vec3& by_W) {
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

void PiecesMode::EndMeasuring() {
  asking_ = Asking::kNothing;
  points_.clear();
  measured_.clear();
  Show();
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

void PiecesMode::Fill(HudState& hud) {
  hud.show_plot = false;
  hud.show_values = false;
  if (splitting_.valid()) {
    hud.progress = HudProgress{.title = Tr("Pieces"), .stage = Tr("splitting the bone"), .fraction = {}};
    return;
  }
  if (!pieces_) return;
  for (int i = 0; i < pieces_->size(); ++i) {
    const PieceState& state = pieces_->state(i);
    if (state.deleted) continue;
    HudPiece row;
    row.name = ShowName(pieces_->piece(i).name);
    row.detail = ShowVolume(pieces_->piece(i).volume_mm3);
    const double moved_mm = glm::length(pieces_->CalcCentroid(i) - pieces_->piece(i).centroid_P);
    const double turned_deg = CalcRotationAngle(state.X_WP);
    std::string words = fmt::format("{}: {}", row.name, row.detail);
    if (moved_mm > 0.005 || turned_deg > 0.05) {
      words += fmt::format(fmt::runtime(Tr(", moved {} mm, turned {}°")), ShowNumber(moved_mm, 1),
                           ShowNumber(turned_deg, 1));
    }
    if (contacts_) {
      for (const PieceContact& contact : contacts_->with) {
        if (contacts_->piece != i && contact.other != i) continue;
        const std::string lies =
            contact.overlap_mm3 > 0
                ? fmt::format(fmt::runtime(Tr("overlap {} mm³")), ShowNumber(contact.overlap_mm3, 1))
            : contact.gap ? fmt::format(fmt::runtime(Tr("gap {} mm")), ShowNumber(contact.gap->gap_mm, 2))
                          : std::string(Tr("apart"));
        // Decimals would not fit in the row.
        if (contact.other == i) {
          row.detail = contact.overlap_mm3 >= 1
                           ? fmt::format(fmt::runtime(Tr("ovl. {} mm³")), ShowNumber(contact.overlap_mm3, 0))
                           : lies;
        }
        if (contacts_->piece == i)
          words += fmt::format(fmt::runtime(Tr(", {} with {}")), lies, ShowName(pieces_->piece(contact.other).name));
      }
    }
    if (i == selected_ && hud.status.message.empty()) hud.status.message = words;
    row.tip = words;
    row.colour = PieceColour(i);
    row.selected = i == selected_;
    row.hidden = state.hidden;
    hud.pieces.push_back(std::move(row));
  }
  if (asking_ != Asking::kNothing) {
    hud.banner =
        HudBanner{.kind = HudBanner::Kind::kQuestion,
                  .text = asking_ == Asking::kDistance
                              ? fmt::format(fmt::runtime(Tr("Distance: click point {} of 2")), points_.size() + 1)
                              : fmt::format(fmt::runtime(Tr("Angle at the second point: click point {} of 3")),
                                            points_.size() + 1),
                  .answers = Tr("left click   Esc: cancel")};
  } else if (!measured_.empty()) {
    hud.banner = HudBanner{
        .kind = HudBanner::Kind::kQuestion, .text = measured_, .answers = Tr("D: measure again   Esc: end measuring")};
  }
  if (menu_) hud.menu = menu_->Show();
}

std::vector<HudKeyGroup> PiecesMode::help() {
  return {{Tr("Moving pieces"),
           {{Tr("click"), Tr("pick a piece")},
            {Tr("left drag"), Tr("move it; with Shift into the picture")},
            {Tr("Ctrl + left drag"), Tr("turn it")},
            {Tr("arrows, PgUp PgDn"), Tr("move it by 0.5 mm")},
            {"Q  E", Tr("turn it by 1 degree")}}}};
}

void PiecesMode::Describe(nlohmann::json& state) const {
  if (!pieces_ || splitting_.valid()) {
    state["pieces"] = nullptr;
    return;
  }
  nlohmann::json list = nlohmann::json::array();
  for (int i = 0; i < pieces_->size(); ++i) {
    const PieceState& s = pieces_->state(i);
    const Vec3 moved = s.deleted ? Vec3{0} : pieces_->CalcCentroid(i) - pieces_->piece(i).centroid_P;
    list.push_back({{"name", pieces_->piece(i).name},
                    {"hidden", s.hidden},
                    {"deleted", s.deleted},
                    {"moved_mm", std::round(100 * glm::length(moved)) / 100},
                    {"turned_deg", std::round(100 * CalcRotationAngle(s.X_WP)) / 100}});
  }
  state["pieces"] = std::move(list);
  state["selected"] = selected_;
  state["measured"] = nlohmann::json::array();
  for (const Measure& m : measures_) {
    if (m.now) state["measured"].push_back(std::round(100 * m.now->value) / 100);
  }
  state["measuring"] = asking_ != Asking::kNothing || !measured_.empty();
}

}  // namespace kerf
