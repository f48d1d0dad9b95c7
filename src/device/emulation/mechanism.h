// Motion of the handle of an emulated device under the force of its motors.
#pragma once

#include <cstdint>

#include "kerf/geometry.h"

namespace kerf {

/// Interface used by the device models. Frame D (devices/driver.h).
class Mechanism {
 public:
  Mechanism() = default;
  Mechanism(const Mechanism&) = delete;
  Mechanism& operator=(const Mechanism&) = delete;
  virtual ~Mechanism() = default;

  /// Advances the motion by dt_s under this force and torque from the motors.
  virtual void Move(double dt_s, const Vec3& f_D_N, const Vec3& tau_D_Nmm) = 0;
  virtual Pose handle() const = 0;
  virtual std::uint32_t buttons() const { return 0; }
};

/// Handle whose pose is set directly and which does not respond to force.
class PrescribedMechanism final : public Mechanism {
 public:
  void Move(double /*dt_s*/, const Vec3& f_D_N, const Vec3& /*tau_D_Nmm*/) override { f_D_N_ = f_D_N; }
  Pose handle() const override { return X_DH; }
  std::uint32_t buttons() const override { return pressed; }
  Vec3 f_D_N() const { return f_D_N_; }  // last force of the motors

  Pose X_DH;
  std::uint32_t pressed = 0;

 private:
  Vec3 f_D_N_{0};
};

}  // namespace kerf
