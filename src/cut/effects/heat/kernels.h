// Operations of a frame on the 8^3 nodes of a heat block: vector code for any vector width.
#pragma once

#include <array>
#include <cstddef>

namespace kerf::heat {

constexpr int kSide = 8;  // nodes along a block's edge
constexpr int kNodes = kSide * kSide * kSide;
constexpr int kRow = kSide + 2;  // length of a row of a block with a layer of its neighbours on each side
constexpr int kLayer = kRow * kRow;
constexpr float kMinFraction = 0.5F;  // minimum fraction of a cell that is bone; a cell with less counts as empty

using Nodes = std::array<float, kNodes>;  // z fastest, y next
using PaddedNodes = std::array<float, kRow * kLayer>;

/// Returns the index of a node in a padded block. Coordinates: 0 to 7 along each axis; -1 or 8 for the neighbours'
/// layer.
constexpr int PaddedAt(int x, int y, int z) {
  return (x + 1) * kLayer + (y + 1) * kRow + z + 1;
}

/// Computes the temperatures after a frame of conduction; `conduction` is alpha frame / spacing^2. Heat flows between
/// cells through the smaller of their fractions of bone (`fraction`). `all_bone`: all fractions are 1.
void Conduct(const PaddedNodes& theta, const PaddedNodes& fraction, bool all_bone, float conduction, Nodes& after);

/// Newton's law of cooling at bare surfaces, implicit. The area of a surface within a cell is the gradient of the bone
/// fraction.
struct Surface {
  // Loss of a cell of bone with one bare face to air and to coolant in a frame, relative to its excess.
  float air = 0;
  float coolant = 0;
  float coolant_K = 0;  // above body temperature
  bool wet = false;     // some nodes may be in the region with coolant
  // The region with coolant, a cylinder: position of the block's first node relative to its middle, mm; axis; size.
  std::array<float, 3> first_mm{};
  std::array<float, 3> axis{};
  float spacing_mm = 0;
  float radius_mm = 0;
  float half_mm = 0;
};
/// Heat lost, as sums of fraction times K.
struct SurfaceLoss {
  double air = 0;
  double coolant = 0;
};
SurfaceLoss CoolSurface(const PaddedNodes& fraction, const Surface& surface, Nodes& theta);

/// Excess temperature after perfusion by blood.
struct Perfused {
  double lost = 0;  // sum of fraction times K
  float hottest_K = 0;
  float coldest_K = 0;
  float was_hottest_K = 0;  // before the frame
};
Perfused Perfuse(const Nodes& fraction, float kept_fraction, const Nodes& before, Nodes& after);

/// Time above a limit and CEM43 (Sapareto and Dewey 1984), both from the mean of the temperatures before and after.
struct DoseRule {
  float frame_s = 0;
  float from_K = 0;   // no dose below this
  float base_K = 0;   // 43 C
  float max_K = 0;    // largest excess over base_K that counts
  float limit_K = 0;  // 47 C
  float limit_s = 0;
  float limit_dose_min = 0;
};
struct DoseFigures {
  float longest_s = 0;
  float max_dose_min = 0;
  double past_time = 0;  // cells of bone past the limit
  double past_dose = 0;
};
DoseFigures AddDose(const DoseRule& rule, const Nodes& fraction, const Nodes& before, const Nodes& after,
                    Nodes& above_s, Nodes& dose_min);

}  // namespace kerf::heat
