// A reciprocating or oscillating blade in a straight cut, in the contact and removal code that every tick uses.
#pragma once

#include "experiment/validation/measured_set.h"
#include "kerf/force.h"

namespace kerf {

/// A blade that saws through a rib of bone, of which a given number of teeth are engaged. The ticks are a 16th of the
/// period, whatever its length.
struct BladeCut {
  double width_mm = 0;  // of a tooth, and of the kerf
  double pitch_mm = 0;
  double stroke_mm = 0;
  double teeth = 1;            // engaged at once: length of the rib / pitch
  double speed_mm_per_s = 0;   // mean of the teeth: 2 x stroke x cycles
  double swing_radius_mm = 0;  // of an oscillating blade, whose stroke is along its arc; 0: a reciprocating one
  double cycles_per_min() const { return 60 * speed_mm_per_s / (2 * stroke_mm); }
};
struct BladeRun {
  double bite_um = 0;            // mean over the way of the teeth: removal rate / (teeth x width x speed)
  double removal_mm3_per_s = 0;  // from voxels
  double force_N = 0;            // mean over time, on the blade against its feed
  double thrust_N = 0;           // of a tooth: mean over time, sum over the teeth / number of engaged teeth
  double cutting_N = 0;          // likewise; thrust / kThrustPerCuttingForce for a law that states no cutting force
  double law_N = 0;              // thrust of the law at the mean bite
  double rise_K = 0;  // of the hottest bone, by the effect heat with its default parameters; RunBladeHeat() only
};

/// Moves the blade at the feed that makes its mean bite `bite_um`. Throws Error if a parameter of the law is out of
/// range.
BladeRun RunBladeAtBite(const ForceLaw& law, const BladeCut& cut, double bite_um);
/// Presses the blade with a constant force into the rib, through a coupling at its limit of force. A blade that moves
/// by less than 0.1 um in a period does not cut.
BladeRun RunBladeUnderForce(const ForceLaw& law, const BladeCut& cut, double force_N);
/// Moves the blade at a feed to a depth of 0.8 mm in ticks of 1 ms, with the effect heat.
BladeRun RunBladeHeat(const ForceLaw& law, const BladeCut& cut, double feed_mm_per_s);

}  // namespace kerf
