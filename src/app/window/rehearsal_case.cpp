// The case of a rehearsal: what its files contain, and what is taken from a project.
#include <fmt/format.h>

#include <array>
#include <charconv>
#include <filesystem>
#include <future>
#include <utility>

#include "app/window/import_notes.h"
#include "app/window/plan_picture.h"
#include "app/window/rehearsal.h"
#include "kerf/error.h"
#include "session/project/project.h"
#include "view/ui/translate.h"

namespace kerf {
namespace {

// Names of settings in a project.
constexpr const char* kSawSetting = "saw";
constexpr const char* kInputSetting = "input";  // file or folder of the bone or its CT
constexpr const char* kColoursSetting = "colours";
constexpr const char* kLevelSetting = "ct_level_HU";
constexpr const char* kWidthSetting = "ct_width_HU";
constexpr const char* kTranslucentSetting = "translucent";  // present if the bone is drawn translucent
constexpr const char* kPiecesSetting = "pieces";            // present if the pieces are shown

constexpr std::array kColourNames{std::pair{ColourBy::kPlain, "plain"}, std::pair{ColourBy::kTissue, "tissue"},
                                  std::pair{ColourBy::kRegion, "region"}};
constexpr Range kLevelRange_HU{-5000, 50'000};

bool IsSameTool(const SceneTool& a, const SceneTool& b) {
  return DescribeTool(a.shape) == DescribeTool(b.shape) && a.rpm == b.rpm && a.reverse == b.reverse &&
         CalcRake(a.shape) == CalcRake(b.shape) &&
         CalcTooth(a.shape).edge_radius_mm == CalcTooth(b.shape).edge_radius_mm;
}

}  // namespace

bool Rehearsal::IsUsed(std::size_t number) const {
  if (choice_.saw_is_listed) return choice_.saw == number;
  return before_ && choice_.saw_name.empty() && IsSameTool(options_.saws[number].tool, scene_.tool);
}

ProjectSession Rehearsal::MakeSession() const {
  return MakeProjectSession(session_saw_, viewer_->figures(), viewer_->forces(), viewer_->holder_places());
}

/// `project_file`: where the project is saved; it names the case. Empty: the case has no project.
CaseContent Rehearsal::MakeContent(const std::string& project_file) {
  CaseContent content{
      .title = project_file.empty() ? scene_.TitleOrName() : std::filesystem::path(project_file).stem().string(),
      .input = input_,
      .scene = ended_work_ ? ended_work_->scene : viewer_->session()->scene(),
      .scene_files = scene_files_,
      .before = before_,
      .after = {},
      .recordings = earlier_recordings_,
      .sessions = sessions_,
      .bones = earlier_bones_,
      .unsaved_bones = saver_.ListUnsaved(),
      .settings = {}};
  if (ended_work_) {
    content.after = std::async(std::launch::deferred, [bone = ended_work_->bone] { return Bone(*bone); });
  } else {
    content.after = viewer_->session()->AskBone();
    content.sessions.push_back(MakeSession());
  }
  content.recordings.insert(content.recordings.end(),
                            result_.recordings.begin() + static_cast<std::ptrdiff_t>(first_recording_),
                            result_.recordings.end());
  content.settings[kSawSetting] = choice_.saw_name;
  if (!input_.empty()) content.settings[kInputSetting] = std::filesystem::absolute(input_).string();
  for (const auto& [colours, name] : kColourNames) {
    if (colours == viewer_->view().colour_by()) content.settings[kColoursSetting] = name;
  }
  if (viewer_->view().translucent()) content.settings[kTranslucentSetting] = "yes";
  if (in_pieces_) content.settings[kPiecesSetting] = "yes";
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
  input_ = get(kInputSetting);
  // Earlier versions did not name the saw.
  const bool names_saw = settings.count(kSawSetting) != 0;
  choice_.saw_name = get(kSawSetting);
  for (std::size_t i = 0; i < options_.saws.size() && !choice_.saw_is_listed; ++i) {
    const Saw& saw = options_.saws[i];
    if (!IsSameTool(saw.tool, scene_.tool) || (names_saw && saw.name != choice_.saw_name)) continue;
    choice_.saw = i;
    choice_.saw_is_listed = true;
    choice_.saw_name = saw.name;
  }
  for (const auto& [colours, name] : kColourNames) {
    if (get(kColoursSetting) == name) viewer_->view().set_colour_by(colours);
  }
  CtWindow window;
  window.level_HU = number(kLevelSetting, window.level_HU, kLevelRange_HU);
  window.width_HU = number(kWidthSetting, window.width_HU, SlicesPanel::kWindowRange_HU);
  viewer_->slices().set_window(window);
  viewer_->view().set_translucent(settings.count(kTranslucentSetting) != 0);
  begins_in_pieces_ = settings.count(kPiecesSetting) != 0;
}

void Rehearsal::ShowImportNotes() {
  std::string notes = DescribeImport(*before_, TrMade);
  if (notes.empty()) notes = Tr("Nothing unusual was found.");
  if (const std::string error = DescribeSurfaceError(*before_, TrMade); !error.empty()) {
    notes += fmt::format("\n\n{}: {}.", Tr("Error of the surface"), error);
  }
  viewer_->dialogs().Ask(
      fmt::format("{}\n\n{}\n\n{}\n\n{}", Tr("Notes on the import"),
                  Tr("You can go on. The notes say how exact the bone is, and what was assumed:"), notes,
                  Tr("Help > Notes on the import shows this again; it is in the report too.")),
      {{Tr("OK"), nullptr}});
}

void Rehearsal::Export() {
  if (!has_work() || writer_.is_exporting()) return;
  const std::string name = fmt::format("take-away{}", inputs_ == 1 ? "" : fmt::format("-{}", inputs_));
  const std::filesystem::path project = chosen_project();
  std::filesystem::path proposed = std::filesystem::path(options_.viewer.folder) / name;
  if (!project.empty()) {
    proposed = project.parent_path() / (project.stem().string() + "-export");  // where the user looks for it
  } else if (ended_work_) {
    proposed = std::filesystem::current_path() / name;  // the usual folder may be gone or full
  }
  // An earlier export is kept, unless the user chooses its folder.
  const std::string first = proposed.string();
  std::error_code error;
  for (int n = 2; std::filesystem::exists(proposed, error); ++n) proposed = fmt::format("{}-{}", first, n);
  viewer_->controls().Release();
  viewer_->SetSpindle(false);
  proposed = std::filesystem::absolute(proposed).lexically_normal();
  viewer_->dialogs().ChooseFile(
      viewer_->ui(), Tr("Folder for pieces, planes and report (it is made if it does not exist):"),
      proposed.parent_path().string(), {}, true, proposed.filename().string(),
      [this](const std::string& folder) { ExportInto(std::filesystem::path(folder).lexically_normal().string()); });
  viewer_->dialogs().ChooseFolder();
}

void Rehearsal::ExportInto(const std::string& folder) {
  // The session may have ended while the dialog was open.
  if (!has_work()) return viewer_->Say(Tr("There is no session to export"));
  CaseContent content = MakeContent(project_file_);
  try {
    content.pictures = GrabPictures();
  } catch (const Error& e) {
    return viewer_->Say(e.what());
  }
  writer_.Export(std::move(content), folder, options_.obj, [this] { Export(); });
}

/// Returns pictures for the report, with their captions: the cut in its place, and the pieces, if there are several.
std::vector<std::pair<std::string, std::string>> Rehearsal::GrabPictures() {
  std::vector<Vec3> cuts_W;
  for (const PlannedPlane& planned : editor_.document.plan().planes) cuts_W.push_back(planned.plane.p_W);
  std::vector<std::pair<std::string, std::string>> pictures;
  pieces_.HideInPicture();
  editor_.gestures.Hide();
  ShowPlan(*viewer_, editor_.document, cut_ ? &*cut_ : nullptr);
  pictures.emplace_back(Msg("The bone with the plan and the marks, its pieces where they were cut off"),
                        viewer_->GrabScene(cuts_W));
  if (pieces_.is_up_to_date() && pieces_.pieces()->size() > 1) {
    HidePlanOnBone(*viewer_);
    pieces_.MoveMarks(ListMarks(editor_.document));
    viewer_->view().SetPlanes(ListPlanes(editor_.document, true));
    pieces_.ShowInPicture(false);
    std::vector<Vec3> faces_W;
    for (int i = 0; i < pieces_.pieces()->size(); ++i) {
      for (const Vec3& p_P : cuts_W) faces_W.push_back(pieces_.pieces()->state(i).X_WP.Point(p_P));
    }
    pictures.emplace_back(
        Msg("The pieces, where they were moved, with the planned planes, and the marks moved with them"),
        viewer_->GrabScene(faces_W));
  }
  in_pieces_ ? pieces_.ShowInPicture() : pieces_.HideInPicture();
  ShowPlan(*viewer_, editor_.document, cut_ ? &*cut_ : nullptr);
  return pictures;
}

/// Returns the file in which the project was saved or, while it is being saved under another name, will be; empty:
/// none.
std::string Rehearsal::chosen_project() const {
  return !save_orders_.empty() ? save_orders_.back().file : writer_.is_saving() ? writer_.file() : project_file_;
}

void Rehearsal::SaveProject(bool quits) {
  if (!has_work()) return;
  const std::string file = chosen_project();
  if (file.empty()) return AskProjectFile(quits);
  SaveProjectIn(file, quits);
}

void Rehearsal::SaveProjectIn(const std::string& file, bool quits) {
  // The session may have ended while the dialog was open.
  if (!has_work() && !change_.is_pending()) return viewer_->Say(Tr("There is no session to save"));
  save_orders_.push_back({.file = file, .quits = quits, .saved = [this, file] {
                            project_file_ = result_.project = file;
                            AddRecent(viewer_->settings(), file);
                            viewer_->settings().save_folder = std::filesystem::absolute(file).parent_path().string();
                            viewer_->KeepSettings();
                            if (ended_work_) ended_work_->saved = true;
                          }});
  if (writer_.is_saving()) viewer_->Say(Tr("The project is saved again after the current saving."));
  FollowSaving();
}

/// Saves the project as was last requested.
void Rehearsal::FollowSaving() {
  if (writer_.is_saving() || save_orders_.empty() || !has_work()) return;
  SaveOrder order = std::move(save_orders_.front());
  save_orders_.pop_front();
  if (!save_orders_.empty()) {
    // The program ends after the last one.
    save_orders_.back().quits = save_orders_.back().quits || order.quits;
    order.quits = false;
  }
  CaseContent content = MakeContent(order.file);
  writer_.Save(std::move(content), std::move(order));
}

void Rehearsal::AskProjectFile(bool quits) {
  if (!has_work()) return;
  viewer_->controls().Release();
  viewer_->SetSpindle(false);
  const std::filesystem::path shown =
      project_file_.empty()
          ? std::filesystem::path((scene_file_.empty() && before_ && IsFromCt(*before_) ? scene_.title : scene_.name) +
                                  kProjectExtension)
          : std::filesystem::path(project_file_);
  viewer_->dialogs().ChooseFile(
      viewer_->ui(), Tr("Save the project as"),
      shown.has_parent_path() ? shown.parent_path().string() : FindSaveFolder(viewer_->settings()), {kProjectExtension},
      true, shown.filename().string(), [this, quits](const std::string& path) {
        const std::string file = IsProjectPath(path) ? path : path + kProjectExtension;
        if (std::filesystem::is_directory(file)) {
          return viewer_->dialogs().Ask(fmt::format(fmt::runtime(Tr("{} is a folder. Choose another name.")), file),
                                        {{Tr("OK"), [this, quits] { AskProjectFile(quits); }}});
        }
        if (file == project_file_ || !std::filesystem::exists(file)) return SaveProjectIn(file, quits);
        viewer_->dialogs().Ask(
            fmt::format(fmt::runtime(Tr("{} exists already. Replace it?")), file),
            {{Tr("Replace"), [this, file, quits] { SaveProjectIn(file, quits); }}, {Tr("Keep it"), nullptr}});
      });
}

}  // namespace kerf
