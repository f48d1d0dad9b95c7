#include "session/run/loop_replay.h"

#include <algorithm>
#include <chrono>
#include <thread>

namespace kerf {

LoopReplay::LoopReplay(const LoopReplayOptions& options, StepBody& body, CoupledSimulation& simulation,
                       ReplayDevice& device)
    : options_(options), step_body_(body), device_(device) {
  if (options.recording == nullptr) return;
  steps_.emplace(*options.recording, options.until_s);
  body_.emplace(body, simulation, device, *steps_, [this](const RecordedStep& step) {
    if (between_ticks_) between_ticks_(step);
  });
}

bool LoopReplay::Step(HapticLoop& loop, const std::function<bool(double)>& read) {
  using Clock = std::chrono::steady_clock;
  const double total_s = std::min(options_.until_s, options_.recording->damage().whole_s);
  const double fraction = total_s > 0 ? body_->time_s() / total_s : 1;
  if (!read(done_ % 64 == 0 ? fraction : -1)) return false;
  if (!began_) began_ = Clock::now();
  if (options_.speed > 0) {
    const std::chrono::duration<double> at_s(body_->time_s() / options_.speed);
    std::this_thread::sleep_until(*began_ + std::chrono::duration_cast<Clock::duration>(at_s));
  }
  ++done_;
  if (!body_->Prepare() || (options_.verify && body_->check().divergence())) return false;
  return loop.StepWithoutClock();
}

void LoopReplay::HandOver() {
  device_.HandOver();
  body_->HandOver();
}

Replayed LoopReplay::MakeReport() const {
  const ReplayCheck& check = body_->check();
  return {body_->step(), body_->time_s(), check.divergence(), check.force_hash(), check.voxel_hash(), 0};
}

}  // namespace kerf
