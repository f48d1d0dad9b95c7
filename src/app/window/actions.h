// Everything the user can do by a key, a menu, a button or an indicator, listed once.
#pragma once

#include <functional>
#include <map>
#include <string>
#include <vector>

#include "view/picture/image.h"
#include "view/ui/event.h"
#include "view/ui/hud.h"
#include "view/ui/ui.h"

namespace kerf {

struct Shortcut {
  Key key = Key::kNone;
  bool control = false;
  bool shift = false;

  bool operator==(const Shortcut&) const = default;
};
/// Returns the name of the keys as shown to the user, in the current language: "Ctrl+Z"; empty for kNone.
std::string ShowShortcut(const Shortcut& shortcut);

/// What an entry of a menu says of the thing that it chooses.
struct EntryDetails {
  std::string numbers;  // behind the label
  std::string tip;      // instead of the action's
  /// Draws a picture before the label, of this size in pixels.
  std::function<Image(int width, int height)> picture;
};

/// Texts are literals in English, marked with Mark(), and translated when they are shown.
struct Action {
  std::string id;                                   // "saw.spindle"; for tests
  const char* menu = "";                            // menu that contains it; empty: none
  const char* label = "";                           // in the menu and in the help
  Shortcut shortcut{};                              // optional
  const char* tip = "";                             // explanation, shown as a tooltip
  const char* when = "";                            // state of the activity, for the help; empty: any
  std::function<void()> run;                        // in the window's thread
  std::function<bool()> enabled = nullptr;          // null: always
  std::function<bool()> on = nullptr;               // state of a mode; null: not a mode
  std::function<bool()> relevant = nullptr;         // if false, button and indicator are not shown; null: always
  const char* button = "";                          // label of its button in the toolbar; empty: none
  const char* indicator = "";                       // name of its indicator in the status line; empty: none
  std::function<const char*()> state = nullptr;     // what the indicator says instead of on or off, unless it is null
  bool repeats = false;                             // also while the key is held
  std::function<EntryDetails()> details = nullptr;  // of its entry in the menu; null: none
  bool begins_group = false;                        // a line separates it from the previous entry of the menu

  bool is_enabled() const { return !enabled || enabled(); }
  bool is_relevant() const { return !relevant || relevant(); }
};

/// Returns the title of a menu's keys in the help.
std::string ShowKeyGroup(const char* menu, const char* when);

/// List of actions. A key may belong to several actions of which at most one is enabled at a time.
class ActionList {
 public:
  void Add(Action action);
  /// Runs the enabled action of a pressed key. Returns true if an action has this key, even if none is enabled.
  bool Take(const WindowEvent& event);
  /// Returns true if the key belongs to actions, none of which is enabled now.
  bool IsDisabled(const WindowEvent& event) const;
  const Action* Find(const std::string& id) const;
  /// Returns the keys by menu, for the help; also of actions that are not enabled now.
  std::vector<HudKeyGroup> ListKeys() const;

  /// Adds the menus to the current menu bar.
  void DrawMenus(Ui& ui);
  /// Adds the entries of one menu, for example to a context menu.
  void DrawEntries(Ui& ui, const char* menu);
  void DrawToolbar(Ui& ui);
  /// `reserved`: width at the right that is left free; indicators that do not fit are in a menu at the end. Returns the
  /// right edge of what was drawn.
  float DrawIndicators(Ui& ui, float reserved);
  /// Set while actions are only disabled for a short time: they can be chosen, and run once they are enabled.
  void set_waits(bool waits) { waits_ = waits; }
  /// Forgets what was chosen and still waits. Returns its names, for the user.
  std::vector<std::string> ForgetChosen();
  /// Runs what was chosen in a menu, in the toolbar or by an indicator in this frame. Called after the frame, because
  /// an action may show another panel.
  void RunChosen();

 private:
  void DrawEntryPicture(Ui& ui, const std::string& id, const EntryDetails& details);
  bool CanBeChosen(const Action& action) const { return waits_ || action.is_enabled(); }

  std::vector<Action> actions_;
  std::vector<std::size_t> chosen_;
  std::map<std::string, Image> pictures_;  // of entries, by the id of the action
  bool waits_ = false;
};

}  // namespace kerf
