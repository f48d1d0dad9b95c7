// What is taken away from a rehearsal: pieces, planes, pictures and a report, from the window's state.
#pragma once

#include <future>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "bone/pieces/piece_set.h"
#include "kerf/bone.h"
#include "session/export/take_away.h"
#include "session/plan/plan.h"
#include "session/scene/scene.h"
#include "view/live/hud.h"

namespace kerf {

struct TakeAwayOrder {
  std::string folder;  // made when missing
  bool obj = false;    // pieces, else STL
  Scene scene;
  std::vector<std::string> recordings;
  Plan plan;
  std::shared_ptr<const Bone> before;
  std::future<Bone> after;
  std::string pieces_json;  // PieceSet::FormatJson(), of pieces that were moved; empty: they stand where they were cut
  std::vector<TakenMeasure> measures;
  std::vector<PlotPoint> forces;
  std::vector<std::pair<std::string, std::string>> pictures;  // what it shows; PNG bytes
};

/// Takes seconds; any thread. Returns the folder. Throws Error.
std::string DoTakeAway(TakeAwayOrder& order);

}  // namespace kerf
