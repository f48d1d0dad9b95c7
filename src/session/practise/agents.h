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
  double push_N = 2;         // maximum force against resistance, 0.1 to 50
  double feed_share = 1;     // fraction of the exercise's feed rate, 0.1 to 10
  double tremor_mm = 0.05;   // root mean square of the tremor (8 to 12 Hz) in free air, 0 to 5
  double delay_s = 0.15;     // delay with which the agent perceives the tool's position, 0 to 1
  double lookahead_mm = 3;   // distance from the goal at which it begins to slow down, 0 to 50
  double offset_mm = 0;      // offset of its plane from the wanted one, -20 to 20
  double roll_deg = 0;       // roll of its plane, -45 to 45
  double yaw_deg = 0;        // yaw of its plane, -45 to 45
  double deeper_mm = 0;      // error of the assumed goal, positive: deeper, -20 to 20
  double pause_s = 0.3;      // pause before each further step, 0 to 60
  int passes = 1;            // number of passes along the line, 1 to 20
  double correction_Hz = 1;  // rate at which it corrects perceived errors, 0 to 5
  std::uint64_t seed = 1;    // for the tremor and the signs of the errors
};

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
