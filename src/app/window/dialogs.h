// Dialogs of the window: a line of text, a question with answers, a file to open or to save.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "view/picture/image.h"
#include "view/ui/event.h"
#include "view/ui/ui.h"

namespace kerf {

/// At most one dialog is open; opening another one replaces it without a call. All texts are shown as given.
class Dialogs {
 public:
  /// Asks for a line of text. The initial text is selected. `done` receives it, or nullopt if the input was cancelled.
  void AskText(Ui& ui, const std::string& question, const std::string& initial,
               std::function<void(std::optional<std::string>)> done);
  /// Adds texts to choose from to the dialog that asks for a line of text and is open. `title`: above them.
  void OfferTexts(const std::string& title, std::vector<std::string> texts);
  /// Lets the dialog that asks for a line of text stay open as long as `check` returns a sentence that says what is
  /// wrong with the text, rather than an empty one.
  void CheckText(std::function<std::string(const std::string&)> check) { text_check_ = std::move(check); }
  struct Answer {
    std::string text;
    std::function<void()> run;  // optional
    Image picture{};            // optional
  };
  /// Asks a question. Enter gives the first answer, Escape the last. Answers with pictures are listed above the others,
  /// which are buttons.
  void Ask(const std::string& question, std::vector<Answer> answers);
  /// Lets Enter give no answer to the question that is open: nothing that is unclear is answered by a key alone.
  void IgnoreEnter() { enter_answers_ = false; }
  /// Asks for a file. `extensions`: of the files that are listed, with the dot, in lower case, and "" for names without
  /// one; empty: all. The user can list the other files too. `save`: the file may be a new one. `done` is called only
  /// if a file was chosen.
  void ChooseFile(Ui& ui, const std::string& title, const std::string& folder, std::vector<std::string> extensions,
                  bool save, const std::string& name, std::function<void(const std::string&)> done);
  /// Adds a button that chooses the shown folder itself, to the dialog that is open.
  void AllowFolder() { allows_folder_ = true; }
  /// The dialog that is open, which saves, asks for a folder: a new one in the folder shown, or one that exists.
  void ChooseFolder() { chooses_folder_ = allows_folder_ = true; }
  /// Adds a list of recent files and folders to the dialog that is open.
  void OfferRecent(std::vector<std::string> paths) { recent_ = std::move(paths); }

  bool is_open() const { return kind_ != Kind::kNone; }
  bool asks_text() const { return kind_ == Kind::kText || kind_ == Kind::kFile; }
  /// Consumes every key while a dialog is open.
  void Take(Ui& ui, const WindowEvent& event);
  void Draw(Ui& ui);
  /// Runs what the user has decided in this frame. Called after the frame.
  void RunDecided();

 private:
  enum class Kind { kNone, kText, kQuestion, kFile };
  void Close();
  void Decide(std::function<void()> what);
  /// Gives the input to the line of a dialog that stays open. Keys wait until it has it.
  void TakeLineAgain(Ui& ui);
  /// Draws the answers that have pictures. Returns the one that was clicked.
  std::optional<std::size_t> DrawPictured(Ui& ui, float height) const;
  void DecideText();
  void DecideFile();
  void ListFolder();
  void MakeFolder();

  Kind kind_ = Kind::kNone;
  bool fresh_ = false;  // its line of text has not had the input yet
  std::string question_;
  std::string text_;
  std::size_t max_text_ = 0;
  std::function<void(std::optional<std::string>)> text_done_;
  std::function<std::string(const std::string&)> text_check_;  // optional
  std::string offered_title_;
  std::vector<std::string> offered_;
  std::vector<Answer> answers_;
  bool enter_answers_ = true;
  std::uint64_t questions_ = 0;  // so far
  std::vector<std::string> extensions_;
  bool save_ = false;
  bool allows_folder_ = false;
  bool chooses_folder_ = false;
  bool all_files_ = false;    // lists files of all extensions
  std::size_t left_out_ = 0;  // files that are not listed
  std::string folder_;
  std::vector<std::string> folders_, files_;
  std::string new_folder_;  // name that is being typed
  std::vector<std::string> recent_;
  std::string fault_;
  std::function<void(const std::string&)> file_done_;
  std::function<void()> decided_;
};

}  // namespace kerf
