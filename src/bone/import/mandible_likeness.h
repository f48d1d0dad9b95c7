// Test of whether a piece of bone looks like a mandible.
#pragma once

#include <cstdint>
#include <glm/mat3x3.hpp>
#include <string>
#include <vector>

#include "bone/import/components.h"
#include "bone/import/volume.h"

namespace kerf {

/// Result of the test. Patient axes: x to the left, y to the back, z to the head.
struct MandibleLikeness {
  bool is_mandible = false;
  double turn_deg = 0;    // of the head in the patient's axes, if the piece is a mandible only when this is undone
  Vec3 up_W{0, 0, 1};     // towards the top of that head
  std::string objection;  // the first test that failed, in words; empty for a mandible
  // If it is not a mandible: rotations into the patient's axes after which it would be one. Either one that only
  // changes signs, or, if there is none, all that exchange axes (a mandible lying on its back passes the same tests).
  std::vector<glm::dmat3> rotations;
  double back_middle =
      0;  // fraction of the volume in the back half, middle third of the width; near 0 if open to the back
  double back_left = 0, back_right = 0;                // fractions in the back half, outer thirds: the rami
  double front_middle = 0;                             // fraction in the front 40 %, middle third: the chin
  double top_left = 0, top_right = 0, top_middle = 0;  // fractions of the top quarter by thirds of the width: the
                                                       // condyles
  double top_front = 0;  // fraction of the top quarter in the front 40 %: near 0, unless a pelvis's wings end there
};

/// Tests the size (adult or adolescent: 80-150 mm wide, 50-130 mm deep, 40-120 mm high, 8-120 cm3), the arch, which
/// must be open to the back, the chin in the middle, and the rami, which must reach the top on both sides. A skull, an
/// upper jaw with its palate, a vertebra or a hyoid bone fails. The size is that of the voxels in the patient's axes,
/// whatever those of the lattice. A piece that fails is tested as one of a head turned by up to 45 degrees
/// about any axis: with its widest axis from side to side it must pass over 20 degrees of nodding, with two like sides.
/// `label` as in FindComponents().
MandibleLikeness CheckMandibleLikeness(const Volume& lattice, const std::vector<std::int32_t>& labels,
                                       std::int32_t label, const Component& component);

/// Returns the objection, followed by the rotations that would remove it, if any. Each rotation is given as the frame
/// to state for a file whose coordinates were read as `frame`.
std::string Describe(const MandibleLikeness& likeness, const std::string& frame);

/// Returns the part of this text about rotations, such as "it looks like a mandible that is upside down: ..."; empty if
/// there are none.
std::string DescribeRotations(const MandibleLikeness& likeness, const std::string& frame);

}  // namespace kerf
