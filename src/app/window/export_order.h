// Export of a rehearsal's results: pieces, planes, pictures and a report, from the window's state.
#pragma once

#include <functional>
#include <future>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "bone/pieces/piece_measure.h"
#include "bone/pieces/piece_set.h"
#include "kerf/bone.h"
#include "session/export/write_export.h"
#include "session/plan/plan.h"
#include "session/project/project.h"
#include "session/scene/scene.h"

namespace kerf {

struct ExportOrder {
  std::string folder;  // created if missing
  bool obj = false;    // pieces as OBJ, otherwise STL
  std::string title;   // name of the case
  std::string input;   // file or folder of the bone or its CT, as the user gave it; empty: there is none
  Scene scene;
  std::vector<std::string> recordings;
  std::vector<ProjectSession> sessions;  // in order; not empty
  Plan plan;
  std::vector<Mark> marks;
  std::shared_ptr<const Bone> before;
  std::future<Bone> after;
  std::string pieces_json;                   // PieceSet::FormatJson() of moved pieces; empty: none was moved
  std::vector<MeasuredPoints> measurements;  // between points of these pieces
  std::vector<std::pair<std::string, std::string>> pictures;  // caption; PNG bytes
  std::function<void(double)> progress;                       // receives 0 to 1; optional
  ReportLanguage language{};                                  // of the report
};

/// Exports the results and returns the folder. Takes seconds. May be called by any thread. Throws Error.
std::string RunExport(ExportOrder& order);

}  // namespace kerf
