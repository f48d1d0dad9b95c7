// Export of a rehearsal's results: pieces, planes, pictures and a report, from the window's state.
#pragma once

#include <future>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "bone/pieces/piece_set.h"
#include "kerf/bone.h"
#include "session/export/write_export.h"
#include "session/plan/plan.h"
#include "session/scene/scene.h"
#include "view/ui/hud.h"

namespace kerf {

struct ExportOrder {
  std::string folder;  // created if missing
  bool obj = false;    // pieces as OBJ, otherwise STL
  Scene scene;
  std::vector<std::string> recordings;
  Plan plan;
  std::vector<Mark> marks;
  std::string saw_name;  // of a listed saw; empty: the scene's own
  std::shared_ptr<const Bone> before;
  std::future<Bone> after;
  std::string pieces_json;  // PieceSet::FormatJson() of moved pieces; empty: none was moved
  std::vector<ExportMeasure> measures;
  std::vector<PlotPoint> forces;
  std::vector<std::pair<std::string, std::string>> pictures;  // caption; PNG bytes
};

/// Exports the results and returns the folder. Takes seconds. May be called by any thread. Throws Error.
std::string RunExport(ExportOrder& order);

}  // namespace kerf
