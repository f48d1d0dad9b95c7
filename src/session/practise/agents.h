// Synthetic surgeons: hands that do an exercise as novices and experts would, with the errors that they are given.
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
  double push_N = 2;         // leans no harder than this into what resists, 0.1 to 50
  double feed_share = 1;     // of the exercise's feed, 0.1 to 10
  double tremor_mm = 0.05;   // root mean square in free air, 8 to 12 Hz, 0 to 5
  double delay_s = 0.15;     // it sees where the tool is so much later, 0 to 1
  double lookahead_mm = 3;   // so far before the goal it begins to slow down, 0 to 50
  double offset_mm = 0;      // its plane is so far beside the wanted one, -20 to 20
  double roll_deg = 0;       // and leans so much, -45 to 45
  double yaw_deg = 0;        // and is turned so much, -45 to 45
  double deeper_mm = 0;      // it takes the goal to be so much deeper, -20 to 20
  double pause_s = 0.3;      // before each next step, 0 to 60
  int passes = 1;            // along the line, 1 to 20
  double correction_Hz = 1;  // how quickly it corrects what it sees to be off, 0 to 5
  std::uint64_t seed = 1;    // of tremor and of the errors' signs
};

/// "novice", "intermediate", "expert".
std::span<const std::string_view> AgentNames();
/// The preset with its errors varied by the seed: each by up to a fifth, offset and angles to either side. Throws Error
/// for a name that there is none of.
AgentParams MakeAgentParams(std::string_view name, std::uint64_t seed);

/// For LoopOptions::make_hand: approaches, cuts down to the depth, goes along the line, lifts off. It feels the tool
/// through the device like anyone. The same scene, parameters and ticks give the same motion. `done`, unless null, is
/// set when it has finished, and must outlive the loop. Throws Error for a scene that is no exercise and for a
/// parameter out of range.
MakeHand MakeAgent(const AgentParams& params, const Scene& scene, std::atomic<bool>* done = nullptr);

/// Long enough for the agent, s.
double CalcAgentTime(const AgentParams& params, const Scene& scene);

/// The wanted cut as somebody takes it to be who is off by so much, about its middle.
WantedCut Misplace(const WantedCut& wanted, double offset_mm, double roll_deg, double yaw_deg);

}  // namespace kerf
