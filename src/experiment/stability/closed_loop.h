// A saw in bone, in a simulated hand, on a simulated device: the whole loop in virtual time, with what can go wrong
// between device and tick, and the energy at the handle accounted for.
#pragma once

#include <cstdint>
#include <memory>

#include "device/devices/simulated_device.h"
#include "kerf/bone.h"
#include "kerf/coupled.h"
#include "loop/haptics/haptic_step.h"

namespace kerf {

struct ClosedLoopSetup {
  CoupledParams coupled;  // its coupling as it is to be tried: FitCoupling is the caller's
  DeviceProfile profile;
  HandModel hand;
  ForceMapParams force_map;
  double period_s = 0.001;
  double watchdog_ms = 50;
  bool quantise = true;
  int delay_ticks = 0;   // from the force worked out to the force there
  double loop_gain = 1;  // the device makes so many times the force it is asked for: for gain margins
};

/// What time does to the ticks. A lost tick leaves the device with its last force; the next one then moves the
/// simulation on as HapticLoop does (at most 10 ms, the slew that of one period), after watchdog_ms from zero force.
struct TimingFaults {
  double jitter = 0;         // a period lasts 1 - jitter to 1 + jitter times as long, evenly distributed; 0 to 0.9
  double tail_p999_s = 0;    // above 0: lognormal, the median a period, 99.9 % below this
  double lost_share = 0;     // of the ticks, each by itself; 0 to 0.9
  double burst_every_s = 0;  // above 0: so often ...
  double burst_s = 0;        // ... all ticks of so long are lost
  std::uint64_t seed = 1;
};

/// Since the start, mJ = N mm; forces as the device makes them, motion the true one, of turning too.
struct PortEnergy {
  double motor_mJ = 0;  // that the scene has taken up through the motors: -sum F . dx
  double handle_mJ =
      0;  // that the hand has given to the handle: motor_mJ + the handle's motion + its friction and damping
  double held_mJ = 0;           // sum of 1/2 K |dx|^2: what holding a spring's force over a tick can give back
  double exchanged_mJ = 0;      // sum of |F . dx|
  double spindle_mJ = 0;        // that the spindle put in, as the device feels it
  double lowest_mJ = 0;         // least of motor_mJ + spindle_mJ so far
  double lowest_handle_mJ = 0;  // least of handle_mJ + spindle_mJ so far
};

struct ClosedLoopTick {
  double time_s = 0;     // at its end
  double dt_s = 0;       // that the simulation moved on by; 0: lost
  HapticStepOutput out;  // of the last tick that was not lost
  Vec3 p_WC_mm{0};       // handle, true, where the coupling holds it
  Vec3 v_WC_mm_per_s{0};
  Vec3 f_device_N{0};  // that the motors made up to now
  PortEnergy energy;
};

class ClosedLoop {
 public:
  /// Throws Error for a parameter out of range.
  ClosedLoop(Bone bone, const ClosedLoopSetup& setup, const Pose& X_WH_start);
  ~ClosedLoop();

  ClosedLoopTick Step(double rpm = 7500);

  /// What the hand does, from now on; the grip; what goes wrong.
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
