#include "app/window/case_writer.h"

#include <fmt/format.h>

#include <filesystem>
#include <utility>

#include "app/window/export_order.h"
#include "app/window/is_ready.h"
#include "app/window/open_with_desktop.h"
#include "base/files/temporary.h"
#include "bone/vdb/bonefile.h"
#include "kerf/error.h"
#include "session/project/project.h"
#include "view/ui/translate.h"

namespace kerf {
namespace {

namespace fs = std::filesystem;

}  // namespace

void CaseWriter::Export(const CaseContent& content, const std::string& folder, bool obj) {
  if (is_exporting()) return;
  viewer_.SetSpindle(false);
  ExportOrder order;
  order.folder = folder;
  order.obj = obj;
  order.scene = viewer_.session()->scene();
  order.title = content.title;
  order.recordings = content.recordings;
  order.sessions = content.sessions;
  order.plan = document_.plan();
  order.marks = document_.marks();
  order.before = content.before;
  try {
    order.pictures.emplace_back("As seen in the window", viewer_.GrabScene());
  } catch (const Error& e) {
    return viewer_.Say(e.what());
  }
  order.pieces_json = pieces_.FormatArrangement();
  order.measures = pieces_.measures();
  order.after = viewer_.session()->AskBone();
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
    viewer_.Say(fmt::format(fmt::runtime(Tr("Exported: {}")), take_away_));
    viewer_.dialogs().Ask(fmt::format(fmt::runtime(Tr("Pieces, planes and the report are in {}")), take_away_),
                          {{Tr("Open the folder"), [this] { OpenInDesktop(take_away_); }},
                           {Tr("Open the report"), [this] { OpenInDesktop(take_away_ + "/report.html"); }},
                           {Tr("Return to the bone"), nullptr}});
    viewer_.trace().Write("taken_away", {{"folder", take_away_}});
  } catch (const std::exception& e) {  // the session has ended in the meantime and returns no bone
    viewer_.Say(fmt::format(fmt::runtime(Tr("Nothing was exported: {}")), e.what()));
    viewer_.trace().Write("taken_away", {{"failure", e.what()}});
  }
}

void CaseWriter::OpenInDesktop(const std::string& path) {
  if (!OpenWithDesktop(path)) viewer_.Say(fmt::format(fmt::runtime(Tr("No program was found that opens {}")), path));
}

void CaseWriter::Save(const CaseContent& content, const std::string& file, bool quits) {
  quits_after_saving_ = quits_after_saving_ || quits;
  if (is_saving()) return;
  viewer_.SetSpindle(false);
  auto project = std::make_shared<Project>();
  project->title = content.title;
  project->sessions = content.sessions;
  project->settings = content.settings;
  project->scene = viewer_.session()->scene();
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
  std::shared_future<Bone> now = viewer_.session()->AskBone().share();
  viewer_.Say(Tr("Saving the project"));
  // What changes from now on is not in the file.
  document_.set_unsaved(false);
  pieces_.set_unsaved(false);
  saving_ = std::async(std::launch::async, [project, now, content, file] {
    // The recording of the running session grows; its part until now replays like a whole one.
    const TemporaryFolder copies("kerf_project");
    for (const std::string& recording : content.recordings) {
      if (!fs::exists(recording)) continue;
      project->recordings.push_back(recording);
      if (recording != content.recordings.back()) continue;
      project->recordings.back() = copies.path() + "/" + fs::path(recording).filename().string();
      fs::copy_file(recording, project->recordings.back());
    }
    project->bone_file = copies.path() + "/bone-before.vdb";
    project->cut_bone_file = copies.path() + "/bone-now.vdb";
    WriteBone(*content.before, project->bone_file);
    WriteBone(now.get(), project->cut_bone_file);
    WriteProject(file, *project);
    return file;
  });
}

void CaseWriter::FinishSaving() {
  try {
    const std::string file = saving_.get();
    viewer_.Say(fmt::format(fmt::runtime(Tr("Project: {}")), file));
    viewer_.trace().Write("project", {{"file", file}});
    if (quits_after_saving_) viewer_.Quit();
  } catch (const std::exception& e) {
    viewer_.Say(fmt::format(fmt::runtime(Tr("The project was not saved: {}")), e.what()));
    viewer_.trace().Write("project", {{"failure", e.what()}});
    quits_after_saving_ = false;
    document_.set_unsaved(true);
    pieces_.set_unsaved(true);
  }
}

void CaseWriter::Update() {
  if (IsReady(exporting_)) FinishExport();
  if (IsReady(saving_)) FinishSaving();
}

}  // namespace kerf
