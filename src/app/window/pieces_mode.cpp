#include "app/window/pieces_mode.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <exception>
#include <utility>

#include "app/window/is_ready.h"
#include "app/window/moved_marks.h"
#include "bone/pieces/measure.h"
#include "kerf/error.h"
#include "view/ui/translate.h"

namespace kerf {
namespace {

// A software renderer needs 0.2 us per triangle: the drawn surface is coarser than the measured one.
constexpr std::size_t kMaxTriangles = 200'000;

constexpr double kMaxGap_mm = 20;        // larger gaps are not searched for
constexpr double kLeastOverlap_mm3 = 1;  // that the user is warned of

bool IsSame(const PieceState& a, const PieceState& b) {
  return a.deleted == b.deleted && a.X_WP.p_AB == b.X_WP.p_AB && a.X_WP.R_AB == b.X_WP.R_AB;
}

/// Returns how two pieces lie to each other, for the user.
std::string DescribeContact(const PieceContact& contact) {
  if (contact.overlap_mm3 > 0) {
    return fmt::format(fmt::runtime(Tr("overlap {}")), ShowVolume(contact.overlap_mm3));
  }
  return contact.gap ? fmt::format(fmt::runtime(Tr("gap {} mm")), ShowNumber(contact.gap->gap_mm, 2))
                     : std::string(Tr("apart"));
}

}  // namespace

PiecesMode::Contacts PiecesMode::CalcAllContacts(const PieceSet& pieces, const Contacts& before) {
  const auto count = static_cast<std::size_t>(pieces.size());
  Contacts contacts{.with = std::vector<std::vector<PieceContact>>(count), .at = {}};
  for (int i = 0; i < pieces.size(); ++i) contacts.at.push_back(pieces.state(i));
  const auto stays = [&](std::size_t i) { return i < before.at.size() && IsSame(contacts.at[i], before.at[i]); };
  for (std::size_t i = 0; i < count; ++i) {
    for (std::size_t other = i + 1; other < count; ++other) {
      if (contacts.at[i].deleted || contacts.at[other].deleted) continue;
      const auto number = static_cast<int>(other);
      PieceContact contact;
      if (stays(i) && stays(other)) {
        contact = *std::find_if(before.with[i].begin(), before.with[i].end(),
                                [&](const PieceContact& c) { return c.other == number; });
      } else {
        contact = pieces.CalcContact(static_cast<int>(i), number, kMaxGap_mm);
      }
      contacts.with[i].push_back(contact);
      contact.other = static_cast<int>(i);
      contacts.with[other].push_back(contact);
    }
  }
  return contacts;
}

void PiecesMode::Enter() {
  entered_ = true;
  viewer_.view().ClearTool();
  viewer_.view().SetGhost(std::nullopt);
  viewer_.view().SetForce(std::nullopt);
  const std::uint64_t changes = viewer_.session()->figures().changes;
  if (is_up_to_date()) {
    ShowInPicture();
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

/// Returns true if the positions of earlier pieces are still the latest ones: those after them were neither moved nor
/// measured.
bool PiecesMode::uses_earlier() const {
  return !earlier_json_.empty() && (!pieces_ || (pieces_->actions().empty() && measurements_.empty()));
}

std::string PiecesMode::FormatArrangement() const {
  return uses_earlier() || !pieces_ ? earlier_json_ : pieces_->FormatJson();
}

const std::vector<MeasuredPoints>& PiecesMode::measurements() const {
  return uses_earlier() ? earlier_measurements_ : measurements_;
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
  describes_ = false;
  menu_.reset();
  HideInPicture();
  if (LiveSession* session = viewer_.session()) viewer_.view().SetTool(MakeTool(session->scene()));
}

void PiecesMode::ShowInPicture(bool with_selection) {
  viewer_.view().set_bone_hidden(true);
  Show(with_selection);
}

void PiecesMode::HideInPicture() {
  viewer_.view().SetPieces({});
  viewer_.view().SetMeasures({});
  viewer_.view().set_bone_hidden(false);
}

void PiecesMode::Reset() {
  splitting_ = {};
  finding_ = {};
  pieces_.reset();
  unsaved_ = false;
  earlier_json_.clear();
  meshes_.clear();
  contacts_.reset();
  latest_contacts_ = {};
  points_.clear();
  measured_.clear();
  measurements_.clear();
  earlier_measurements_.clear();
  session_ = 0;
  selected_ = axis_ = -1;
  stale_ = false;
}

void PiecesMode::TakeSplit() {
  Split split = splitting_.get();
  finding_ = {};  // of the pieces before
  latest_contacts_ = {};
  const bool earlier = uses_earlier();
  pieces_ = std::move(split.pieces);
  meshes_ = std::move(split.meshes);
  if (split.not_restored.empty()) {
    if (earlier) measurements_ = std::move(earlier_measurements_);
    earlier_measurements_.clear();
  } else if (!earlier) {
    earlier_measurements_ = std::exchange(measurements_, {});
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
    latest_contacts_ = finding_.get();
    if (selected_ >= 0 && !stale_) {
      contacts_ = latest_contacts_;
      for (const PieceContact& contact : contacts_->with[static_cast<std::size_t>(selected_)]) {
        viewer_.trace().Write("contact", {{"piece", pieces_->piece(selected_).name},
                                          {"other", pieces_->piece(contact.other).name},
                                          {"overlap_mm3", contact.overlap_mm3},
                                          {"gap_mm", contact.gap ? nlohmann::json(contact.gap->gap_mm) : nullptr}});
      }
      if (std::exchange(describes_, false) && !pieces_->state(selected_).deleted) {
        viewer_.Say(DescribePiece(selected_));
      }
    }
  }
  if (stale_ && !finding_.valid() && !dragging_ && pieces_) {
    stale_ = false;
    finding_ = std::async(std::launch::async,
                          [pieces = pieces_, before = latest_contacts_] { return CalcAllContacts(*pieces, before); });
  }
}

std::optional<Vec3> PiecesMode::axis() const {
  if (axis_ < 0) return std::nullopt;
  Vec3 axis{0};
  axis[axis_] = 1;
  return axis;
}

void PiecesMode::Show(bool with_selection) {
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
    shape.selected = with_selection && i == selected_;
    shape.hidden = state.hidden;
    shapes.push_back(std::move(shape));
  }
  viewer_.view().SetPieces(shapes);
  ShowMeasures();
}

void PiecesMode::MoveMarks(std::vector<MarkOverlay> marks) {
  MovedMarks moved =
      pieces_ && !splitting_.valid() ? kerf::MoveMarks(*pieces_, marks) : MovedMarks{std::move(marks), false};
  marks_left_out_ = moved.left_out;
  viewer_.view().SetMarks(moved.marks);
}

void PiecesMode::Changed() {
  contacts_.reset();
  stale_ = true;
  ++gesture_;
  Show();
}

void PiecesMode::Select(int piece) {
  selected_ = piece;
  describes_ = true;
  Changed();
}

void PiecesMode::SelectNext(int by) {
  const int count = pieces_->size();
  if (count == 0) return;
  for (int tried = 0; tried < count; ++tried) {
    selected_ = (selected_ + by + count) % count;
    if (!pieces_->state(selected_).deleted) break;
  }
  describes_ = true;
  Changed();
}

std::string PiecesMode::DescribeMotion(int i) const {
  const double moved_mm = glm::length(pieces_->CalcCentroid(i) - pieces_->piece(i).centroid_P);
  const double turned_deg = CalcRotationAngle(pieces_->state(i).X_WP);
  if (moved_mm <= 0.005 && turned_deg <= 0.05) return {};
  return fmt::format(fmt::runtime(Tr("moved {} mm, turned {}°")), ShowNumber(moved_mm, 1), ShowNumber(turned_deg, 1));
}

double PiecesMode::CalcOverlap(int i) const {
  double largest_mm3 = 0;
  for (const PieceContact& contact : latest_contacts_.with[static_cast<std::size_t>(i)]) {
    largest_mm3 = std::max(largest_mm3, contact.overlap_mm3);
  }
  return largest_mm3;
}

std::string PiecesMode::DescribePiece(int i) const {
  const Piece& piece = pieces_->piece(i);
  std::string words = fmt::format("{}: {}", ShowName(piece.name), ShowVolume(piece.volume_mm3));
  if (const std::string moved = DescribeMotion(i); !moved.empty()) words += ", " + moved;
  if (!contacts_) return words;
  for (const PieceContact& contact : contacts_->with[static_cast<std::size_t>(i)]) {
    words += fmt::format(fmt::runtime(Tr(", {} with {}")), DescribeContact(contact),
                         ShowName(pieces_->piece(contact.other).name));
  }
  return words;
}

std::string PiecesMode::DescribeNearest(int i) const {
  if (pieces_->size() == 1) return "";
  if (!contacts_) return "\u2026";
  const PieceContact* nearest = nullptr;
  for (const PieceContact& contact : contacts_->with[static_cast<std::size_t>(i)]) {
    if (contact.overlap_mm3 <= 0 && !contact.gap) continue;
    const bool nearer = nearest == nullptr || contact.overlap_mm3 > nearest->overlap_mm3 ||
                        (nearest->overlap_mm3 <= 0 && contact.gap->gap_mm < nearest->gap->gap_mm);
    if (nearer) nearest = &contact;
  }
  if (nearest == nullptr) return Tr("apart");
  return fmt::format(fmt::runtime(Tr("{} with {}")), DescribeContact(*nearest),
                     ShowName(pieces_->piece(nearest->other).name));
}

void PiecesMode::Fill(HudState& hud) {
  hud.show_plot = false;
  hud.show_values = false;
  if (splitting_.valid()) {
    hud.progress = HudProgress{.title = Tr("Pieces"), .stage = Tr("splitting the bone"), .fraction = {}};
    return;
  }
  if (!pieces_) return;
  bool overlap = false;
  for (int i = 0; i < pieces_->size(); ++i) {
    const PieceState& state = pieces_->state(i);
    if (state.deleted) continue;
    HudPiece row;
    row.name = ShowName(pieces_->piece(i).name);
    row.detail = ShowVolume(pieces_->piece(i).volume_mm3);
    row.contact = DescribeNearest(i);
    row.tip = DescribePiece(i);
    row.moved = DescribeMotion(i);
    row.overlaps = contacts_ && CalcOverlap(i) > kLeastOverlap_mm3;
    overlap = overlap || row.overlaps;
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
    hud.banner = HudBanner{.kind = HudBanner::Kind::kQuestion,
                           .text = DescribeLast(),
                           .answers = Tr("D: measure again   Esc: end measuring")};
  }
  if (!hud.banner && overlap) {
    hud.banner = HudBanner{.kind = HudBanner::Kind::kWarning,
                           .text = Tr("Pieces overlap: bone cannot be in one place twice."),
                           .answers = Tr("Ctrl+Z: undo the motion")};
  } else if (!hud.banner && marks_left_out_) {
    hud.banner =
        HudBanner{.kind = HudBanner::Kind::kNotice,
                  .text = Tr("Parts of marks outside the bone are hidden: they belong to no piece that moves."),
                  .answers = ""};
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
  state["piece_rows"] = nlohmann::json::array();
  for (int i = 0; i < pieces_->size(); ++i) {
    const PieceState& s = pieces_->state(i);
    if (!s.deleted) {
      state["piece_rows"].push_back(
          fmt::format("{}; {}", ShowVolume(pieces_->piece(i).volume_mm3), DescribeNearest(i)));
    }
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
  state["measurement_labels"] = nlohmann::json::array();
  for (const MeasuredPoints& points : measurements_) {
    const std::optional<PieceMeasure> now = MeasurePieces(*pieces_, points);
    if (!now) continue;
    state["measured"].push_back(std::round(100 * now->value) / 100);
    state["measurement_labels"].push_back(MakeLabel(*now));
  }
  state["measuring"] = asking_ != Asking::kNothing || !measured_.empty();
}

}  // namespace kerf
