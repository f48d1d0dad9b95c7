// Setup for a slice: profiles, parameters and a hand that moves along the rail.
#pragma once

#include <cmath>

#include "kerf/slab.h"

namespace kerf::test {

inline constexpr double kTick_s = 0.001;
inline constexpr double kRpm = 7500;

/// Makes a profile of one layer, `end_mm` deep, whose top is reached with the disc's centre one radius above y = 0.
/// With E = 0 there is nothing to cut.
inline SlabProfile UniformProfile(double E_MPa, double nu, double end_mm) {
  SlabProfile profile;
  profile.layers.push_back({0, E_MPa > 0 ? 24 : 0, E_MPa, nu});
  profile.end_mm = end_mm;
  profile.entry_mm = 0;
  return profile;
}

/// Returns the pose of the hand for which the blade's edge, coupled without stretch, is `depth_mm` deep.
inline Pose HandAt(double depth_mm, const SlabParams& params) {
  return {Quat(1, 0, 0, 0), (depth_mm - params.saw.radius_mm()) * params.direction_W};
}

/// Moves the hand from one depth to another at `mm_per_s`, calling after(out) each tick.
template <typename After>
void Move(SlabSimulation& simulation, const SlabParams& params, double from_mm, double to_mm, double mm_per_s,
          After after, double rpm = kRpm) {
  const double step = (to_mm > from_mm ? mm_per_s : -mm_per_s) * kTick_s;
  const int count = static_cast<int>(std::round((to_mm - from_mm) / step));
  for (int i = 1; i <= count; ++i) {
    after(simulation.Tick({HandAt(from_mm + i * step, params), kTick_s, rpm}));
  }
}

/// Returns the energy that is not accounted for, mJ, since a state of rest with slack springs.
inline double CalcImbalance(const SlabState& s) {
  return s.kinetic_mJ + s.elastic_mJ -
         (s.hand_work_mJ - s.friction_mJ - s.cutting_mJ - s.damping_mJ - s.released_mJ - s.numerical_mJ);
}

/// Returns the force on the hand that opposes the cut, N.
inline double Against(const TickOutput& out, const SlabParams& params) {
  return -glm::dot(out.f_T_W_N, params.direction_W);
}

}  // namespace kerf::test
