// A disc in a block of bone, coupled to a handle with a prescribed path. The invariants are checked in every tick.
#pragma once

#include <utility>

#include "cut/removal/cutter.h"
#include "experiment/stability/watched.h"

namespace kerf::test {

/// In the block's frame the disc lies in the plane y = 0, z is up, and the origin is the block's centre.
struct Sawing : WatchedTool {
  Sawing(Bone bone, const CoupledParams& params, const Pose& X_WT_start)
      : WatchedTool(std::move(bone), params, X_WT_start), X_WH(X_WT_start) {
    out.X_WT = X_WT_start;
  }
  const CoupledOutput& To(const Pose& X, double rpm = 7500, double dt_s = 0.001) {
    X_WH = X;
    out = Tick(X, rpm, dt_s);
    return out;
  }
  /// Moves the handle straight to `X` in `ticks` ticks. Calls after(out) after each tick.
  template <typename After>
  void Move(const Pose& X, int ticks, double rpm, After after) {
    const Pose X_from = X_WH;
    for (int i = 1; i <= ticks; ++i) after(To(Interpolate(X_from, X, static_cast<double>(i) / ticks), rpm));
  }
  void Move(const Pose& X, int ticks, double rpm = 7500) {
    Move(X, ticks, rpm, [](const CoupledOutput&) {});
  }

  Pose X_WH;
  CoupledOutput out;
};

/// A saw that plunges into the middle of a block at 4 mm/s to a depth of `depth_mm`. The handle then stays at the
/// tool's position, so that no feed force is left.
struct InKerf : Sawing {
  InKerf(const Pose& the_X_WB, const Vec3& size_mm, double voxel_mm, double the_depth_mm, const CoupledParams& params,
         double rpm = 7500)
      : Sawing(MakeBox(the_X_WB, size_mm, voxel_mm), params, DiscPose(the_X_WB, {0, 0, 0.5 * size_mm.z + kR + 0.1})),
        X_WB(the_X_WB),
        top_mm(0.5 * size_mm.z) {
    const double z_end = top_mm + kR - the_depth_mm;
    double z = top_mm + kR + 0.1;
    for (int i = 0; i < 8000 && X_WB.InversePoint(out.X_WT.p_AB).z > z_end; ++i) {
      z = std::max(z - 0.004, z_end - 2);
      To(DiscPose(X_WB, {0, 0, z}), rpm);
    }
    p_B = X_WB.InversePoint(out.X_WT.p_AB);
    Hold(50, Vec3(0), 0, rpm);
  }
  /// Returns a handle pose at an offset from the end of the cut, tilted about the length of the kerf.
  Pose OffsetPose(const Vec3& offset_B, double tilt_rad = 0) const {
    Pose X = DiscPose(X_WB, p_B + offset_B);
    X.R_AB = X.R_AB * glm::angleAxis(tilt_rad, Vec3(1, 0, 0));
    return X;
  }
  const CoupledOutput& Hold(int ticks, const Vec3& offset_B = Vec3(0), double tilt_rad = 0, double rpm = 7500) {
    for (int i = 0; i < ticks; ++i) To(OffsetPose(offset_B, tilt_rad), rpm);
    return out;
  }
  Vec3 Place() const { return X_WB.InversePoint(out.X_WT.p_AB); }
  Vec3 ForceInBlock() const { return X_WB.InverseVector(out.f_H_W_N); }
  Vec3 TorqueInBlock() const { return X_WB.InverseVector(out.tau_H_W_Nmm); }

  static constexpr double kR = 11;  // radius of the default DiscSaw
  Pose X_WB;
  double top_mm;
  Vec3 p_B{0};
};

}  // namespace kerf::test
