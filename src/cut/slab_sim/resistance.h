// Cutting resistance of the slice as a function of depth: the paper's law in one of its two readings, for the tick.
#pragma once

#include <vector>

#include "kerf/slab.h"

namespace kerf {

/// Result of the law at one depth.
struct SlabLoad {
  double force_N = 0;
  double teeth = 0;
  double E_MPa = 0;  // as_computed: of the layer at this depth; corrected: mean over the engaged teeth
};

/// Resistance by depth in the two readings.
/// - as_computed: n^3 F_1 with the material of the layer at the blade's edge. It is constant between the depths at
///   which a tooth or a layer is added, and exact.
/// - corrected: sum of F_1 / pitch along the true arc, each tooth with the layer at its own depth. It is tabulated
///   every kTableStep_mm and interpolated linearly. The error is below 0.1 % from a depth of 0.5 mm on; close to zero
///   depth, the table does not resolve the square-root onset of the arc.
class SlabResistance {
 public:
  static constexpr double kTableStep_mm = 0.02;

  SlabResistance(const SlabProfile& profile, const SlabParams& params);
  /// Returns zero outside 0..end. O(log of the number of pieces). Tick-safe.
  SlabLoad At(double depth_mm) const;
  std::size_t CalcMemoryBytes() const { return pieces_.capacity() * sizeof(Piece); }

 private:
  struct Piece {
    double top_mm;
    SlabLoad load;  // as_computed: on the whole piece; corrected: at its top
  };
  void AddStairs(const SlabProfile& profile, const SlabParams& params);
  void AddTable(const SlabProfile& profile, const SlabParams& params);

  bool linear_;
  double end_mm_;
  std::vector<Piece> pieces_;
};

}  // namespace kerf
