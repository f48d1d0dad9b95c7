// What happens at the handle of an emulated device: the motors' force on it, and where it goes.
#pragma once

#include <cstdint>

#include "kerf/geometry.h"

namespace kerf {

/// Frame D (devices/driver.h). Whoever emulates a device asks it.
class Mechanism {
 public:
  Mechanism() = default;
  Mechanism(const Mechanism&) = delete;
  Mechanism& operator=(const Mechanism&) = delete;
  virtual ~Mechanism() = default;

  /// dt_s go by under this force and torque of the motors.
  virtual void Move(double dt_s, const Vec3& f_D_N, const Vec3& tau_D_Nmm) = 0;
  virtual Pose handle() const = 0;
  virtual std::uint32_t buttons() const { return 0; }
};

/// A handle that is where it is put, whatever the force.
class HeldMechanism final : public Mechanism {
 public:
  void Move(double /*dt_s*/, const Vec3& f_D_N, const Vec3& /*tau_D_Nmm*/) override { f_D_N_ = f_D_N; }
  Pose handle() const override { return X_DH; }
  std::uint32_t buttons() const override { return pressed; }
  Vec3 f_D_N() const { return f_D_N_; }  // of the motors, last

  Pose X_DH;
  std::uint32_t pressed = 0;

 private:
  Vec3 f_D_N_{0};
};

}  // namespace kerf
