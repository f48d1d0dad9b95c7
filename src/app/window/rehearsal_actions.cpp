// Keys and menus of a rehearsal.
#include <fmt/format.h>

#include <cstddef>
#include <utility>

#include "app/window/import_notes.h"
#include "app/window/rehearsal.h"
#include "app/window/saw_details.h"
#include "kerf/error.h"
#include "view/picture/tool_icon.h"
#include "view/ui/translate.h"

namespace kerf {
namespace {

constexpr std::size_t kSawKeys = 9;  // 1 to 9

EntryDetails DescribeSawEntry(const Saw& saw) {
  return {.numbers = ShowSawNumbers(saw), .tip = ShowSawSource(saw), .picture = [&saw](int width, int height) {
            return DrawToolIcon(saw.tool.shape, width, height);
          }};
}

}  // namespace

void Rehearsal::AddActions(ActionList& actions) {
  const auto running = [this] { return viewer_->is_running() && !change_.is_pending(); };
  const auto cutting = [this, running] { return running() && cuts(); };
  // Points or a threshold are asked for about another case, in front of the open one.
  const auto shown = [this] { return !asks_about_ct(); };
  const auto in_pieces = [this, shown] { return in_pieces_ && pieces_.is_ready() && shown(); };
  const auto work_shown = [this, shown] { return has_work() && shown(); };
  const auto either = [cutting, in_pieces] { return cutting() || in_pieces(); };
  // ---- file
  actions.Add(
      {.id = "file.open",
       .menu = Msg("File"),
       .label = Msg("Open a project, a bone, a scene or a CT"),
       .shortcut = {.key = Key::kO, .control = true},
       .tip = Msg(
           "A project, a scene, a .vdb bone, a surface, a CT file or a folder with a DICOM series; or drop it here"),
       .run = [this] { AskOpen(); },
       .button = Msg("Open")});
  recent_ = viewer_->settings().recent;
  for (std::size_t i = 0; i < recent_.size(); ++i) {
    actions.Add({.id = fmt::format("file.recent.{}", i + 1),
                 .menu = Msg("File"),
                 .label = recent_[i].c_str(),
                 .run = [this, i] { Open(recent_[i]); },
                 .begins_group = i == 0});
  }
  actions.Add(
      {.id = "file.save",
       .menu = Msg("File"),
       .label = Msg("Save the project"),
       .shortcut = {.key = Key::kS, .control = true},
       .tip = Msg("One file with bone, plan, marks, recordings, pieces and views; asks for its place the first time"),
       .run = [this] { SaveProject(false); },
       .enabled = work_shown,
       .button = Msg("Save")});
  actions.Add({.id = "file.save_as",
               .menu = Msg("File"),
               .label = Msg("Save the project as"),
               .shortcut = {.key = Key::kS, .control = true, .shift = true},
               .run = [this] { AskProjectFile(false); },
               .enabled = work_shown});
  actions.Add({.id = "file.export",
               .menu = Msg("File"),
               .label = Msg("Export pieces, planes and report"),
               .shortcut = {Key::kF9},
               .tip = Msg("Writes the pieces as surfaces, the planned and achieved planes, and a report"),
               .run = [this] { Export(); },
               .enabled = [this, work_shown] { return work_shown() && !writer_.is_exporting(); },
               .button = Msg("Export")});
  // ---- edit
  actions.Add({.id = "edit.undo",
               .menu = Msg("Edit"),
               .label = Msg("Undo"),
               .shortcut = {.key = Key::kZ, .control = true},
               .run = [this] { Undo(); },
               .enabled = either,
               .button = Msg("Undo")});
  actions.Add({.id = "edit.redo",
               .menu = Msg("Edit"),
               .label = Msg("Redo"),
               .shortcut = {.key = Key::kY, .control = true},
               .run = [this] { in_pieces_ ? pieces_.Redo() : GoForward(); },
               .enabled = either,
               .button = Msg("Redo")});
  actions.Add({.id = "edit.redo_too",
               .menu = "",
               .shortcut = {.key = Key::kZ, .control = true, .shift = true},
               .run = [this] { in_pieces_ ? pieces_.Redo() : GoForward(); },
               .enabled = either});
  actions.Add({.id = "edit.checkpoint",
               .menu = Msg("Edit"),
               .label = Msg("Make a checkpoint with a name"),
               .shortcut = {Key::kC},
               .run = [this] { in_pieces_ ? pieces_.AskCheckpoint() : RequestCheckpoint(); },
               .enabled = either,
               .button = Msg("Checkpoint")});
  actions.Add({.id = "edit.back",
               .menu = Msg("Edit"),
               .label = Msg("Return to a checkpoint"),
               .shortcut = {Key::kB},
               .run = [this] { in_pieces_ ? pieces_.ShowCheckpoints() : ShowCheckpoints(); },
               .enabled = either});
  // ---- saws
  for (std::size_t i = 0; i < options_.saws.size(); ++i) {
    Action saw{.id = fmt::format("saw.{}", i + 1),
               .menu = Msg("Saw"),
               .label = options_.saws[i].name.c_str(),
               .run = [this, i] { SelectSaw(i); },
               .enabled = cutting,
               .on = [this, i] { return IsUsed(i); },
               .details = [&saw = options_.saws[i]] { return DescribeSawEntry(saw); },
               .begins_group = i == 0};
    if (i < kSawKeys) saw.shortcut.key = static_cast<Key>('1' + i);
    actions.Add(std::move(saw));
  }
  actions.Add({.id = "saw.next",
               .menu = Msg("Saw"),
               .label = Msg("Next saw"),
               .shortcut = {Key::kTab},
               .run = [this] { SelectSaw(choice_.saw_is_listed ? (choice_.saw + 1) % options_.saws.size() : 0); },
               .enabled = cutting});
  // ---- plan
  actions.Add({.id = "plan.show",
               .menu = Msg("Plan"),
               .label = Msg("Plan: planes and depth stops"),
               .shortcut = {Key::kN},
               .run = [this] { ShowPlanMenu(); },
               .enabled = cutting,
               .button = Msg("Plan")});
  actions.Add({.id = "plan.guide",
               .menu = Msg("Plan"),
               .label = Msg("Guide the saw along the plan"),
               .shortcut = {Key::kG},
               .tip = Msg("Holds the saw in the planned plane and above the depth stop"),
               .run = [this] { ToggleGuide(); },
               .enabled = [this, cutting] { return cutting() && !viewer_->is_turning(); },
               .on = [this] { return choice_.guided; },
               .indicator = Msg("Guide")});
  editor_.actions.Add(actions, [cutting, this] { return cutting() || (viewer_->is_running() && menu_.has_value()); });
  // ---- pieces
  actions.Add({.id = "pieces.enter",
               .menu = Msg("Pieces"),
               .label = Msg("Work with the pieces, or return to cutting"),
               .shortcut = {Key::kP},
               .tip = Msg("Splits the bone where it is cut through; pieces can be moved, hidden and measured"),
               .run = [this] { in_pieces_ ? LeavePieces() : EnterPieces(); },
               .enabled = [this, cutting, shown] { return cutting() || (in_pieces_ && shown()); },
               .on = [this, shown] { return in_pieces_ && shown(); },
               .button = Msg("Pieces")});
  pieces_.AddActions(actions, shown);
  // ---- help
  actions.Add({.id = "help.import",
               .menu = Msg("Help"),
               .label = Msg("Notes on the import"),
               .tip = Msg("Assumptions that were made when the CT was read, and its expected accuracy"),
               .run = [this] { ShowImportNotes(); },
               .enabled = [running, this] { return running() && !GetNote(*before_, "import_input").empty(); }});
}

void Rehearsal::AskOpen() {
  viewer_->controls().Release();
  std::vector<std::string> extensions = ListInputExtensions();
  if (viewer_->is_running()) extensions.emplace_back(".mrk.json");
  viewer_->dialogs().ChooseFile(viewer_->ui(),
                                Tr("Open a project, a bone, a scene, a surface, a CT, or a folder with a DICOM series"),
                                FindRecentFolder(viewer_->settings()), std::move(extensions), false, "",
                                [this](const std::string& path) { Open(path); });
  viewer_->dialogs().AllowFolder();  // of a DICOM series
  viewer_->dialogs().OfferRecent(viewer_->settings().recent);
}

void Rehearsal::ShowPlanMenu() {
  // The same entries as in the menu, with numbers.
  std::vector<MenuItem> items;
  for (const char* id : {"plan.three_points", "plan.at_blade", "plan.stop", "plan.align", "plan.next", "plan.remove",
                         "plan.mirror", "mark.nerve", "mark.tooth"}) {
    const Action* action = viewer_->actions().Find(id);
    items.push_back(
        {.name = Tr(action->label), .detail = Tr(action->tip), .enabled = action->is_enabled(), .choose = action->run});
  }
  SetMenu(Menu(Tr("Plan"), std::move(items)));
}

void Rehearsal::ShowCheckpoints() {
  std::vector<MenuItem> items;
  for (auto name = checkpoints_.rbegin(); name != checkpoints_.rend(); ++name) {
    items.push_back({.name = *name, .detail = "", .choose = [this, back = *name] { GoBack(back); }});
  }
  SetMenu(Menu(Tr("Go back to"), std::move(items)));
}

void Rehearsal::SetMenu(Menu menu) {
  viewer_->controls().Release();
  menu_ = std::move(menu);
}

void Rehearsal::PickMenuRow(int row) {
  if (in_pieces_) return pieces_.PickMenuRow(row);
  if (!menu_ || menu_->Pick(row) != Menu::State::kChosen) return;
  ChooseFromMenu(*std::exchange(menu_, std::nullopt));
}

void Rehearsal::ChooseFromMenu(const Menu& menu) {
  if (!menu.chosen().choose) return;
  try {
    menu.chosen().choose();
  } catch (const Error& e) {
    viewer_->Say(e.what());
  }
}

std::vector<HudKeyGroup> Rehearsal::help() const {
  return in_pieces_ ? PiecesMode::help() : std::vector<HudKeyGroup>();
}

std::vector<TourStep> Rehearsal::tour() const {
  return {
      {Tr("Look around"), Tr("Drag with the right mouse button to turn the bone, turn the wheel to zoom. "
                             "V shows the next side, T makes the bone translucent.")},
      {Tr("Open your own CT"), Tr("File > Open reads a folder with a DICOM series, a CT file, a surface or a bone. "
                                  "You can also drop it into this window.")},
      {Tr("Plan a cut"), Tr("Plan > Plane through three points: click three points on the bone. G then guides the "
                            "saw along the plane.")},
      {Tr("Cut"),
       Tr("Space starts the saw. Drag with the left mouse button to move it, with Shift into the picture, "
          "with Ctrl to turn it. Release the button, and the saw stays where it is; Space stops the spindle.")},
      {Tr("Undo"),
       Tr("Ctrl+Z takes back the last stroke of the saw. R brings the saw back into view while the spindle is off.")},
      {Tr("Pieces and results"), Tr("P splits the bone where it is cut through, and lets you move and measure the "
                                    "pieces. F9 exports pieces, planes and a report.")}};
}

}  // namespace kerf
