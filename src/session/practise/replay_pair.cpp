#include "session/practise/replay_pair.h"

#include <algorithm>
#include <glm/geometric.hpp>
#include <glm/gtc/quaternion.hpp>

#include "kerf/error.h"
#include "session/practise/agents.h"

namespace kerf {
namespace {

/// Time before the first and after the last contact that is shown.
constexpr double kLead_s = 1;
/// Distance between the points of a line.
constexpr double kLineStep_mm = 0.1;

std::vector<Vec3> MakeLine(const ToolTrack& track, std::span<const DepthGauge> gauges) {
  std::vector<Vec3> line_W;
  for (const TrackPoint& p : track.points()) {
    if (!p.contact) continue;
    const Vec3 p_W = FindNearestGauge(gauges, p.X_WT).cut().FindLowest(p.X_WT);
    if (line_W.empty() || glm::distance(line_W.back(), p_W) >= kLineStep_mm) line_W.push_back(p_W);
  }
  return line_W;
}

std::vector<DepthPoint> MakeDepths(const ToolTrack& track, std::span<const DepthGauge> gauges) {
  std::vector<DepthPoint> depths;
  for (const TrackPoint& p : track.points()) {
    if (const auto reading = FindNearestGauge(gauges, p.X_WT).Calc(p.X_WT))
      depths.push_back({p.time_s, reading->depth_mm});
  }
  return depths;
}

}  // namespace

void ToolTrack::Take(const LoopTick& tick) {
  const CoupledOutput& out = tick.coupled;
  contact_ = contact_ || out.engaged_teeth > 0 || glm::length(out.f_face_W_N) > 0;
  if (!points_.empty() && tick.time_s < points_.back().time_s + kTrackStep_s - 1e-9) return;
  points_.push_back({tick.time_s, out.X_WT, contact_, tick.in.rpm});
  contact_ = false;
}

TrackPoint ToolTrack::Calc(double time_s) const {
  const auto after = std::upper_bound(points_.begin(), points_.end(), time_s,
                                      [](double t, const TrackPoint& p) { return t < p.time_s; });
  if (after == points_.begin()) return points_.front();
  if (after == points_.end()) return points_.back();
  const TrackPoint& a = *(after - 1);
  const TrackPoint& b = *after;
  const double f = (time_s - a.time_s) / (b.time_s - a.time_s);
  TrackPoint p = a;
  p.time_s = time_s;
  p.X_WT.p_AB = a.X_WT.p_AB + f * (b.X_WT.p_AB - a.X_WT.p_AB);
  p.X_WT.R_AB = glm::slerp(a.X_WT.R_AB, b.X_WT.R_AB, f);
  p.rpm = a.rpm + f * (b.rpm - a.rpm);
  return p;
}

ToolTrack ToolTrack::Trim() const {
  const auto touches = [](const TrackPoint& p) { return p.contact; };
  const auto first = std::find_if(points_.begin(), points_.end(), touches);
  if (first == points_.end()) return *this;
  const auto last = std::find_if(points_.rbegin(), points_.rend(), touches);
  const double from_s = first->time_s - kLead_s;
  const double until_s = last->time_s + kLead_s;
  ToolTrack trimmed;
  for (const TrackPoint& p : points_) {
    if (p.time_s < from_s || p.time_s > until_s) continue;
    trimmed.points_.push_back(p);
  }
  const double start_s = trimmed.points_.front().time_s;
  for (TrackPoint& p : trimmed.points_) p.time_s -= start_s;
  trimmed.begins_s_ = begins_s_ + start_s;
  return trimmed;
}

ReplayPair MakeReplayPair(const ToolTrack& student, const ToolTrack& expert, std::span<const DepthGauge> gauges) {
  ReplayPair pair;
  pair.student = student.Trim();
  pair.expert = expert.Trim();
  pair.student_line_W = MakeLine(pair.student, gauges);
  pair.expert_line_W = MakeLine(pair.expert, gauges);
  pair.student_depth = MakeDepths(pair.student, gauges);
  pair.expert_depth = MakeDepths(pair.expert, gauges);
  return pair;
}

ToolTrack MakeExpertTrack(const Scene& scene, const std::atomic<bool>* stop) {
  const AgentParams params = MakeAgentParams("expert", 1);
  std::atomic<bool> done{false};
  LoopOptions loop;
  loop.virtual_time = true;
  loop.seconds = CalcAgentTime(params, scene);
  loop.output.log = LoopLog::kNone;
  loop.stop = &done;
  loop.driver.make_hand = MakeAgent(params, scene, &done);
  ToolTrack track;
  loop.watchers.take_tick = [&](const LoopTick& tick, std::span<const double>) { track.Take(tick); };
  RunLoop(scene, loop, [&](const std::string&, double) {
    if (stop != nullptr && stop->load()) throw Error("the expert's attempt was interrupted");
  });
  return track;
}

std::shared_ptr<const ToolTrack> ExpertTracks::Get(const Scene& scene, const std::atomic<bool>* stop) {
  const std::lock_guard lock(mutex_);
  for (const Entry& entry : entries_) {
    if (entry.scene == scene.name && entry.level == scene.exercise.level) return entry.track;
  }
  auto track = std::make_shared<const ToolTrack>(MakeExpertTrack(scene, stop));
  entries_.push_back({scene.name, scene.exercise.level, track});
  return track;
}

}  // namespace kerf
