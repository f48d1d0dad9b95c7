// A motor with its rotor: how its speed goes on, exactly for a time of any length.
#pragma once

namespace kerf {

/// J w' = T - (friction + load) sign(w) - viscous w, with the motor's torque on a line
///
///   T(w) = stall (set - w) / no_load,  no more than the stall torque either way
///
/// `set` is the speed at which the motor neither drives nor brakes: that which the operator asks for. A motor that
/// doesn't brake has T = 0 where T is against w.
struct Motor {
  double stall_torque_Nmm = 0;
  double no_load_rad_per_s = 1;  // above 0, and no less than any speed that is set
  double inertia_gmm2 = 0;
  double friction_Nmm = 0;
  double viscous_Nmms = 0;  // N mm s / rad
  bool brakes = true;

  /// N mm s^2: energy in mJ is half of it times w^2.
  double CalcInertia() const { return 1e-6 * inertia_gmm2; }
  double CalcTorque(double set_rad_per_s, double w_rad_per_s) const;
};

/// What a motor did; its energy account is closed:
/// motor = load + friction + viscous + gain of 1/2 J w^2.
struct MotorRun {
  double w_rad_per_s = 0;  // at the end
  double angle_rad = 0;
  double motor_mJ = 0;
  double load_mJ = 0;  // the load's and the losses' are never below 0
  double friction_mJ = 0;
  double viscous_mJ = 0;
};

/// Goes on from speed `w_rad_per_s` for `time_s`. The load is against the turning, whichever way that goes, and 0 or
/// more. From rest it starts only with a torque above friction and `hold_Nmm`, which counts as the load when it is
/// less. Exact but for rounding: the speed goes exponentially between those speeds at which the torque has a corner.
/// Tick-safe.
MotorRun RunMotor(const Motor& motor, double set_rad_per_s, double load_Nmm, double hold_Nmm, double w_rad_per_s,
                  double time_s);

}  // namespace kerf
