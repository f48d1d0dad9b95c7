// From the force on the hand in the simulation to the force that a device can make.
#pragma once

#include <cstdint>
#include <limits>

#include "device/devices/device.h"
#include "kerf/geometry.h"

namespace kerf {

struct ForceMapParams {
  double expected_peak_N = 28;            // fits the device's peak force; 0.1 to 1e4
  double expected_peak_torque_Nmm = 400;  // and this its peak torque; 1 to 1e7
  double knee = 0.9;        // share of the peak above which the force bends smoothly towards it, 0.1 to 1 (1: cut off)
  double slew_N_per_s = 0;  // of the force's vector on the device, 1 to 1e7; 0: from none to the peak in 5 ms
  double slew_Nmm_per_s = 0;  // of the torque's, 1 to 1e9; 0: likewise
  double ramp_in_s = 0.5;     // after the start and after each fault, 0 to 60
  double thermal_s = 10;      // time constant of the motors' warming up, 0.1 to 1e4
};

/// Bits of ForceMapOutput::status.
enum ForceMapStatus : std::uint32_t {
  kForceMapOk = 0,
  kForceMapNotFinite = 1u << 0,     // NaN or infinite force, or a dt below 0 or not finite: no force
  kForceMapFault = 1u << 1,         // told so by the caller (watchdog, device failed, state too old): no force
  kForceMapRampIn = 1u << 2,        // less than the whole force, after the start or a fault
  kForceMapForceLimited = 1u << 3,  // beyond the knee; the direction is kept
  kForceMapTorqueLimited = 1u << 4,
  kForceMapSlewLimited = 1u << 5,     // on the way to what was asked for
  kForceMapThermalLimited = 1u << 6,  // less than the peak allowed, since the motors have been at work
};

/// Force and torque on the device, world frame.
struct ForceMapOutput {
  Vec3 f_H_W_N{0};
  Vec3 tau_H_W_Nmm{0};
  std::uint32_t status = kForceMapOk;
  double ramp = 0;          // 0 to 1: how much of the force is let through
  double thermal_load = 0;  // mean square of the force over the last thermal_s, of that which the device bears for
                            // ever: 0 to 1; 0 when its continuous force is not known
};

/// What happens, in this order: scaled by min(1, peak / expected peak); ramped in; bent smoothly below the peak with
/// its direction kept; the peak itself falls towards the continuous force as the thermal load rises from 0.7 to 1; held
/// to the slew. A fault gives zero at once, whatever the slew.
///
/// Holds for any input, NaN and the largest doubles included: the force is finite and no longer than the device's peak,
/// the torque likewise (zero for a device that drives none), to the last bit. The thermal load, the exponentially
/// weighted mean square with time constant thermal_s (as a motor's temperature follows its current), never passes 1.
class ForceMap {
 public:
  /// Throws Error naming the first value out of range.
  ForceMap(const DeviceProfile& profile, const ForceMapParams& params = {});

  /// One tick of dt_s (held to at most 0.1 s). The slew is that of `slew_dt_s` when that is shorter: after missed ticks
  /// the force still changes by no more than in one tick. With a dt of 0 it stays as it is. Tick-safe.
  ForceMapOutput Calc(const Vec3& f_sim_W_N, const Vec3& tau_sim_W_Nmm, double dt_s, bool fault = false,
                      double slew_dt_s = std::numeric_limits<double>::infinity());
  /// As after the start. Tick-safe.
  void Reset();
  /// From where it is the force goes to zero by its slew, and comes by the ramp. Tick-safe.
  void BeginRamp() { ramp_s_done_ = 0; }

  double force_scale() const { return force_scale_; }  // device N per simulation N
  double torque_scale() const { return torque_scale_; }
  double slew_N_per_s() const { return force_.slew_per_s; }  // on the device
  const ForceMapParams& params() const { return params_; }
  struct Counts {
    std::uint64_t ticks = 0;
    std::uint64_t faults = 0;  // ticks without force: not finite, or told so
    std::uint64_t limited = 0;
    std::uint64_t slew_limited = 0;
    std::uint64_t thermal_limited = 0;
  };
  const Counts& counts() const { return counts_; }

 private:
  /// One of the two vectors on its way to the device.
  struct Channel {
    double scale = 1;
    double peak = 0;        // 0: none
    double continuous = 0;  // 0: not known
    double slew_per_s = 0;
    Vec3 last{0};
    double heat = 0;  // weighted mean square

    double CalcThermalPeak(double warming, double& load) const;
    bool Calc(const Vec3& wanted, double gain, double knee, double dt_s, double slew_dt_s, double thermal_s,
              ForceMapOutput& out, std::uint32_t limited_bit);
    void Zero(double dt_s, double thermal_s);
  };

  ForceMapParams params_;
  Channel force_;
  Channel torque_;
  double force_scale_;
  double torque_scale_;
  double ramp_s_done_ = 0;
  Counts counts_;
};

}  // namespace kerf
