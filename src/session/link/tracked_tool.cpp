#include "session/link/tracked_tool.h"

#include <fmt/format.h>

#include <utility>

#include "kerf/error.h"
#include "session/link/igtl_message.h"

namespace kerf {

void TrackedTool::Take(std::span<const std::uint8_t> content) {
  try {
    const Pose X_WH = ReadIgtlTransform(content);
    if (!IsInWorld(X_WH.p_AB)) {
      throw Error(fmt::format("a tracked tool is more than {:g} m away from the origin", 1e-3 * kWorldReach_mm));
    }
    const std::lock_guard lock(mutex_);
    X_WH_ = X_WH;
    fresh_ = true;
  } catch (const Error&) {
    const std::lock_guard lock(mutex_);
    bad_ = true;
    throw;
  }
}

RoundEnd TrackedTool::Fetch(Pose& X_WH) noexcept {
  const std::lock_guard lock(mutex_);
  if (std::exchange(bad_, false)) return RoundEnd::kBadAnswer;  // a valid pose waits for the next round
  if (!std::exchange(fresh_, false)) return RoundEnd::kNoAnswer;
  X_WH = X_WH_;
  return RoundEnd::kSample;
}

bool ToolHolder::Accepts(std::uint64_t peer, Clock::time_point now) {
  if (peer_ != 0 && peer_ != peer && now - at_ < kSilent) return false;
  peer_ = peer;
  at_ = now;
  return true;
}

void ToolHolder::Leave(std::uint64_t peer) {
  if (peer_ == peer) peer_ = 0;
}

TrackedToolDriver::TrackedToolDriver(std::shared_ptr<TrackedTool> tool) : tool_(std::move(tool)) {
  profile_.name = kTrackedToolName;
  profile_.peak_force_N = 0;
  traits_.makes_force = false;
  traits_.senses_orientation = true;
  traits_.homes = true;
  traits_.homing = "waits for TRANSFORM messages named kerf_hand";
}

RoundEnd TrackedToolDriver::Exchange(const DriverCommand&, DriverSample& sample) noexcept {
  DriverSample taken;
  const RoundEnd end = tool_->Fetch(taken.X_DH);
  if (end == RoundEnd::kSample) sample = taken;
  return end;
}

ServoParams MakeTrackedToolParams() {
  ServoParams params;
  params.silent_s = 0.2;
  params.max_speed_mm_per_s = 1000;
  params.max_speed_rad_per_s = 10;
  return params;
}

}  // namespace kerf
