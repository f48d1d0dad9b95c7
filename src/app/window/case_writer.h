// Export of a rehearsal's results, and saving of its project, in other threads.
#pragma once

#include <atomic>
#include <future>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "app/window/pieces_mode.h"
#include "app/window/plan_document.h"
#include "session/project/project.h"

namespace kerf {

/// What is written besides the plan, the marks, the pieces and the state of the window.
struct CaseContent {
  std::string title;
  std::shared_ptr<const Bone> before;           // before the cuts
  std::vector<std::string> recordings;          // in order; the last one may still grow
  std::vector<ProjectSession> sessions;         // in order; the last one is running
  std::map<std::string, std::string> settings;  // of the window, for the project
};

/// Call Export() and Save() only while a session runs. A message states the result.
class CaseWriter {
 public:
  CaseWriter(ViewerApp& viewer, PlanDocument& document, PiecesMode& pieces)
      : viewer_(viewer), document_(document), pieces_(pieces) {}

  /// Exports pieces, planes and a report into a folder, unless an export is in progress. `obj`: pieces as OBJ,
  /// otherwise STL.
  void Export(const CaseContent& content, const std::string& folder, bool obj);
  bool is_exporting() const { return exporting_.valid(); }
  /// Returns the progress of the export, 0 to 1.
  double export_progress() const { return *progress_; }
  /// Returns the folder of the last export; empty if there is none.
  const std::string& take_away() const { return take_away_; }
  /// Saves the project, replacing `file`, unless it is being saved. `quits`: the program ends once it is saved.
  void Save(const CaseContent& content, const std::string& file, bool quits);
  bool is_saving() const { return saving_.valid(); }
  /// Called once per frame.
  void Update();
  /// Waits for the end of an export.
  void FinishExport();

 private:
  void FinishSaving();
  void OpenInDesktop(const std::string& path);

  ViewerApp& viewer_;
  PlanDocument& document_;
  PiecesMode& pieces_;
  std::future<std::string> exporting_;
  std::shared_ptr<std::atomic<double>> progress_ = std::make_shared<std::atomic<double>>(0);  // of the export
  std::string take_away_;
  std::future<std::string> saving_;  // of the project; returns its path
  bool quits_after_saving_ = false;
};

}  // namespace kerf
