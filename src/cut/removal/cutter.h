// Removal of bone along the motion of the tool.
#pragma once

#include <array>
#include <memory>

#include "bone/grid/field.h"
#include "cut/tool/edge_motion.h"
#include "kerf/geometry.h"
#include "kerf/tool.h"

namespace kerf {

/// Part of the tool that removes bone.
enum class CutWith {
  kWholeTool,  // for a tool that follows a prescribed path: a blade's flats cut too
  /// For a tool coupled to a handle. Of a blade, only the edge cuts, to the depth CalcToothSide(); contact handles the
  /// flats. Of a ball, the whole surface cuts.
  kEdge,
};

/// Removes the sweep of the tool with sub-voxel precision: phi <- max(phi, -distance to the swept space). The rule is
/// independent of order and idempotent, bit for bit. Metal is not removed: phi stays as it is at voxels whose region is
/// metal. It is computed in float relative to each leaf's corner, with an
/// error in phi of about 4e-7 of the tool's radius.
///
/// The work is proportional to the newly swept shell: only leaves near the edge where it moves outwards are visited,
/// and in those only the bricks of eight voxels that the step can change (NearBricks). While a blade moves in its own
/// plane its flats change nothing. After it has moved along its spindle or tilted by more than kBladeTolerance voxels
/// at the rim since the last full visit, all of the cutting zone is visited. The result is bit-identical at every
/// vector width (removal/carve.h).
class Cutter {
 public:
  static constexpr double kFlankTolerance = 0.01;   // voxels
  static constexpr double kBladeTolerance = 0.002;  // of the flats of a blade, voxels

  /// `field` must outlive the cutter.
  /// `whole_voxels`: writes phi in steps of a voxel, as for voxels that are either present or absent. This shows the
  /// effect of whole-voxel removal on the force.
  /// `precision_bits`: number of significand bits that are kept in written values, 4 to 24, to study storage with
  /// fewer. Allocates.
  Cutter(BoneField& field, const Tool& tool, CutWith with, bool whole_voxels = false, int precision_bits = 24);
  ~Cutter();
  Cutter(Cutter&&) noexcept;
  Cutter& operator=(Cutter&&) noexcept;

  struct Result {
    /// Volume removed, mm3, by occupancy: sum of clamp(1/2 - phi/h, 0, 1) h^3 before, less the same after. The exact
    /// volume comes from CalcRemovedByRegion().
    double removed_mm3 = 0;
    /// Bone was left for lack of spare leaves. The same cut with more leaves removes it.
    bool out_of_leaves = false;
  };
  /// Cuts from X_from to X_to. The poses must be as close together as CountSubsteps() requires. `slide`: displacements
  /// that the edge passes in this time, of a tool with a stroke. Tick-safe.
  Result Cut(const Pose& X_from, const Pose& X_to, const SlideRange& slide = {});
  /// Removes all bone inside the whole tool at X, also with CutWith::kEdge: for a tool that is set down inside bone.
  /// Visits every leaf that the tool reaches. Tick-safe.
  Result CutAround(const Pose& X, const SlideRange& slide = {});

  /// Changes the values of a leaf from `from` to `to`. Bone that was cut in the meantime stays cut
  /// (bone/grid/piece_removal.h). Counts as a loss or gain of bone. Returns false and changes nothing if no leaf is
  /// left for it. Tick-safe.
  bool Replace(const LeafIndex& leaf, const float* from, const float* to);

  /// Exchanges the values of a leaf with `values` (512). Counts as a loss or gain of bone; adds nothing to the history.
  /// Returns false and changes nothing if no leaf is left for it. Tick-safe.
  bool Swap(const LeafIndex& leaf, float* values);
  /// Reserves that calls of Swap() would use.
  struct Need {
    int spare_leaves = 0;
    bool outside = false;  // the leaf lies outside the bone's box
  };
  void AddNeed(const LeafIndex& leaf, Need& need) const;
  bool HasRoomFor(const Need& need) const;
  /// Must be called after bone was restored: discards the lists of leaves near the edge. Tick-safe.
  void BoneRestored();

  /// Lifts the tool off: the next cut may begin anywhere. Tick-safe.
  void Lift();

  /// Returns the volume removed since the start by region, mm3. It equals the loss of bone.CalcVolume() up to rounding.
  /// Not tick-safe: it visits all that has changed since the last call.
  const std::array<double, 256>& CalcRemovedByRegion();
  std::size_t CalcMemoryBytes() const;

  /// Counts of the work of the last Cut(), for studies of speed.
  struct Effort {
    int listed_leaves = 0;    // leaves near the edge, in any direction
    int leaves = 0;           // visited leaves
    int searched_leaves = 0;  // of these, those whose bricks were searched and not kept
    int bricks = 0;           // computed bricks of eight voxels
    int changed_voxels = 0;
    bool is_new_list = false;  // a new list of leaves was made
  };
  const Effort& effort() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

/// Returns the width of the kerf that a blade leaves, mm: its thickness, but at least slightly more than a voxel. A
/// level set cannot represent a narrower kerf: between two layers of voxel centres it would vanish, the bone would
/// never come apart, and on its way back the blade would touch bone that it has cut. Tick-safe.
double CalcKerfWidth(double thickness_mm, double voxel_mm);

/// Returns the number of steps into which the motion from a to b must be divided, a whole number >= 1. In one step the
/// edge moves outwards by at most half a voxel, not counting its stroke, and no part of a blade moves along the spindle
/// by more than a quarter of its thickness or of a voxel, whichever is less. A rotation moves no part of a solid of
/// revolution by more than a quarter of a voxel. Therefore no bone is skipped, and each layer affects the force.
/// Tick-safe.
double CountSubsteps(const Pose& a, const Pose& b, const Tool& tool, double voxel_mm);

/// Returns a pose on the way from a to b, t from 0 to 1. The origin moves on a straight line, the orientation at
/// constant angular velocity. Tick-safe.
Pose Interpolate(const Pose& a, const Pose& b, double t);

}  // namespace kerf
