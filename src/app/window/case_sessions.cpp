#include "app/window/case_sessions.h"

#include <algorithm>
#include <set>

namespace kerf {
namespace {

constexpr std::size_t kCurvePoints = 1000;

}  // namespace

ProjectSession MakeProjectSession(const std::string& saw, const LiveFigures& figures,
                                  const std::vector<PlotPoint>& forces) {
  ProjectSession session{.saw = saw,
                         .duration_s = figures.time_s,
                         .removed_mm3 = std::max(0.0, figures.removed_mm3),
                         .largest_force_N = 0,
                         .forces_sN = {}};
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
  JoinedSessions joined{.saws = {}, .duration_s = 0, .largest_force_N = 0, .forces_sN = {}};
  std::set<std::string> saws;
  double begin_s = 0;
  for (const ProjectSession& session : sessions) {
    if (session.saw != "-" && saws.insert(session.saw).second) joined.saws.push_back(session.saw);
    for (const auto& [time_s, force_N] : session.forces_sN) joined.forces_sN.emplace_back(begin_s + time_s, force_N);
    begin_s += session.duration_s.value_or(0);
    if (!session.duration_s) joined.duration_s.reset();
    if (!session.largest_force_N) joined.largest_force_N.reset();
    if (joined.duration_s) *joined.duration_s += *session.duration_s;
    if (joined.largest_force_N) *joined.largest_force_N = std::max(*joined.largest_force_N, *session.largest_force_N);
  }
  return joined;
}

}  // namespace kerf
