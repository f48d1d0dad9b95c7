// Does a piece of bone look like a mandible?
#pragma once

#include <cstdint>
#include <glm/mat3x3.hpp>
#include <string>
#include <vector>

#include "bone/import/components.h"
#include "bone/import/volume.h"

namespace kerf {

/// What was looked at, and what spoke against it. Patient axes: x to the left, y to the back, z to the head.
struct MandibleLikeness {
  bool is_mandible = false;
  std::string objection;  // the first test that failed, in words; empty for a mandible
  // Rotations into the patient's axes after which it would look like one, when it does not as it is: the one that only
  // changes signs, or else all that exchange axes (lying on its back a mandible passes the same tests).
  std::vector<glm::dmat3> turns;
  double back_middle =
      0;  // share of the volume in the back half, middle third of the width: open to the back when near 0
  double back_left = 0, back_right = 0;                // shares in the back half, outer thirds: the rami
  double front_middle = 0;                             // share in the front 40 %, middle third: the chin
  double top_left = 0, top_right = 0, top_middle = 0;  // shares of the top quarter by thirds of the width: the condyles
};

/// Tests size (adult or adolescent: 80-150 mm wide, 50-130 deep, 40-120 high, 8-120 cm3), the arch that is open to the
/// back, the chin in the middle, and a ramus that ends on top at both sides. A skull, an upper jaw with its palate, a
/// vertebra or a hyoid bone fails. `label` as in FindComponents.
MandibleLikeness CheckMandibleLikeness(const Volume& lattice, const std::vector<std::int32_t>& labels,
                                       std::int32_t label, const Component& component);

/// The objection, and behind it where there are any the turns that would remove it, as the frame to state for a file
/// whose coordinates were read as `frame`.
std::string Describe(const MandibleLikeness& likeness, const std::string& frame);

/// The turns' part of that: "it looks like a mandible that is upside down: ..."; empty without any.
std::string DescribeTurns(const MandibleLikeness& likeness, const std::string& frame);

}  // namespace kerf
