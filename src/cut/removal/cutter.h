// Taking bone away where the tool has been.
#pragma once

#include <array>
#include <memory>

#include "bone/grid/field.h"
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
/// not depend on order and does nothing the second time; both hold bit for bit. Computed in float from each leaf's
/// corner, so phi is right to about 4e-7 of the tool's radius.
///
/// Work follows the newly swept shell: only leaves near the edge where it moves outwards are looked at, and of those
/// only the rows of voxels that the step can change. The flats of a disc change nothing while it moves in its own
/// plane; when it has moved along its spindle or tilted, by more than kFlankTolerance voxels at the rim since they were
/// last looked at, all that cuts is. The result is the same bits at every vector width (removal/carve.h).
class Cutter {
 public:
  static constexpr double kFlankTolerance = 0.01;  // of a voxel's edge

  /// The field must outlive the cutter. `old_leaves`: how many leaves of the bone's first surface can be cut into
  /// before their old values must be accounted for (Refill(), CalcRemovedByRegion(); 2 kB each; leaves of pure bone
  /// need none). `whole_voxels`: phi goes in steps of a voxel, as where a voxel is there or not: to show what that does
  /// to the force. `precision_bits`: of the significand of what is written, 4 to 24, as fewer would be kept. Allocates.
  Cutter(BoneField& field, const Tool& tool, CutWith with, bool whole_voxels = false, int old_leaves = 4096,
         int precision_bits = 24);
  ~Cutter();
  Cutter(Cutter&&) noexcept;
  Cutter& operator=(Cutter&&) noexcept;

  struct Result {
    double removed_mm3 = 0;      // by occupancy: sum of clamp(1/2 - phi/h, 0, 1) h^3 before less after; see
                                 // CalcRemovedByRegion for the exact one
    bool out_of_leaves = false;  // some bone was left for want of spare or old leaves; cutting the same way again
                                 // after Refill() takes it
  };
  /// Cuts from X_from to X_to, which must be near each other: CountSubsteps(). Tick-safe.
  Result Cut(const Pose& X_from, const Pose& X_to);
  /// Cuts away all that the whole tool holds at X, also with CutWith::kEdge: for a tool that is set down inside the
  /// bone. Looks at every leaf that the tool reaches. Tick-safe.
  Result CutAround(const Pose& X);

  /// Gives a leaf other values: where it is `from`, `to`; what was cut since stays cut (bone/piece_removal.h). Counts
  /// as loss of the bone, or gain. False, and nothing done, when no leaf is left for it. Tick-safe.
  bool Replace(const LeafIndex& leaf, const float* from, const float* to);

  /// Gives a leaf `values` (512) and them its own. Counts as loss of the bone, or gain; no history is told. False, and
  /// nothing done, when no leaf is left for it, or no room for old values. Tick-safe.
  bool Swap(const LeafIndex& leaf, float* values);
  /// What Swap() would need of what is set aside.
  struct Need {
    int spare_leaves = 0;
    int old_leaves = 0;
    bool outside = false;  // the leaf lies beyond the bone's box, or nothing ever was near it
  };
  void AddNeed(const LeafIndex& leaf, Need& need) const;
  bool HasRoomFor(const Need& need) const;
  /// There may be bone where there was none: which leaves are near the edge is looked up anew. Tick-safe.
  void BoneCameBack();

  /// The tool is taken away; the next cut may begin anywhere. Tick-safe.
  void Lift();

  /// Volume gone since the start by region, mm^3: exactly the loss of bone.CalcVolume() up to rounding. Not tick-safe:
  /// it looks at what has changed since it was last asked.
  const std::array<double, 256>& CalcRemovedByRegion();
  /// Makes room for the old values of all leaves again; the field's spare leaves are the caller's. Not tick-safe.
  void Refill();
  std::size_t CalcMemoryBytes() const;

  /// What the last Cut() looked at, for who studies its speed.
  struct Effort {
    int listed_leaves = 0;  // near the edge, whatever the way
    int leaves = 0;         // looked into
    int rows = 0;           // of eight voxels, worked out
    int changed_voxels = 0;
    bool listed_anew = false;
  };
  const Effort& effort() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

/// Width of the kerf that a disc leaves, mm: its thickness, but at least a little more than a voxel. A level set holds
/// no narrower slot: between two layers of voxel centres it would not be there at all, the bone would never come apart,
/// and on its way back the disc would meet what it has cut. Tick-safe.
double CalcKerfWidth(const DiscSaw& disc, double voxel_mm);

/// How many steps the way from a to b must be cut in: in one the edge moves outwards by at most half a voxel, and no
/// part of a disc along the spindle by more than a quarter of the thinner of disc and voxel: nothing is jumped over,
/// and the force sees each layer. A whole number >= 1. Tick-safe.
double CountSubsteps(const Pose& a, const Pose& b, const Tool& tool, double voxel_mm);

/// Point of the way from a to b, t from 0 to 1: straight for the origin, at constant turning speed for the orientation.
/// Tick-safe.
Pose Interpolate(const Pose& a, const Pose& b, double t);

}  // namespace kerf
