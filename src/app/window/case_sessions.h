// Figures of the sessions of a case, those before it was saved as a project included.
#pragma once

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "app/window/holder_watch.h"
#include "app/window/live_session.h"
#include "session/project/project.h"
#include "view/ui/hud.h"

namespace kerf {

/// Returns the figures of a session. The force curve is thinned to the maxima of at most 1000 equal parts.
ProjectSession MakeProjectSession(const std::string& saw, const LiveFigures& figures,
                                  const std::vector<PlotPoint>& forces, const HolderPlaces& holder = {});

/// Returns the sessions of a project. Sessions that have a recording but no figures, in files of earlier versions, are
/// listed without figures.
std::vector<ProjectSession> ListSessions(const Project& project);

/// All sessions of a case as one.
struct JoinedSessions {
  std::vector<std::string> saws;                     // that were used, each once
  std::optional<double> duration_s;                  // none if that of a session is not known; likewise the next
  std::optional<double> in_bone_s;                   // with the saw in bone
  std::optional<double> turning_force_N;             // largest on the hand while the spindle turned
  std::optional<double> stopped_force_N;             // and while it did not
  std::vector<std::pair<double, double>> forces_sN;  // of the known sessions, one after the other
  HolderPlaces holder;                               // the first of all
};
JoinedSessions JoinSessions(const std::vector<ProjectSession>& sessions);

}  // namespace kerf
