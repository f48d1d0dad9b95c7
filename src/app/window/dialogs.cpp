#include "app/window/dialogs.h"

#include <fmt/format.h>
#include <imgui.h>
#include <imgui_stdlib.h>

#include <algorithm>
#include <cctype>
#include <filesystem>
#include <utility>

#include "view/ui/translate.h"
#include "view/ui/widgets.h"

namespace kerf {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kMaxText = 200;
constexpr std::size_t kMaxPath = 1000;
/// Number of offered texts that are visible at once.
constexpr std::size_t kOfferedRows = 6;
constexpr float kPictureSide = 96;  // of an answer, points

/// A number behind a point is part of a name, such as that of a DICOM file, "1.2.840.7".
bool HasExtension(const std::string& name) {
  const std::string extension = fs::path(name).extension().string();
  return std::any_of(extension.begin(), extension.end(), [](unsigned char c) { return std::isalpha(c) != 0; });
}

}  // namespace

void Dialogs::AskText(Ui& ui, const std::string& question, const std::string& initial,
                      std::function<void(std::optional<std::string>)> done) {
  Close();
  kind_ = Kind::kText;
  fresh_ = true;
  question_ = question;
  text_ = initial;
  max_text_ = std::max(kMaxText, 2 * initial.size());
  text_done_ = std::move(done);
  text_check_ = nullptr;
  offered_.clear();
  ui.ExpectText(true);
}

void Dialogs::OfferTexts(const std::string& title, std::vector<std::string> texts) {
  offered_title_ = title;
  offered_ = std::move(texts);
}

void Dialogs::Ask(const std::string& question, std::vector<Answer> answers) {
  Close();
  kind_ = Kind::kQuestion;
  fresh_ = true;
  question_ = question;
  answers_ = std::move(answers);
  enter_answers_ = true;
  ++questions_;
}

void Dialogs::ChooseFile(Ui& ui, const std::string& title, const std::string& folder,
                         std::vector<std::string> extensions, bool save, const std::string& name,
                         std::function<void(const std::string&)> done) {
  Close();
  kind_ = Kind::kFile;
  fresh_ = true;
  question_ = title;
  extensions_ = std::move(extensions);
  max_text_ = kMaxPath;
  save_ = save;
  allows_folder_ = all_files_ = chooses_folder_ = false;
  new_folder_.clear();
  recent_.clear();
  std::error_code error;
  folder_ = fs::canonical(folder.empty() ? "." : folder, error).string();
  if (error) folder_ = fs::current_path(error).string();
  text_ = name;
  file_done_ = std::move(done);
  ListFolder();
  ui.ExpectText(true);
}

void Dialogs::Close() {
  kind_ = Kind::kNone;
  fault_.clear();
  answers_.clear();
}

void Dialogs::Decide(std::function<void()> what) {
  decided_ = std::move(what);
  Close();
}

void Dialogs::TakeLineAgain(Ui& ui) {
  fresh_ = true;
  ui.DropText();
  ui.ExpectText(false);  // the second click of a double click must not come late
}

void Dialogs::DecideText() {
  fault_ = text_check_ ? text_check_(text_) : "";
  if (!fault_.empty()) return;
  Decide([done = std::exchange(text_done_, nullptr), text = text_] { done(text); });
}

void Dialogs::ListFolder() {
  folders_.clear();
  files_.clear();
  left_out_ = 0;
  std::error_code error;
  for (const auto& entry : fs::directory_iterator(folder_, error)) {
    const std::string name = entry.path().filename().string();
    if (name.empty() || name.front() == '.') continue;
    if (entry.is_directory(error)) {
      folders_.push_back(name);
      continue;
    }
    std::string lower = name;
    std::transform(lower.begin(), lower.end(), lower.begin(), [](unsigned char c) { return std::tolower(c); });
    const bool fits =
        extensions_.empty() || std::any_of(extensions_.begin(), extensions_.end(), [&](const std::string& extension) {
          return extension.empty() ? !HasExtension(lower) : lower.ends_with(extension);
        });
    if (!fits) ++left_out_;
    if (fits || all_files_) files_.push_back(name);
  }
  if (error) fault_ = fmt::format("{}: {}", folder_, error.message());
  std::sort(folders_.begin(), folders_.end());
  std::sort(files_.begin(), files_.end());
}

void Dialogs::DecideFile() {
  if (text_.empty()) return;
  const fs::path path = fs::path(folder_) / text_;  // an absolute text replaces the folder
  std::error_code error;
  if (!save_ && !fs::exists(path, error)) {
    fault_ = fmt::format(fmt::runtime(Tr("{}: there is no such file or folder")), path.string());
    return;
  }
  if (save_ && !fs::exists(path.parent_path(), error)) {
    fault_ = fmt::format(fmt::runtime(Tr("{}: there is no such folder")), path.parent_path().string());
    return;
  }
  if (save_ && !chooses_folder_ && fs::is_directory(path, error)) {
    folder_ = fs::canonical(path, error).string();
    text_.clear();
    return ListFolder();
  }
  Decide([done = std::exchange(file_done_, nullptr), file = path.string()] { done(file); });
}

void Dialogs::MakeFolder() {
  const fs::path path = fs::path(folder_) / new_folder_;
  std::error_code error;
  fs::create_directory(path, error);
  if (error) {
    fault_ = fmt::format("{}: {}", path.string(), error.message());
    return;
  }
  fault_.clear();
  folder_ = fs::canonical(path, error).string();
  new_folder_.clear();
  ListFolder();
}

void Dialogs::Take(Ui& ui, const WindowEvent& event) {
  const bool down = event.kind == WindowEvent::Kind::kKeyDown;
  if (down && event.key == Key::kEscape) {
    if (kind_ == Kind::kText) {
      Decide([done = std::exchange(text_done_, nullptr)] { done(std::nullopt); });
    } else if (kind_ == Kind::kQuestion && !answers_.empty() && answers_.back().run) {
      Decide(answers_.back().run);
    } else {
      Close();
    }
    return;
  }
  if (down && event.key == Key::kEnter && kind_ == Kind::kQuestion) {
    if (!enter_answers_) return;
    if (!answers_.empty() && answers_.front().run) {
      Decide(answers_.front().run);
    } else {
      Close();
    }
    return;
  }
  ui.Take(event);
}

std::optional<std::size_t> Dialogs::DrawPictured(Ui& ui, float height) const {
  std::optional<std::size_t> given;
  const float side = kPictureSide * ui.scale();
  ImGui::BeginChild("pictured", {0, height}, true);
  for (std::size_t i = 0; i < answers_.size(); ++i) {
    const Answer& answer = answers_[i];
    if (answer.picture.width == 0) continue;
    ImGui::PushID(static_cast<int>(i));
    const ImVec2 at = ImGui::GetCursorPos();
    if (ImGui::Selectable("##answer", false, 0, {0, side + 2 * ui.scale()})) given = i;
    ui.Note(fmt::format("answer {}", i + 1));
    const ImVec2 after = ImGui::GetCursorPos();
    ImGui::SetCursorPos(at);
    ImGui::Image(ui.Texture(fmt::format("answer {}", i), answer.picture, questions_), {side, side});
    ImGui::SameLine();
    ImGui::BeginGroup();
    WrappedText(answer.text);
    ImGui::EndGroup();
    ImGui::SetCursorPos(after);
    ImGui::PopID();
  }
  ImGui::EndChild();
  return given;
}

void Dialogs::Draw(Ui& ui) {
  if (kind_ == Kind::kNone) return;
  const float s = ui.scale();
  const auto line = [&](const char* id) {
    if (fresh_) ImGui::SetKeyboardFocusHere();
    ImGui::SetNextItemWidth(-1);
    const bool entered =
        ImGui::InputText(id, &text_, ImGuiInputTextFlags_EnterReturnsTrue | ImGuiInputTextFlags_AutoSelectAll);
    if (text_.size() > max_text_) {
      std::size_t end = max_text_;
      while (end > 0 && (static_cast<unsigned char>(text_[end]) & 0xc0) == 0x80) --end;
      text_.resize(end);
    }
    ui.Note("dialog.text");
    // A window that appears in the same frame would take the input back.
    if (ImGui::IsItemActive()) fresh_ = false;
    return entered;
  };
  if (kind_ == Kind::kText) {
    // The offered texts scroll if there are many.
    const float row = ImGui::GetTextLineHeightWithSpacing();
    const float list = row * (static_cast<float>(std::min(offered_.size(), kOfferedRows)) + 0.5F);
    // The dialog is 12 points wider than its texts at either side.
    const float fault = fault_.empty() ? 0 : CalcWrappedHeight(fault_, 436 * s) + 6 * s;
    BeginDialog(ui, "ask text", 460 * s, 128 * s + fault + (offered_.empty() ? 0 : list + row));
    WrappedText(question_);
    bool done = line("##text");
    if (!fault_.empty()) {
      WrappedText(fault_);
      ui.Note("dialog.fault");
    }
    ImGui::Spacing();
    if (!offered_.empty()) {
      ImGui::TextUnformatted(offered_title_.c_str());
      const float buttons = ImGui::GetFrameHeightWithSpacing();
      ImGui::BeginChild("offered", {0, std::min(list, ImGui::GetContentRegionAvail().y - buttons)}, true);
      for (std::size_t i = 0; i < offered_.size(); ++i) {
        ImGui::PushID(static_cast<int>(i));
        if (ImGui::Selectable(offered_[i].c_str())) {
          text_ = offered_[i];
          done = true;
        }
        ui.Note(fmt::format("dialog.offered {}", i + 1));
        ImGui::PopID();
      }
      ImGui::EndChild();
    }
    done = ImGui::Button(Tr("OK")) || done;
    ui.Note("dialog.ok");
    ImGui::SameLine();
    const bool cancelled = ImGui::Button(Tr("Cancel"));
    ui.Note("dialog.cancel");
    ImGui::End();
    if (done) {
      DecideText();
      if (is_open()) TakeLineAgain(ui);
      return;
    }
    if (cancelled) Decide([cancel = std::exchange(text_done_, nullptr)] { cancel(std::nullopt); });
    return;
  }
  if (kind_ == Kind::kQuestion) {
    const float wrap = 480 * s;
    const float height = CalcWrappedHeight(question_, wrap);
    const auto pictured = static_cast<std::size_t>(
        std::count_if(answers_.begin(), answers_.end(), [](const Answer& a) { return a.picture.width > 0; }));
    const float list = pictured == 0 ? 0 : (kPictureSide + 10) * s * static_cast<float>(pictured) + 16 * s;
    BeginDialog(ui, "ask", 520 * s, height + list + 76 * s);
    WrappedText(question_);
    ImGui::Spacing();
    std::optional<std::size_t> given;
    if (pictured > 0) {
      given = DrawPictured(ui, std::min(list, ImGui::GetContentRegionAvail().y - ImGui::GetFrameHeightWithSpacing()));
    }
    for (std::size_t i = pictured; i < answers_.size(); ++i) {
      if (i > pictured) ImGui::SameLine();
      if (ImGui::Button(answers_[i].text.c_str())) given = i;
      ui.Note(fmt::format("answer {}", i + 1));
    }
    ImGui::End();
    if (given) Decide(answers_[*given].run ? answers_[*given].run : [] {});
    return;
  }
  BeginDialog(ui, "choose file", 640 * s, 460 * s);
  ImGui::PushFont(ui.bold());
  WrappedText(question_);
  ImGui::PopFont();
  WrappedText(folder_);
  bool done = false;
  const bool filters = !save_ && !extensions_.empty();
  const float fault_height =
      fault_.empty() ? 0
                     : CalcWrappedHeight(fault_, ImGui::GetContentRegionAvail().x) + ImGui::GetStyle().ItemSpacing.y;
  ImGui::BeginChild("files", {0, -(filters || save_ ? 106 : 78) * s - fault_height}, true);
  std::optional<std::string> enter;
  if (!recent_.empty()) {
    const bool open = ImGui::TreeNode(Tr("Recent files"));
    ui.Note("dialog.recent");
    for (std::size_t i = 0; open && i < recent_.size(); ++i) {
      if (ImGui::Selectable(recent_[i].c_str())) {
        text_ = recent_[i];
        done = true;
      }
      ui.Note(fmt::format("recent {}", i + 1));
    }
    if (open) ImGui::TreePop();
  }
  // One click enters a folder. The second click of a double click must not enter what is then under the mouse.
  const bool one_click = ImGui::GetIO().MouseClickedLastCount[0] == 1;
  if (ImGui::Selectable("..") && one_click) enter = "..";
  ui.Note("folder ..");
  for (const std::string& name : folders_) {
    if (ImGui::Selectable((name + "/").c_str()) && one_click) enter = name;
    ui.Note(fmt::format("folder {}", name));
  }
  for (const std::string& name : chooses_folder_ ? std::vector<std::string>() : files_) {
    if (ImGui::Selectable(name.c_str(), name == text_, ImGuiSelectableFlags_AllowDoubleClick)) {
      done = ImGui::IsMouseDoubleClicked(0) && name == text_;
      text_ = name;
    }
    ui.Note(fmt::format("file {}", name));
  }
  ImGui::EndChild();
  if (!fault_.empty()) {
    WrappedText(fault_);
  }
  if (save_) {
    ImGui::SetNextItemWidth(260 * s);
    ImGui::InputTextWithHint("##folder", Tr("name of a new folder"), &new_folder_);
    ui.Note("dialog.new_folder");
    ImGui::SameLine();
    ImGui::BeginDisabled(new_folder_.empty());
    if (ImGui::Button(Tr("Make the folder"))) MakeFolder();
    ui.Note("dialog.make_folder");
    ImGui::EndDisabled();
  }
  if (filters) {
    const std::string label = fmt::format(fmt::runtime(Tr("Show all files ({} are of another type)")), left_out_);
    if (ImGui::Checkbox(fmt::format("{}###all", label).c_str(), &all_files_)) ListFolder();
    ui.Note("dialog.all");
  }
  done = line("##name") || done;
  done = ImGui::Button(chooses_folder_ ? Tr("Export") : save_ ? Tr("Save") : Tr("Open")) || done;
  ui.Note("dialog.ok");
  if (allows_folder_) {
    ImGui::SameLine();
    if (ImGui::Button(chooses_folder_ ? Tr("Export into the folder shown") : Tr("Open this folder"))) {
      text_ = folder_;
      done = true;
    }
    ui.Note("dialog.folder");
  }
  ImGui::SameLine();
  const bool cancelled = ImGui::Button(Tr("Cancel"));
  ui.Note("dialog.cancel");
  ImGui::End();
  if (enter) {
    std::error_code error;
    folder_ = fs::canonical(fs::path(folder_) / *enter, error).string();
    fault_.clear();
    ListFolder();
    TakeLineAgain(ui);
  } else if (cancelled) {
    Close();
  } else if (done) {
    DecideFile();
    if (is_open()) TakeLineAgain(ui);
  }
}

void Dialogs::RunDecided() {
  if (const auto what = std::exchange(decided_, nullptr)) what();
}

}  // namespace kerf
