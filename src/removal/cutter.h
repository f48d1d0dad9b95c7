// Taking bone away where the saw has been.
#pragma once

#include <array>
#include <memory>

#include "kerf/bone.h"
#include "kerf/geometry.h"
#include "kerf/tool.h"

namespace kerf {

/// Removes what the disc sweeps, with sub-voxel precision: phi <- max(phi, -distance to the swept space). The rule does
/// not depend on order and does nothing the second time; both hold bit for bit.
///
/// Only what a step can change is looked at: the leaves around the half of the rim that moves outwards. The flats of
/// the disc change nothing while it moves in its own plane; when it has moved along its spindle or tilted, by more than
/// kFlankTolerance voxels at the rim since they were last looked at, all leaves at the disc are.
class Cutter {
 public:
  static constexpr double kFlankTolerance = 0.01;  // of a voxel's edge

  /// `removed_mm3_by_region[region]` grows with each cut. The bone must outlive the cutter and not be replaced.
  Cutter(Bone& bone, const DiscSaw& saw);
  ~Cutter();
  Cutter(Cutter&&) noexcept;
  Cutter& operator=(Cutter&&) noexcept;

  /// Cuts from X_from to X_to, which must be near each other (see Simulation for the sub-steps). Returns the removed
  /// volume, mm^3, which is exactly the loss of bone.CalcVolume() up to rounding. Tick-safe: not yet; a leaf that is
  /// cut for the first time where a tile stood is allocated.
  double Cut(const Pose& X_from, const Pose& X_to);

  /// The tool is taken away; the next cut may begin anywhere.
  void Lift();

  const std::array<double, 256>& removed_mm3_by_region() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace kerf
