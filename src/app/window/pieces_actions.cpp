// Entries of the menu of pieces, undo and checkpoints.
#include <fmt/format.h>

#include <array>
#include <utility>

#include "app/window/pieces_mode.h"
#include "kerf/error.h"
#include "view/ui/translate.h"

namespace kerf {
namespace {

constexpr std::array<const char*, 3> kAxes{Msg("left - right"), Msg("front - back"), Msg("up - down")};

}  // namespace

void PiecesMode::AddActions(ActionList& actions, const std::function<bool()>& shown) {
  const auto ready = [this, shown] { return is_ready() && !menu_ && shown(); };
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
                     unsaved_ = unsaved_ || !measurements_.empty();
                     measurements_.clear();
                     EndMeasuring();
                   },
               .enabled = ready});
}

void PiecesMode::Do(const std::function<void()>& change) {
  // Before pieces are changed, wait until no other thread reads them.
  if (finding_.valid()) finding_.wait();
  unsaved_ = true;
  measured_.clear();
  try {
    change();
  } catch (const Error& e) {
    describes_ = false;
    viewer_.Say(e.what());
  }
  Changed();
}

void PiecesMode::Undo() {
  describes_ = false;
  Do([this] {
    if (!pieces_->Undo()) viewer_.Say(Tr("There is nothing to undo"));
  });
}

void PiecesMode::Redo() {
  describes_ = false;
  Do([this] {
    if (!pieces_->Redo()) viewer_.Say(Tr("There is nothing to redo"));
  });
}

void PiecesMode::AskCheckpoint() {
  viewer_.AskText(Tr("Name of the checkpoint:"), fmt::format("pieces {}", pieces_->checkpoints().size() + 1),
                  [this](const std::optional<std::string>& name) {
                    if (!name || name->empty()) return;
                    if (finding_.valid()) finding_.wait();
                    pieces_->Checkpoint(*name);
                    unsaved_ = true;
                    viewer_.Say(fmt::format(fmt::runtime(Tr("Checkpoint: {}")), *name));
                  });
}

void PiecesMode::ShowCheckpoints() {
  std::vector<MenuItem> items;
  for (const std::string& name : pieces_->checkpoints()) {
    items.push_back({.name = name, .detail = "", .enabled = true, .choose = [this, name] {
                       Do([this, name] { pieces_->GoTo(name); });
                     }});
  }
  if (items.empty()) return viewer_.Say(Tr("There is no checkpoint of the pieces yet; press C to make one"));
  menu_.emplace(Tr("Return pieces to"), std::move(items));
}

}  // namespace kerf
