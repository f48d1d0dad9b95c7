// The whole loop in virtual time: a saw in bone, held by a simulated hand on a simulated device. Includes timing faults
// between device and tick, and accounts for the energy at the handle.
#pragma once

#include <cstdint>
#include <memory>

#include "device/devices/simulated_device.h"
#include "kerf/bone.h"
#include "kerf/coupled.h"
#include "loop/haptics/haptic_step.h"

namespace kerf {

struct ClosedLoopSetup {
  CoupledParams coupled;  // its coupling is used as it is; the caller applies FitCoupling
  DeviceProfile profile;
  HandModel hand;
  ForceMapParams force_map;
  double period_s = 0.001;
  double watchdog_ms = 50;
  bool quantise = true;
  int delay_ticks = 0;  // from the computation of a force to its output
  double loop_gain = 1;
};

template <typename V>
void Describe(ClosedLoopSetup& p, V&& visit) {
  visit("period_s", p.period_s, Range{1e-5, 0.1}, "period of the ticks");
  DescribeWatchdog(p.watchdog_ms, visit);
  DescribeDelay(p.delay_ticks, visit);
  visit("loop_gain", p.loop_gain, Range{0, 1e4},
        "ratio of the force that the device outputs to the commanded force: for gain margins");
}

/// Timing faults of the ticks. During a lost tick the device keeps its last force. The next tick then advances the
/// simulation as HapticLoop does (by at most 10 ms, with the slew limit of one period). After watchdog_ms without a
/// tick the force starts again from zero.
struct TimingFaults {
  double jitter = 0;
  double tail_p999_s = 0;  // above 0: the periods are lognormally distributed, and their median is the nominal period
  double lost_share = 0;
  double burst_every_s = 0;
  double burst_s = 0;
  std::uint64_t seed = 1;
};
template <typename V>
void Describe(TimingFaults& p, V&& visit) {
  visit("jitter", p.jitter, Range{0, 0.9},
        "a period lasts (1 - jitter) to (1 + jitter) times as long, uniformly distributed");
  visit("tail_p999_s", p.tail_p999_s, Range{0, 1}, "above 0: 99.9 % of the lognormal periods are below this value");
  visit("lost_share", p.lost_share, Range{0, 0.9}, "probability that a tick is lost, independently of other ticks");
  visit("burst_every_s", p.burst_every_s, Range{0, 1e6}, "above 0: interval between bursts of lost ticks");
  visit("burst_s", p.burst_s, Range{0, 1e3}, "duration of a burst, in which all ticks are lost");
}

/// Energies since the start, mJ = N mm. Forces are those that the device outputs, motion is the true motion; both
/// include rotation.
struct PortEnergy {
  double motor_mJ = 0;          // absorbed by the scene through the motors: -sum F . dx
  double handle_mJ = 0;         // given by the hand to the handle: motor_mJ + its kinetic energy, friction and damping
  double held_mJ = 0;           // sum of 1/2 K |dx|^2: energy that a spring force can return by being held over a tick
  double exchanged_mJ = 0;      // sum of |F . dx|
  double spindle_mJ = 0;        // from the spindle, as felt by the device
  double lowest_mJ = 0;         // minimum of motor_mJ + spindle_mJ so far
  double lowest_handle_mJ = 0;  // minimum of handle_mJ + spindle_mJ so far
};

struct ClosedLoopTick {
  double time_s = 0;  // at the end of the tick
  double dt_s = 0;    // simulated time of the tick; 0: the tick was lost
  HapticTick out;     // of the last tick that was not lost
  Vec3 p_WC_mm{0};    // true position of the handle at the coupling point
  Vec3 v_WC_mm_per_s{0};
  Vec3 f_device_N{0};  // force that the motors output until this tick
  PortEnergy energy;
};

class ClosedLoop {
 public:
  /// Throws Error if a parameter is out of range.
  ClosedLoop(Bone bone, const ClosedLoopSetup& setup, const Pose& X_WH_start);
  ~ClosedLoop();

  ClosedLoopTick Step(double rpm = 7500);

  /// Use device() to set the hand's subsequent motion and its grip, and SetTiming() to set the timing faults.
  SimulatedDevice& device();
  void SetTiming(const TimingFaults& timing);
  CoupledSimulation& simulation();
  const ClosedLoopSetup& setup() const;
  const Pose& X_WH_start() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace kerf
