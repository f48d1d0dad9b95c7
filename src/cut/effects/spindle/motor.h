// A motor with its rotor: the speed as a function of time, exact for a step of any length.
#pragma once

namespace kerf {

/// Model: J w' = T - (friction + load) sign(w) - viscous w, with the motor's torque on a line
///
///   T(w) = stall (set - w) / no_load, limited to the stall torque in both directions.
///
/// `set` is the speed at which the motor neither drives nor brakes: the speed that the operator requests. For a motor
/// that does not brake, T = 0 where T is against w.
struct Motor {
  double stall_torque_Nmm = 0;
  double no_load_rad_per_s = 1;  // above 0, and not below any speed that is set
  double inertia_gmm2 = 0;
  double friction_Nmm = 0;
  double viscous_Nmms = 0;  // N mm s / rad
  bool brakes = true;

  /// Returns the inertia, N mm s^2; half of it times w^2 is the energy in mJ.
  double CalcInertia() const { return 1e-6 * inertia_gmm2; }
  double CalcTorque(double set_rad_per_s, double w_rad_per_s) const;
};

/// Result of running a motor for some time. The energy balance is closed: motor = load + friction + viscous + increase
/// of 1/2 J w^2.
struct MotorRun {
  double w_rad_per_s = 0;  // at the end
  double angle_rad = 0;
  double motor_mJ = 0;
  double load_mJ = 0;  // load and losses are never below 0
  double friction_mJ = 0;
  double viscous_mJ = 0;
};

/// Advances the speed from `w_rad_per_s` by `time_s`. The load is 0 or more and acts against the rotation in either
/// direction. From rest the motor starts only if its torque exceeds the friction plus the larger of `load_Nmm` and
/// `hold_Nmm`. Exact except for rounding: the speed is exponential in time between the speeds at which the torque has a
/// corner. Tick-safe.
MotorRun RunMotor(const Motor& motor, double set_rad_per_s, double load_Nmm, double hold_Nmm, double w_rad_per_s,
                  double time_s);

}  // namespace kerf
