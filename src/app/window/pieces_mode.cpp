#include "app/window/pieces_mode.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <exception>
#include <utility>

#include "app/window/is_ready.h"
#include "bone/pieces/measure.h"
#include "kerf/error.h"
#include "view/ui/translate.h"

namespace kerf {
namespace {

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

bool PiecesMode::is_ready() const {
  return entered_ && pieces_ && !splitting_.valid();
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
