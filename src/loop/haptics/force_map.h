// Maps the simulated force on the hand to a force that a device can output.
#pragma once

#include <cstdint>
#include <limits>

#include "device/devices/force_table.h"
#include "kerf/device.h"
#include "kerf/geometry.h"

namespace kerf {

struct ForceMapParams {
  double expected_peak_N = 28;
  double expected_peak_torque_Nmm = 400;
  double knee = 0.9;          // 1: hard limit
  double slew_N_per_s = 0;    // 0: from zero to the peak in 5 ms
  double slew_Nmm_per_s = 0;  // 0: likewise
  double ramp_in_s = 0.5;
  double thermal_s = 10;
};

/// The keys that [device] of a scene has too; it always gives a slew rate.
template <typename Params, typename V>
void DescribeForceScale(Params& p, double& ramp_s, bool slew_or_zero, V&& visit) {
  visit("expected_peak_N", p.expected_peak_N, kExpectedPeakRange_N,
        "simulated force that is scaled to the device's peak force, if it is larger than this peak");
  visit("expected_peak_torque_Nmm", p.expected_peak_torque_Nmm, Range{1, 1e7},
        "simulated torque that is scaled to the device's peak torque, if it is larger than this peak");
  visit("slew_N_per_s", p.slew_N_per_s, Range{1, 1e7, slew_or_zero}, "maximum rate of change of the device's force");
  visit("ramp_s", ramp_s, Range{0, 60}, "time over which the force ramps up at the start and after each fault");
}
template <typename V>
void Describe(ForceMapParams& p, V&& visit) {
  DescribeForceScale(p, p.ramp_in_s, kOrZero, visit);
  visit("knee", p.knee, Range{0.1, 1}, "fraction of the peak above which the force saturates smoothly");
  visit("slew_Nmm_per_s", p.slew_Nmm_per_s, Range{1, 1e9, kOrZero}, "maximum rate of change of the device's torque");
  visit("thermal_s", p.thermal_s, Range{0.1, 1e4}, "time constant of the motors' heating");
}

/// Bits of ForceMapOutput::status.
enum ForceMapStatus : std::uint32_t {
  kForceMapOk = 0,
  kForceMapNotFinite = 1u << 0,     // force is NaN or infinite, or dt is negative or not finite: no force
  kForceMapFault = 1u << 1,         // reported by the caller (watchdog, device failure, stale state): no force
  kForceMapRampIn = 1u << 2,        // reduced force after the start or a fault
  kForceMapForceLimited = 1u << 3,  // above the knee; the direction is kept
  kForceMapTorqueLimited = 1u << 4,
  kForceMapSlewLimited = 1u << 5,     // the force has not reached its target yet
  kForceMapThermalLimited = 1u << 6,  // the limit is below the peak because the motors are warm
};

/// Force and torque on the device, world frame.
struct ForceMapOutput {
  Vec3 f_H_W_N{0};
  Vec3 tau_H_W_Nmm{0};
  std::uint32_t status = kForceMapOk;
  double ramp = 0;          // 0 to 1: fraction of the force that is output
  double thermal_load = 0;  // 0 to 1: mean square of the force over the last thermal_s, relative to the square of the
                            // continuous force; 0 if the continuous force is unknown
};

/// Converts simulated force and torque to device force and torque. The steps are, in this order: scale by min(1, peak /
/// expected peak); ramp in; compress smoothly below the peak, keeping the direction, where the peak itself falls
/// towards the continuous force as the thermal load rises from 0.7 to 1; limit the slew rate. A fault sets the force to
/// zero at once, regardless of the slew rate.
///
/// For any input, including NaN and the largest doubles, the force is finite and never exceeds the device's peak, not
/// even by a rounding error. The same is true of the torque, which is zero for a device without torque output. The
/// thermal load is the exponentially weighted mean square with time constant thermal_s, since a motor's temperature
/// follows its current in this way. The load never exceeds 1.
class ForceMap {
 public:
  /// Throws a kerf::Error that names the first value that is out of range.
  ForceMap(const DeviceProfile& profile, const ForceMapParams& params = {});

  /// Computes the output for one tick of `dt_s` (limited to 0.1 s). The slew limit uses `slew_dt_s` if that is shorter,
  /// so that even after missed ticks the force changes by no more than in one tick. With a dt of 0, the force does not
  /// change. Tick-safe.
  ForceMapOutput Calc(const Vec3& f_sim_W_N, const Vec3& tau_sim_W_Nmm, double dt_s, bool fault = false,
                      double slew_dt_s = std::numeric_limits<double>::infinity());
  /// Restores the initial state. Tick-safe.
  void Reset();
  /// Starts a new ramp: the force falls to zero at the slew rate and is then ramped in. Tick-safe.
  void BeginRamp() { ramp_s_done_ = 0; }

  double force_scale() const { return force_scale_; }  // device N per simulated N
  double torque_scale() const { return torque_scale_; }
  double slew_N_per_s() const { return force_.slew_per_s; }  // on the device
  const ForceMapParams& params() const { return params_; }
  struct Counts {
    std::uint64_t ticks = 0;
    std::uint64_t faults = 0;  // ticks without force: the input was not finite, or the caller reported a fault
    std::uint64_t limited = 0;
    std::uint64_t slew_limited = 0;
    std::uint64_t thermal_limited = 0;
  };
  const Counts& counts() const { return counts_; }

 private:
  /// State of one of the two vectors.
  struct Channel {
    double scale = 1;
    double peak = 0;        // 0: no output
    double continuous = 0;  // 0: unknown
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
