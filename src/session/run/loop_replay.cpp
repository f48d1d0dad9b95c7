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

void LoopReplay::RunWithoutClock(HapticLoop& loop, const std::function<bool(double)>& read) {
  using Clock = std::chrono::steady_clock;
  const double total_s = std::min(options_.until_s, options_.recording->damage().whole_s);
  const Clock::time_point began = Clock::now();
  std::uint64_t done = 0;
  loop.RunWithoutClock([&] {
    const double fraction = total_s > 0 ? body_->time_s() / total_s : 1;
    if (!read(done % 64 == 0 ? fraction : -1)) return false;
    if (options_.speed > 0) {
      std::this_thread::sleep_until(began + std::chrono::duration_cast<Clock::duration>(
                                                std::chrono::duration<double>(body_->time_s() / options_.speed)));
    }
    ++done;
    const bool more = body_->Prepare();
    return more && !(options_.verify && body_->check().divergence());
  });
  read(1);
  device_.HandOver();
  body_->HandOver();
}

Replayed LoopReplay::MakeReport() const {
  const ReplayCheck& check = body_->check();
  return {body_->step(), body_->time_s(), check.divergence(), check.force_hash(), check.voxel_hash(), 0};
}

}  // namespace kerf
