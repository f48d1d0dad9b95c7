// Taking bone away where the tool has been.
#pragma once

#include <array>
#include <memory>

#include "bone/field.h"
#include "kerf/geometry.h"
#include "kerf/tool.h"

namespace kerf {

/// Which part of the tool takes bone away.
enum class CutWith {
  kWholeTool,  // a tool that follows a path whatever stands in its way: its flats cut too
  kEdge,  // a disc: only its rim, from three voxels inside it outwards; the flats are for the contact to hold. A ball:
          // all of it
};

/// Removes what the tool sweeps, with sub-voxel precision: phi <- max(phi, -distance to the swept space). The rule does
/// not depend on order and does nothing the second time; both hold bit for bit.
///
/// Work follows the newly swept shell: only leaves near the edge where it moves outwards are looked at. The result is
/// the same bits at every vector width.
class Cutter {
 public:
  /// The field must outlive the cutter. Allocates.
  Cutter(BoneField& field, const Tool& tool, CutWith with, bool whole_voxels = false);
  ~Cutter();
  Cutter(Cutter&&) noexcept;
  Cutter& operator=(Cutter&&) noexcept;

  struct Result {
    double removed_mm3 = 0;      // by occupancy: sum of clamp(1/2 - phi/h, 0, 1) h^3 before less after; see
                                 // CalcRemovedByRegion for the exact one
    bool out_of_leaves = false;  // some bone was left for want of spare leaves
  };
  /// Cuts from X_from to X_to, which must be near each other: CountSubsteps(). Tick-safe.
  Result Cut(const Pose& X_from, const Pose& X_to);

  /// The tool is taken away; the next cut may begin anywhere. Tick-safe.
  void Lift();

  /// Volume gone since the start by region, mm^3: exactly the loss of bone.CalcVolume() up to rounding. Not tick-safe:
  /// it looks at what has changed since it was last asked.
  const std::array<double, 256>& CalcRemovedByRegion();
  std::size_t CalcMemoryBytes() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

/// How many steps the way from a to b must be cut in: in one the edge moves outwards by at most half a voxel, and no
/// part of a disc along the spindle by more than a quarter of the thinner of disc and voxel. A real number >= 1, not
/// rounded down. Tick-safe.
double CountSubsteps(const Pose& a, const Pose& b, const Tool& tool, double voxel_mm);

/// Point of the way from a to b, t from 0 to 1: straight for the origin, at constant turning speed for the orientation.
/// Tick-safe.
Pose Interpolate(const Pose& a, const Pose& b, double t);

}  // namespace kerf
