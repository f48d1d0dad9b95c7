#include "app/window/case_writer.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <filesystem>
#include <set>
#include <utility>

#include "app/window/export_order.h"
#include "app/window/is_ready.h"
#include "app/window/open_with_desktop.h"
#include "base/files/temporary.h"
#include "bone/vdb/bonefile.h"
#include "kerf/error.h"
#include "loop/record/recording.h"
#include "session/project/project.h"
#include "view/ui/translate.h"

namespace kerf {
namespace {

namespace fs = std::filesystem;

/// Adds the bones with which the recordings begin and that have none of the hashes `stored`. `known`: files of such
/// bones by hash; `unsaved`: bones whose files may not exist, by path. A bone that is not available is left out.
void AddStartBones(const std::map<std::uint64_t, std::string>& known,
                   const std::map<std::string, std::shared_ptr<const Bone>>& unsaved,
                   const std::set<std::uint64_t>& stored, const std::string& folder, Project& project) {
  for (const std::string& recording : project.recordings) {
    const RecordingHeader header = RecordingReader(recording).header();
    const std::uint64_t hash = header.bone_hash;
    if (stored.count(hash) != 0 || project.bones.count(hash) != 0) continue;
    if (const auto found = known.find(hash); found != known.end() && fs::exists(found->second)) {
      project.bones[hash] = found->second;
      continue;
    }
    const Scene scene = ParseScene(header.scene_toml, header.scene_name + ".toml");
    if (scene.bone.source != BoneSource::kFile) continue;
    if (const auto found = unsaved.find(scene.bone.file); found != unsaved.end()) {
      project.bones[hash] = fmt::format("{}/{:016x}.vdb", folder, hash);
      WriteBone(*found->second, project.bones[hash]);
    } else if (fs::exists(scene.bone.file) && ReadBone(scene.bone.file).CalcHash() == hash) {
      project.bones[hash] = scene.bone.file;
    }
  }
}

// Reasons that the system gives, for the translation.
[[maybe_unused]] constexpr std::array kReasons{Msg("Permission denied"), Msg("No space left on device"),
                                               Msg("Read-only file system"), Msg("No such file or directory"),
                                               Msg("Not a directory")};

/// Returns an error's text in the language of the window, as a sentence.
std::string ExplainFault(const std::string& what) {
  const std::string text = TrMade(what);
  return text.empty() || text.back() == '.' ? text : text + ".";
}

/// The same for a folder that could not be made or written into. Some file systems, such as /proc, say that something
/// does not exist where nothing can be made.
std::string ExplainFolderFault(const std::string& folder, const std::string& what) {
  std::error_code error;
  const fs::path parent = fs::path(folder).parent_path();
  if (fs::exists(folder, error) || !fs::is_directory(parent, error)) return ExplainFault(what);
  return fmt::format(fmt::runtime(Tr("No folder can be made in {}: nothing may be written there.")), parent.string());
}

}  // namespace

void CaseWriter::Export(CaseContent content, const std::string& folder, bool obj, std::function<void()> again) {
  if (is_exporting()) return;
  folder_ = fs::absolute(folder).string();
  export_again_ = std::move(again);
  viewer_.SetSpindle(false);
  ExportOrder order;
  order.folder = folder;
  order.obj = obj;
  order.scene = std::move(content.scene);
  order.title = content.title;
  order.input = content.input;
  order.recordings = content.recordings;
  order.sessions = content.sessions;
  order.plan = document_.plan();
  order.marks = document_.marks();
  order.before = content.before;
  order.pictures = std::move(content.pictures);
  order.pieces_json = pieces_.FormatArrangement();
  order.measurements = pieces_.measurements();
  order.after = std::move(content.after);
  order.language = {
      .code = CurrentLanguage(),
      .translate = [code = CurrentLanguage()](const std::string& text) { return TranslateInto(code, text); },
      .point = DecimalPointOf(CurrentLanguage())};
  *progress_ = 0;
  order.progress = [progress = progress_](double fraction) { *progress = fraction; };
  viewer_.Say(Tr("Exporting pieces, planes and report"));
  exporting_ = std::async(std::launch::async,
                          [order = std::make_shared<ExportOrder>(std::move(order))] { return RunExport(*order); });
}

void CaseWriter::FinishExport() {
  if (!is_exporting()) return;
  try {
    take_away_ = exporting_.get();
    if (std::find(exports_.begin(), exports_.end(), folder_) == exports_.end()) exports_.push_back(folder_);
    viewer_.Say(fmt::format(fmt::runtime(Tr("Exported: {}")), folder_));
    viewer_.dialogs().Ask(fmt::format(fmt::runtime(Tr("Pieces, planes and the report are in {}")), folder_),
                          {{Tr("Open the folder"), [this] { OpenInDesktop(take_away_); }},
                           {Tr("Open the report"), [this] { OpenInDesktop(take_away_ + "/report.html"); }},
                           {Tr("Return to the bone"), nullptr}});
    viewer_.trace().Write("taken_away", {{"folder", take_away_}});
  } catch (const std::exception& e) {  // the session has ended in the meantime and returns no bone
    viewer_.dialogs().Ask(
        fmt::format(
            "{}\n\n{}\n\n{}",
            fmt::format(fmt::runtime(Tr("The results could not be written into the folder {}.")), folder_),
            ExplainFolderFault(folder_, e.what()),
            Tr("Nothing is lost: bone, plan and pieces are kept in the window. Choose a folder on another disk, "
               "or one that you may write to.")),
        {{Tr("Choose another folder"), export_again_}, {Tr("Return to the bone"), nullptr}});
    viewer_.trace().Write("taken_away", {{"failure", e.what()}});
  }
}

void CaseWriter::OpenInDesktop(const std::string& path) {
  if (!OpenWithDesktop(path)) viewer_.Say(fmt::format(fmt::runtime(Tr("No program was found that opens {}")), path));
}

void CaseWriter::Save(CaseContent content, SaveOrder order) {
  order_ = std::move(order);
  viewer_.SetSpindle(false);
  auto project = std::make_shared<Project>();
  project->title = content.title;
  project->sessions = std::move(content.sessions);
  project->settings = std::move(content.settings);
  project->scene = std::move(content.scene);
  project->scene_files = std::move(content.scene_files);
  project->scene.plan = document_.plan();
  project->marks = document_.marks();
  const ViewCamera& camera = viewer_.view().camera();
  project->views = {{.name = "window",
                     .target_W_mm = camera.target_W(),
                     .toward_eye_W = -camera.forward_W(),
                     .up_W = camera.up_W(),
                     .height_mm = camera.height_mm(),
                     .parallel = camera.parallel()}};
  project->pieces_json = pieces_.FormatArrangement();
  project->measurements = pieces_.measurements();
  viewer_.Say(Tr("Saving the project"));
  // What changes from now on is not in the file.
  plan_was_unsaved_ = document_.is_unsaved();
  pieces_were_unsaved_ = pieces_.is_unsaved();
  cut_was_unsaved_ = cut_.is_unsaved();
  document_.set_unsaved(false);
  pieces_.set_unsaved(false);
  cut_.set_unsaved(false);
  saving_ = std::async(
      std::launch::async, [project, file = order_.file, before = content.before, bones = std::move(content.bones),
                           unsaved = std::move(content.unsaved_bones), recordings = std::move(content.recordings),
                           after = std::move(content.after)]() mutable {
        // The recording of the running session grows; its part until now replays like a whole one.
        const TemporaryFolder copies("kerf_project");
        auto session = project->sessions.begin();
        for (const std::string& recording : recordings) {
          // Sessions that have no recording have none in the list either.
          session = std::find_if(session, project->sessions.end(), [](const ProjectSession& s) { return s.recorded; });
          const bool exists = fs::exists(recording);
          if (session != project->sessions.end()) (session++)->recorded = exists;
          if (!exists) continue;
          project->recordings.push_back(recording);
          if (recording != recordings.back()) continue;
          project->recordings.back() = copies.path() + "/" + fs::path(recording).filename().string();
          fs::copy_file(recording, project->recordings.back());
        }
        project->bone_file = copies.path() + "/bone-before.vdb";
        project->cut_bone_file = copies.path() + "/bone-now.vdb";
        const Bone now = after.get();
        WriteBone(*before, project->bone_file);
        WriteBone(now, project->cut_bone_file);
        AddStartBones(bones, unsaved, {before->CalcHash(), now.CalcHash()}, copies.path(), *project);
        WriteProject(file, *project);
      });
}

std::string CaseWriter::FinishSaving() {
  if (!is_saving()) return {};
  const SaveOrder order = order_;
  try {
    saving_.get();
    viewer_.Say(fmt::format(fmt::runtime(Tr("Saved: {}")), order.file));
    viewer_.trace().Write("project", {{"file", order.file}});
    if (order.saved) order.saved();
    if (order.quits) viewer_.Quit();
    return {};
  } catch (const std::exception& e) {
    viewer_.Say(fmt::format(fmt::runtime(Tr("The project was not saved: {}")), ExplainFault(e.what())));
    viewer_.trace().Write("project", {{"failure", e.what()}});
    document_.set_unsaved(document_.is_unsaved() || plan_was_unsaved_);
    pieces_.set_unsaved(pieces_.is_unsaved() || pieces_were_unsaved_);
    cut_.set_unsaved(cut_.is_unsaved() || cut_was_unsaved_);
    return e.what();
  }
}

void CaseWriter::Update() {
  if (IsReady(exporting_)) FinishExport();
  if (IsReady(saving_)) FinishSaving();
}

}  // namespace kerf
