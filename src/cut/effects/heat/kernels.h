// What is done to each of a heat block's 8^3 nodes in a frame: vector code, with the width of the machine.
#pragma once

#include <array>
#include <cstddef>

namespace kerf::heat {

constexpr int kSide = 8;  // nodes along a block's edge
constexpr int kNodes = kSide * kSide * kSide;
constexpr int kRow = kSide + 2;  // of a block with a layer of its neighbours about it
constexpr int kLayer = kRow * kRow;
constexpr float kLeastShare = 0.5F;  // of a cell that is bone; with less it has none

using Nodes = std::array<float, kNodes>;  // z fastest, y next
using PaddedNodes = std::array<float, kRow * kLayer>;

/// Of a node from 0 to 7 along each axis, or -1 or 8 for the neighbours' layer.
constexpr int PaddedAt(int x, int y, int z) {
  return (x + 1) * kLayer + (y + 1) * kRow + z + 1;
}

/// Temperatures after a frame of conduction; `conduction` is alpha frame / spacing^2. Heat goes from cell to cell
/// through the lesser of their shares. `all_bone`: all shares are 1.
void Conduct(const PaddedNodes& theta, const PaddedNodes& share, bool all_bone, float conduction, Nodes& after);

/// Newton's law at bare surfaces, implicitly. The area of a surface within a cell is the gradient of the share.
struct Surface {
  // Of a cell of bone with a whole face bare: what goes off in a frame, of its excess.
  float air = 0;
  float coolant = 0;
  float coolant_K = 0;  // above the body's temperature
  bool wet = false;     // some nodes may lie where coolant runs
  // That is a cylinder: the block's first node from its middle, in mm, its axis, and its size.
  std::array<float, 3> first_mm{};
  std::array<float, 3> axis{};
  float spacing_mm = 0;
  float radius_mm = 0;
  float half_mm = 0;
};
/// What went off, as sums of share times K.
struct SurfaceLoss {
  double air = 0;
  double coolant = 0;
};
SurfaceLoss CoolSurface(const PaddedNodes& share, const Surface& surface, Nodes& theta);

/// What blood leaves of the excess.
struct Perfused {
  double lost = 0;  // sum of share times K
  float hottest_K = 0;
  float coldest_K = 0;
  float was_hottest_K = 0;  // before the frame
};
Perfused Perfuse(const Nodes& share, float keeps, const Nodes& before, Nodes& after);

/// Time above a limit and CEM43 (Sapareto and Dewey 1984), both by the mean of the temperatures before and after.
struct DoseRule {
  float frame_s = 0;
  float from_K = 0;   // below, no dose
  float base_K = 0;   // of 43 C
  float most_K = 0;   // above that, counts as that
  float limit_K = 0;  // of 47 C
  float limit_s = 0;
  float limit_dose_min = 0;
};
struct DoseFigures {
  float longest_s = 0;
  float greatest_min = 0;
  double past_time = 0;  // cells of bone past the limits
  double past_dose = 0;
};
DoseFigures AddDose(const DoseRule& rule, const Nodes& share, const Nodes& before, const Nodes& after, Nodes& above_s,
                    Nodes& dose_min);

}  // namespace kerf::heat
