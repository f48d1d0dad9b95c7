// A single tooth in a straight cut, in the contact and removal code that every tick uses.
#pragma once

#include "kerf/force.h"

namespace kerf {

/// A cut in steady state. A disc of 200 mm with one tooth moves straight into the edge of a rib of bone that is 10 mm
/// long and wider than the tooth. Its feed per turn is the nominal bite; on so short a part of so large a disc, the
/// bite is the same everywhere to within 0.13 %.
struct ToothRun {
  double width_mm = 0;
  double bite_um = 0;           // nominal: feed per turn
  double speed_mm_per_s = 0;    // of the tooth
  double removed_bite_um = 0;   // volume removed per turn / (length of the rib x width of the tooth)
  double reported_bite_um = 0;  // mean over the engaged teeth, as ticks report it
  double thrust_N = 0;          // sum over the teeth / number of engaged teeth
  double cutting_N = 0;         // likewise; thrust / kThrustPerCuttingForce for a law that states no cutting force
  double law_N = 0;             // thrust of the law at the nominal bite
};

/// Throws Error if a parameter of the law or the width is out of range. `bite_um`: 0.01 to 2000.
ToothRun RunTooth(const ForceLaw& law, double width_mm, double bite_um, double speed_mm_per_s);

}  // namespace kerf
