// Synthetic surgeons: simulated hands that do an exercise as a novice or an expert would, with given errors.
#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <string_view>

#include "session/run/run_loop.h"
#include "session/scene/scene.h"

namespace kerf {

struct AgentParams {
  std::string name = "expert";
  double push_N = 2;
  double feed_share = 1;
  double tremor_mm = 0.05;
  double delay_s = 0.15;
  double lookahead_mm = 3;
  double offset_mm = 0;
  double roll_deg = 0;
  double yaw_deg = 0;
  double deeper_mm = 0;
  double pause_s = 0.3;
  int passes = 1;
  double correction_Hz = 1;
  std::uint64_t seed = 1;  // for the tremor and the signs of the errors
};

inline constexpr double kMaxAgentDelay_s = 1;
template <typename V>
void Describe(AgentParams& p, V&& visit) {
  visit("push_N", p.push_N, Range{0.1, 50}, "maximum force against resistance");
  visit("feed_share", p.feed_share, Range{0.1, 10}, "fraction of the exercise's feed rate");
  visit("tremor_mm", p.tremor_mm, Range{0, 5}, "root mean square of the tremor (8 to 12 Hz) in free air");
  visit("delay_s", p.delay_s, Range{0, kMaxAgentDelay_s}, "delay with which the agent perceives the tool's position");
  visit("lookahead_mm", p.lookahead_mm, Range{0, 50}, "distance from the goal at which it begins to slow down");
  visit("offset_mm", p.offset_mm, Range{-20, 20}, "offset of its plane from the wanted one");
  visit("roll_deg", p.roll_deg, Range{-45, 45}, "roll of its plane");
  visit("yaw_deg", p.yaw_deg, Range{-45, 45}, "yaw of its plane");
  visit("deeper_mm", p.deeper_mm, Range{-20, 20}, "error of the assumed goal, positive: deeper");
  visit("pause_s", p.pause_s, Range{0, 60}, "pause before each further step");
  visit("passes", p.passes, Range{1, 20}, "number of passes along the line");
  visit("correction_Hz", p.correction_Hz, Range{0, 5}, "rate at which it corrects perceived errors");
}

/// Returns "novice", "intermediate" and "expert".
std::span<const std::string_view> AgentNames();
/// Returns the parameters of the named agent, with errors varied by the seed: each by up to a fifth, and the offset and
/// the angles with a random sign. Throws kerf::Error for an unknown name.
AgentParams MakeAgentParams(std::string_view name, std::uint64_t seed);

/// Returns a hand for LoopOptions::make_hand that approaches, cuts down to the depth, follows the line and lifts off.
/// It feels the tool through the device, like a user. The same scene, parameters and ticks give the same motion. `done`
/// (optional) is set when the hand has finished; it must outlive the loop. Throws kerf::Error for a scene that is not
/// an exercise or for a parameter out of range.
MakeHand MakeAgent(const AgentParams& params, const Scene& scene, std::atomic<bool>* done = nullptr);

/// Returns a time that is long enough for the agent to finish, s.
double CalcAgentTime(const AgentParams& params, const Scene& scene);

/// Returns the wanted cut displaced about its centre by the given errors.
WantedCut Misplace(const WantedCut& wanted, double offset_mm, double roll_deg, double yaw_deg);

}  // namespace kerf
