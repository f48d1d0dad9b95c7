#include "session/run/path_session.h"

namespace kerf {
namespace {

constexpr std::size_t kTicksBetweenProgress = 256;

}  // namespace

PathSession::PathSession(const PathDriver& driver, PathBody& body, double rpm, std::size_t ticks, const PathTape& tape)
    : driver_(driver), body_(body), rpm_(rpm), expected_ticks_(ticks), tape_(tape) {
  ticks_.reserve(ticks);
  times_us_.reserve(ticks);
}

void PathSession::Run(const std::function<void(double)>& progress) {
  while (Step()) {
    if (!progress || ticks_.size() % kTicksBetweenProgress != 0) continue;
    progress(static_cast<double>(ticks_.size()) / static_cast<double>(expected_ticks_));
  }
}

bool PathSession::Step() {
  const std::optional<PathStep> step = driver_.Next();
  if (!step) return false;
  if (step->set_down) return Place(*step);
  TickInput in{step->X_WT, step->dt_s, rpm_};
  if (tape_.replay != nullptr && !tape_.replay->Begin(in)) return false;
  TickRecord record;
  record.time_s = step->time_s;
  record.segment = step->segment;
  record.X_WT = in.X_WT;
  const Clock::time_point before = Clock::now();
  record.out = body_.Tick(in);
  times_us_.push_back(std::chrono::duration<double, std::micro>(Clock::now() - before).count());
  if (tape_.recorder != nullptr || tape_.replay != nullptr) {
    const TickToRecord tick = MakeTickToRecord(in, record.out, body_.TakeHash());
    if (tape_.recorder != nullptr) tape_.recorder->Take(tick);
    if (tape_.replay != nullptr) tape_.replay->End(tick);
  }
  Keep(*step, record);
  return true;
}

bool PathSession::Place(const PathStep& step) {
  Pose X_WT = step.X_WT;
  if (tape_.replay != nullptr && !tape_.replay->SetDown(X_WT)) return false;
  if (tape_.recorder != nullptr) tape_.recorder->TakeSetDown(X_WT);
  body_.SetDown(X_WT, step.time_s);
  p_WT_mm_ = step.X_WT.p_AB;
  return true;
}

void PathSession::Keep(const PathStep& step, TickRecord& record) {
  if (!ticks_.empty() && ticks_.back().segment == step.segment) {
    record.touched = ticks_.back().touched;
    record.travel_mm = ticks_.back().travel_mm;
  }
  record.touched = record.touched || record.out.engaged_teeth > 0;
  if (record.touched) record.travel_mm += glm::length(record.X_WT.p_AB - p_WT_mm_);
  p_WT_mm_ = record.X_WT.p_AB;
  body_.End(record, step.dt_s, times_us_.back());
  ticks_.push_back(record);
}

}  // namespace kerf
