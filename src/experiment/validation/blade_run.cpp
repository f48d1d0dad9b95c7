#include "experiment/validation/blade_run.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/gtc/quaternion.hpp>
#include <numbers>
#include <string>
#include <vector>

#include "cut/force/measured.h"
#include "cut/tool/edge_down.h"
#include "experiment/validation/law_access.h"
#include "experiment/validation/rib.h"
#include "kerf/coupled.h"
#include "kerf/simulation.h"

namespace kerf {
namespace {

constexpr int kTicksPerPeriod = 16;
constexpr double kAboveRib_mm = 0.2;   // distance above the rib at the start
constexpr double kSawnFirst_mm = 0.3;  // depth at which the measurement begins
constexpr double kSawn_mm = 0.5;       // depth of the measurement, in whole periods
constexpr double kUncut_mm = 1;        // bone below the end of the cut
constexpr int kMaxPeriods = 2000;
constexpr int kStuckPeriods = 10;
constexpr int kPeriodsBetweenRefills = 64;
constexpr double kStuck_mm = 1e-4;      // way in a period below which the blade does not cut
constexpr double kHandleAhead_mm = 20;  // so far that the coupling is at its limit of force

Tool MakeBlade(const BladeCut& cut) {
  if (cut.swing_radius_mm > 0) {
    OscillatingBlade blade;
    blade.radius_mm = cut.swing_radius_mm;
    blade.swing_deg = cut.stroke_mm / cut.swing_radius_mm * 180 / std::numbers::pi;
    blade.thickness_mm = cut.width_mm;
    blade.set_mm = 0;
    blade.pitch_mm = cut.pitch_mm;
    blade.width_mm = cut.teeth * cut.pitch_mm + cut.stroke_mm + 4 * cut.pitch_mm;
    return blade;
  }
  ReciprocatingBlade blade;
  blade.thickness_mm = cut.width_mm;
  blade.set_mm = 0;
  blade.pitch_mm = cut.pitch_mm;
  blade.stroke_mm = cut.stroke_mm;
  blade.length_mm = cut.teeth * cut.pitch_mm + cut.stroke_mm + 4 * cut.pitch_mm;
  return blade;
}

/// Returns the pose of a blade whose edge lies along x at the height z and faces down.
Pose PoseAt(double z_mm) {
  return {CalcEdgeDown(), Vec3(0, kRibPlane_mm, z_mm)};
}

SimulationParams MakeParams(const ForceLaw& law, const BladeCut& cut) {
  SimulationParams params;
  params.tool = MakeBlade(cut);
  params.law = TransferLaw(law, MakeReferenceDisc(cut.width_mm), params.tool);
  params.effects = {};
  return params;
}

Bone MakeCutRib(const BladeCut& cut, double depth_mm) {
  return MakeRib(cut.teeth * cut.pitch_mm, cut.width_mm, CalcRibVoxel(cut.width_mm), depth_mm);
}

/// Sums over ticks of equal length.
struct Sums {
  int ticks = 0;
  TeethOutput teeth;
  double force_N = 0;
  void Add(const TeethOutput& out, double tick_force_N) {
    ++ticks;
    teeth.thrust_sum_N += out.thrust_sum_N;
    teeth.cutting_sum_N += out.cutting_sum_N;
    teeth.engaged_teeth += out.engaged_teeth;
    teeth.removed_mm3 += out.removed_mm3;
    force_N += tick_force_N;
  }
};

BladeRun Summarise(const ForceLaw& law, const BladeCut& cut, const Sums& sums, double tick_s) {
  BladeRun run;
  if (sums.ticks == 0) return run;
  run.removal_mm3_per_s = sums.teeth.removed_mm3 / (sums.ticks * tick_s);
  run.bite_um = 1000 * run.removal_mm3_per_s / (cut.teeth * cut.width_mm * cut.speed_mm_per_s);
  run.force_N = sums.force_N / sums.ticks;
  run.thrust_N = sums.teeth.thrust_sum_N / sums.teeth.engaged_teeth;
  run.cutting_N = HasCuttingForce(law) ? sums.teeth.cutting_sum_N / sums.teeth.engaged_teeth
                                       : run.thrust_N / kThrustPerCuttingForce;
  run.law_N = LawOnTooth(law, MakeReferenceDisc(cut.width_mm))({run.bite_um / 1000, cut.speed_mm_per_s, 1}).thrust_N;
  return run;
}

}  // namespace

BladeRun RunBladeAtBite(const ForceLaw& law, const BladeCut& cut, double bite_um) {
  const double rpm = cut.cycles_per_min();
  const double tick_s = 60 / rpm / kTicksPerPeriod;
  const double feed_mm_per_s = bite_um / 1000 * cut.speed_mm_per_s / cut.pitch_mm;
  const double tick_mm = feed_mm_per_s * tick_s;
  const int lead = static_cast<int>(std::ceil((kAboveRib_mm + kSawnFirst_mm) / tick_mm));
  const int measured = kTicksPerPeriod * static_cast<int>(std::ceil(kSawn_mm / (kTicksPerPeriod * tick_mm)));
  Simulation simulation(MakeCutRib(cut, (lead + measured) * tick_mm + kUncut_mm), MakeParams(law, cut),
                        PoseAt(kAboveRib_mm));
  Sums sums;
  for (int i = 1; i <= lead + measured; ++i) {
    const TickOutput out = simulation.Tick({PoseAt(kAboveRib_mm - i * tick_mm), tick_s, rpm});
    if (i > lead) sums.Add(out, out.f_T_W_N.z);
  }
  return Summarise(law, cut, sums, tick_s);
}

BladeRun RunBladeHeat(const ForceLaw& law, const BladeCut& cut, double feed_mm_per_s) {
  constexpr double kTick_s = 0.001;
  constexpr double kDepth_mm = 0.8;
  SimulationParams params = MakeParams(law, cut);
  params.effects = {EffectChoice("tangential_force"), EffectChoice("heat")};
  const double body_C = 37;
  Simulation simulation(MakeCutRib(cut, kDepth_mm + kUncut_mm), params, PoseAt(kAboveRib_mm));
  const std::vector<std::string> channels = simulation.ListChannels();
  const auto peak =
      static_cast<std::size_t>(std::find(channels.begin(), channels.end(), "heat.peak_C") - channels.begin());
  std::vector<double> values(channels.size());
  Sums sums;
  const int ticks = static_cast<int>(std::lround((kAboveRib_mm + kDepth_mm) / (feed_mm_per_s * kTick_s)));
  for (int i = 1; i <= ticks; ++i) {
    const double z_mm = kAboveRib_mm - i * feed_mm_per_s * kTick_s;
    const TickOutput out = simulation.Tick({PoseAt(z_mm), kTick_s, cut.cycles_per_min()});
    if (z_mm < -kSawnFirst_mm) sums.Add(out, out.f_T_W_N.z);
  }
  simulation.ReadChannels(values);
  BladeRun run = Summarise(law, cut, sums, kTick_s);
  run.rise_K = values[peak] - body_C;
  return run;
}

BladeRun RunBladeUnderForce(const ForceLaw& law, const BladeCut& cut, double force_N) {
  const double rpm = cut.cycles_per_min();
  const double tick_s = 60 / rpm / kTicksPerPeriod;
  CoupledParams params;
  static_cast<SimulationParams&>(params) = MakeParams(law, cut);
  params.coupling.max_force_N = force_N;
  params.coupling.stiffness_N_per_mm = std::max(1.0, force_N);
  params.coupling.torsion_Nmm_per_rad = 1e7;
  params.coupling.max_torque_Nmm = 1e6;
  CoupledSimulation simulation(MakeCutRib(cut, kSawnFirst_mm + kSawn_mm + kUncut_mm), params, PoseAt(kAboveRib_mm));
  Sums sums;
  double z_mm = kAboveRib_mm;
  for (int period = 0; period < kMaxPeriods && z_mm > -kSawnFirst_mm - kSawn_mm; ++period) {
    const double before_mm = z_mm;
    const bool is_measured = z_mm < -kSawnFirst_mm;
    for (int i = 0; i < kTicksPerPeriod; ++i) {
      CoupledInput in;
      in.X_WH = PoseAt(z_mm - kHandleAhead_mm);
      in.dt_s = tick_s;
      in.rpm = rpm;
      const CoupledOutput out = simulation.Tick(in);
      z_mm = out.X_WT.p_AB.z;
      if (is_measured) sums.Add(out, out.f_H_W_N.z);
    }
    if (period % kPeriodsBetweenRefills == 0) simulation.Refill();
    if (period > kStuckPeriods && before_mm - z_mm < kStuck_mm) break;
  }
  return Summarise(law, cut, sums, tick_s);
}

}  // namespace kerf
