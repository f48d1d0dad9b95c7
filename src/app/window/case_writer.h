// Export of a rehearsal's results, and saving of its project, in other threads.
#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <future>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "app/window/pieces_mode.h"
#include "app/window/plan_document.h"
#include "app/window/unsaved_cut.h"
#include "session/project/project.h"

namespace kerf {

/// What is written besides the plan, the marks, the pieces with their measurements and the state of the window.
struct CaseContent {
  std::string title;
  std::string input;  // file or folder of the bone or its CT, as the user gave it; empty: there is none
  Scene scene;
  std::map<std::string, std::string> scene_files;  // contents of the scene's files that may be gone, by path
  std::shared_ptr<const Bone> before;              // before the cuts
  std::future<Bone> after;                         // as it is now
  std::vector<std::string> recordings;             // in order; the last one may still grow
  std::vector<ProjectSession> sessions;            // in order; the last one may be running
  std::map<std::uint64_t, std::string> bones;      // of earlier sessions, by hash: files
  std::map<std::string, std::shared_ptr<const Bone>> unsaved_bones;  // by the file that recordings name
  std::map<std::string, std::string> settings;                       // of the window, for the project
  std::vector<std::pair<std::string, std::string>> pictures{};       // for the report: caption and PNG bytes
};

/// Where a project is saved, and what follows.
struct SaveOrder {
  std::string file;             // is replaced
  bool quits = false;           // the program ends once it is saved
  std::function<void()> saved;  // called once it is saved; optional
};

/// A message states the result.
class CaseWriter {
 public:
  CaseWriter(ViewerApp& viewer, PlanDocument& document, PiecesMode& pieces, UnsavedCut& cut)
      : viewer_(viewer), document_(document), pieces_(pieces), cut_(cut) {}

  /// Exports pieces, planes and a report into a folder, unless an export is in progress. `obj`: pieces as OBJ,
  /// otherwise STL. `again`: called if it fails and the user wants to choose another folder.
  void Export(CaseContent content, const std::string& folder, bool obj, std::function<void()> again);
  bool is_exporting() const { return exporting_.valid(); }
  /// Returns the progress of the export, 0 to 1.
  double export_progress() const { return *progress_; }
  /// Returns the folder of the last export; empty if there is none.
  const std::string& take_away() const { return take_away_; }
  /// Returns the folders of all exports, in order.
  const std::vector<std::string>& exports() const { return exports_; }
  /// Saves the project. Call it only if none is being saved.
  void Save(CaseContent content, SaveOrder order);
  bool is_saving() const { return saving_.valid(); }
  /// Returns the file that is being saved, or was last.
  const std::string& file() const { return order_.file; }
  /// Called once per frame.
  void Update();
  /// Waits for the end of an export.
  void FinishExport();
  /// Waits until the project is saved. Returns why it was not; empty if it was, or if none is being saved.
  std::string FinishSaving();

 private:
  void OpenInDesktop(const std::string& path);

  ViewerApp& viewer_;
  PlanDocument& document_;
  PiecesMode& pieces_;
  UnsavedCut& cut_;
  std::future<std::string> exporting_;
  std::shared_ptr<std::atomic<double>> progress_ = std::make_shared<std::atomic<double>>(0);  // of the export
  std::string folder_;                                                                        // of the latest export
  std::function<void()> export_again_;
  std::string take_away_;
  std::vector<std::string> exports_;
  std::future<void> saving_;  // of the project
  SaveOrder order_;           // that is being carried out
  bool plan_was_unsaved_ = false;
  bool pieces_were_unsaved_ = false;
  bool cut_was_unsaved_ = false;
};

}  // namespace kerf
