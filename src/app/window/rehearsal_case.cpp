// The case of a rehearsal: what its files contain, and what is taken from a project.
#include <fmt/format.h>

#include <array>
#include <charconv>
#include <filesystem>
#include <utility>

#include "app/window/import_notes.h"
#include "app/window/rehearsal.h"
#include "session/project/project.h"
#include "view/ui/translate.h"

namespace kerf {
namespace {

// Names of settings in a project.
constexpr const char* kSawSetting = "saw";
constexpr const char* kColoursSetting = "colours";
constexpr const char* kLevelSetting = "ct_level_HU";
constexpr const char* kWidthSetting = "ct_width_HU";

constexpr std::array kColourNames{std::pair{ColourBy::kPlain, "plain"}, std::pair{ColourBy::kTissue, "tissue"},
                                  std::pair{ColourBy::kRegion, "region"}};
constexpr Range kLevelRange_HU{-5000, 50'000};

bool IsSameTool(const SceneTool& a, const SceneTool& b) {
  return DescribeTool(a) == DescribeTool(b) && a.rpm == b.rpm && a.rake_deg == b.rake_deg &&
         a.edge_radius_um == b.edge_radius_um;
}

}  // namespace

ProjectSession Rehearsal::MakeSession() const {
  return MakeProjectSession(session_saw_, viewer_->figures(), viewer_->forces());
}

CaseContent Rehearsal::MakeContent() const {
  CaseContent content{
      .title = project_file_.empty() ? scene_.TitleOrName() : std::filesystem::path(project_file_).stem().string(),
      .before = before_,
      .recordings = earlier_recordings_,
      .sessions = sessions_,
      .settings = {}};
  content.recordings.insert(content.recordings.end(),
                            result_.recordings.begin() + static_cast<std::ptrdiff_t>(first_recording_),
                            result_.recordings.end());
  content.sessions.push_back(MakeSession());
  content.settings[kSawSetting] = saw_name_;
  for (const auto& [colours, name] : kColourNames) {
    if (colours == viewer_->view().colour_by()) content.settings[kColoursSetting] = name;
  }
  content.settings[kLevelSetting] = fmt::format("{}", viewer_->slices().window().level_HU);
  content.settings[kWidthSetting] = fmt::format("{}", viewer_->slices().window().width_HU);
  return content;
}

/// Restores what a project keeps of the window. Values that are not valid are ignored.
void Rehearsal::TakeSettings(const std::map<std::string, std::string>& settings) {
  const auto get = [&settings](const char* name) {
    const auto found = settings.find(name);
    return found == settings.end() ? std::string() : found->second;
  };
  const auto number = [&get](const char* name, double otherwise, const Range& range) {
    const std::string text = get(name);
    double value = otherwise;
    const auto [end, failed] = std::from_chars(text.data(), text.data() + text.size(), value);
    return failed == std::errc() && end == text.data() + text.size() && range.Contains(value) ? value : otherwise;
  };
  // Earlier versions did not name the saw.
  const bool names_saw = settings.count(kSawSetting) != 0;
  saw_name_ = get(kSawSetting);
  for (std::size_t i = 0; i < options_.saws.size() && !saw_is_listed_; ++i) {
    const Saw& saw = options_.saws[i];
    if (!IsSameTool(saw.tool, scene_.tool) || (names_saw && saw.name != saw_name_)) continue;
    saw_ = i;
    saw_is_listed_ = true;
    saw_name_ = saw.name;
  }
  for (const auto& [colours, name] : kColourNames) {
    if (get(kColoursSetting) == name) viewer_->view().set_colour_by(colours);
  }
  CtWindow window;
  window.level_HU = number(kLevelSetting, window.level_HU, kLevelRange_HU);
  window.width_HU = number(kWidthSetting, window.width_HU, SlicesPanel::kWindowRange_HU);
  viewer_->slices().set_window(window);
}

void Rehearsal::ShowImportNotes() {
  viewer_->dialogs().Ask(fmt::format("{}\n\n{}\n\n{}", Tr("Notes on the import"), DescribeImport(*before_),
                                     Tr("Help > Notes on the import shows this again; it is in the report too.")),
                         {{Tr("OK"), nullptr}});
}

void Rehearsal::Export() {
  if (!viewer_->is_running() || change_.is_pending()) return;
  const std::string number = inputs_ == 1 ? "" : fmt::format("-{}", inputs_);
  writer_.Export(MakeContent(), fmt::format("{}/take-away{}", options_.viewer.folder, number), options_.obj);
}

void Rehearsal::SaveProject(bool quits) {
  if (!viewer_->is_running() || change_.is_pending()) return;
  if (project_file_.empty()) return AskProjectFile(quits);
  SaveProjectIn(project_file_, quits);
}

void Rehearsal::SaveProjectIn(const std::string& file, bool quits) {
  // The session may have ended while the dialog was open.
  if (!viewer_->is_running() || change_.is_pending()) return viewer_->Say(Tr("There is no session to save"));
  project_file_ = file;
  AddRecent(viewer_->settings(), file);
  writer_.Save(MakeContent(), file, quits);
}

void Rehearsal::AskProjectFile(bool quits) {
  if (!viewer_->is_running() || change_.is_pending()) return;
  viewer_->controls().Release();
  viewer_->SetSpindle(false);
  const std::filesystem::path shown =
      project_file_.empty()
          ? std::filesystem::path((scene_file_.empty() && before_ && IsFromCt(*before_) ? scene_.title : scene_.name) +
                                  kProjectExtension)
          : std::filesystem::path(project_file_);
  viewer_->dialogs().ChooseFile(
      viewer_->ui(), Tr("Save the project as"), shown.parent_path().string(), {kProjectExtension}, true,
      shown.filename().string(), [this, quits](const std::string& path) {
        const std::string file = IsProjectPath(path) ? path : path + kProjectExtension;
        if (file == project_file_ || !std::filesystem::exists(file)) return SaveProjectIn(file, quits);
        viewer_->dialogs().Ask(
            fmt::format(fmt::runtime(Tr("{} exists already. Replace it?")), file),
            {{Tr("Replace"), [this, file, quits] { SaveProjectIn(file, quits); }}, {Tr("Keep it"), nullptr}});
      });
}

}  // namespace kerf
