#include "app/window/case_sessions.h"

#include <algorithm>
#include <set>

namespace kerf {
namespace {

constexpr std::size_t kCurvePoints = 1000;

}  // namespace

ProjectSession MakeProjectSession(const std::string& saw, const LiveFigures& figures,
                                  const std::vector<PlotPoint>& forces, const HolderPlaces& holder) {
  ProjectSession session{.saw = saw,
                         .duration_s = figures.time_s,
                         .removed_mm3 = std::max(0.0, figures.removed_mm3),
                         .largest_force_N = 0,
                         .forces_sN = {},
                         .turning_force_N = figures.turning_force_N,
                         .stopped_force_N = figures.stopped_force_N,
                         .in_bone_s = figures.in_bone_s,
                         .hub_in_bone_W = holder.hub_W,
                         .handpiece_in_bone_W = holder.handpiece_W};
  const std::size_t parts = std::min(kCurvePoints, forces.size());
  for (std::size_t i = 0; i < parts; ++i) {
    const auto first = forces.begin() + static_cast<std::ptrdiff_t>(i * forces.size() / parts);
    const auto last = forces.begin() + static_cast<std::ptrdiff_t>((i + 1) * forces.size() / parts);
    const auto by_force = [](const PlotPoint& a, const PlotPoint& b) { return a.force_N < b.force_N; };
    const PlotPoint& largest = *std::max_element(first, last, by_force);
    session.forces_sN.emplace_back(largest.time_s, largest.force_N);
    session.largest_force_N = std::max(*session.largest_force_N, largest.force_N);
  }
  return session;
}

std::vector<ProjectSession> ListSessions(const Project& project) {
  std::vector<ProjectSession> sessions = project.sessions;
  const auto recorded = static_cast<std::size_t>(
      std::count_if(sessions.begin(), sessions.end(), [](const ProjectSession& s) { return s.recorded; }));
  if (recorded < project.recordings.size()) {
    sessions.insert(sessions.begin(), project.recordings.size() - recorded, ProjectSession{.saw = "-"});
  }
  return sessions;
}

JoinedSessions JoinSessions(const std::vector<ProjectSession>& sessions) {
  JoinedSessions joined{.saws = {},
                        .duration_s = 0,
                        .in_bone_s = 0,
                        .turning_force_N = 0,
                        .stopped_force_N = 0,
                        .forces_sN = {},
                        .holder = {}};
  std::set<std::string> saws;
  double begin_s = 0;
  for (const ProjectSession& session : sessions) {
    if (session.saw != "-" && saws.insert(session.saw).second) joined.saws.push_back(session.saw);
    for (const auto& [time_s, force_N] : session.forces_sN) joined.forces_sN.emplace_back(begin_s + time_s, force_N);
    begin_s += session.duration_s.value_or(0);
    // What is not known of a session is not known of all.
    const auto join = [](std::optional<double>& all, const std::optional<double>& one, const auto& with) {
      all = all && one ? std::optional(with(*all, *one)) : std::nullopt;
    };
    const auto add = [](double x, double y) { return x + y; };
    const auto larger = [](double x, double y) { return std::max(x, y); };
    join(joined.duration_s, session.duration_s, add);
    join(joined.in_bone_s, session.in_bone_s, add);
    join(joined.turning_force_N, session.turning_force_N, larger);
    join(joined.stopped_force_N, session.stopped_force_N, larger);
    if (!joined.holder.hub_W) joined.holder.hub_W = session.hub_in_bone_W;
    if (!joined.holder.handpiece_W) joined.holder.handpiece_W = session.handpiece_in_bone_W;
  }
  return joined;
}

}  // namespace kerf
