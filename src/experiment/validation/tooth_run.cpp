#include "experiment/validation/tooth_run.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "cut/force/measured.h"
#include "experiment/validation/law_access.h"
#include "experiment/validation/rib.h"
#include "kerf/simulation.h"

namespace kerf {
namespace {

constexpr double kDisc_mm = 200;
constexpr double kRibLength_mm = 10;
constexpr double kAir_mm = 0.3;     // distance above the rib at the start
constexpr double kLead_mm = 1;      // depth at which the feed becomes the nominal one
constexpr double kSettle_mm = 0.1;  // way before the measurement
constexpr double kMeasure_mm = 0.5;
constexpr double kBelow_mm = 1;  // bone below the end of the cut

/// Moves a disc into the rib.
class Plunge {
 public:
  Plunge(Bone bone, const SimulationParams& params, double rpm)
      : simulation_(std::move(bone), params, PoseAt(kAir_mm)), rpm_(rpm) {}

  /// Moves down by `way_mm` in `steps` ticks with the given feed per turn. Returns the sums over the ticks.
  TeethOutput Move(double way_mm, int steps, double feed_per_turn_mm) {
    TeethOutput sum;
    for (int i = 1; i <= steps; ++i) {
      const TickOutput out =
          simulation_.Tick({PoseAt(z_mm_ - way_mm * i / steps), way_mm / steps / feed_per_turn_mm * 60 / rpm_, rpm_});
      sum.thrust_sum_N += out.thrust_sum_N;
      sum.cutting_sum_N += out.cutting_sum_N;
      sum.engaged_teeth += out.engaged_teeth;
      sum.mean_bite_mm += out.mean_bite_mm * out.engaged_teeth;
      sum.removed_mm3 += out.removed_mm3;
    }
    z_mm_ -= way_mm;
    return sum;
  }

 private:
  /// Returns the pose with the lowest point of the rim at the height z.
  static Pose PoseAt(double z_mm) {
    return {glm::angleAxis(-0.5 * std::numbers::pi, Vec3(1, 0, 0)), Vec3(0, kRibPlane_mm, z_mm + 0.5 * kDisc_mm)};
  }

  Simulation simulation_;
  double rpm_;
  double z_mm_ = kAir_mm;
};

}  // namespace

ToothRun RunTooth(const ForceLaw& law, double width_mm, double bite_um, double speed_mm_per_s) {
  DiscSaw disc;
  disc.diameter_mm = kDisc_mm;
  disc.thickness_mm = width_mm;
  disc.teeth = 1;
  const DiscSaw reference = MakeReferenceDisc(width_mm);
  SimulationParams params;
  params.tool = disc;
  params.law = TransferLaw(law, reference, disc);
  params.effects = {};
  params.rim_samples_per_pitch = 256;  // the pitch is the whole rim

  const double bite_mm = bite_um / 1000;
  const double voxel_mm = CalcRibVoxel(width_mm);
  const double settle_mm = std::max(kSettle_mm, 2 * bite_mm);
  const double depth_mm = kLead_mm + settle_mm + kMeasure_mm + kBelow_mm;
  const double rpm = 60 * speed_mm_per_s / (std::numbers::pi * kDisc_mm);
  Plunge plunge(MakeRib(kRibLength_mm, width_mm, voxel_mm, depth_mm), params, rpm);
  const double step_mm = 0.2 * voxel_mm;
  const auto steps = [&](double way_mm) { return static_cast<int>(std::ceil(way_mm / step_mm)); };
  plunge.Move(kAir_mm + kLead_mm, steps(kAir_mm + kLead_mm), bite_mm);
  plunge.Move(settle_mm, steps(settle_mm), bite_mm);
  const TeethOutput sum = plunge.Move(kMeasure_mm, steps(kMeasure_mm), bite_mm);

  ToothRun run{width_mm, bite_um, speed_mm_per_s};
  run.removed_bite_um = 1000 * sum.removed_mm3 / (kRibLength_mm * width_mm) * bite_mm / kMeasure_mm;
  run.reported_bite_um = 1000 * sum.mean_bite_mm / sum.engaged_teeth;
  run.thrust_N = sum.thrust_sum_N / sum.engaged_teeth;
  run.cutting_N = HasCuttingForce(law) ? sum.cutting_sum_N / sum.engaged_teeth : run.thrust_N / kThrustPerCuttingForce;
  run.law_N = LawOnTooth(law, reference)({bite_mm, speed_mm_per_s, 1}).thrust_N;
  return run;
}

}  // namespace kerf
