// The paper's Tables 1 to 6 as printed and as recomputed (docs/paper.md).
#pragma once

#include <array>
#include <cstddef>
#include <string>
#include <vector>

#include "kerf/tool.h"

namespace kerf {

inline constexpr std::size_t kPaperRegionCount = 4;
inline constexpr std::size_t kPaperDepthCount = 6;

/// Contact radius of a tooth / tooth pitch: the paper's 1 %.
inline constexpr double kPaperShareOfPitch = 0.01;

/// Number that the paper prints, and the same number computed.
struct PaperCell {
  double printed = 0;
  double half_unit = 0;  // half a unit of the last printed digit: the error that rounding can explain
  double computed = 0;

  double relative_difference() const { return computed / printed - 1; }
  bool within_rounding() const;
};

/// Row of Tables 1 and 2: a region along the cut, and the results for one tooth in it.
struct PaperRegionRow {
  int region = 0;
  double E_GPa = 0;
  double nu = 0;
  double band_top_mm = 0;  // band of depths whose middle Table 2 prints: an interpretation, not in the paper
  double band_bottom_mm = 0;
  PaperCell depth_mm;        // Table 2; computed: the middle of the band
  PaperCell K_m_per_cbrt_N;  // K in a = K F^(1/3), m N^(-1/3); printed: that of region 24, in every table
  double tooth_force_N = 0;  // F_1 = (1 % of the pitch / K)^3
};

/// Row of Tables 3 to 6, which differ by region only in the force.
struct PaperDepthRow {
  double depth_mm = 0;  // depth of the disc
  PaperCell arc_mm;
  PaperCell teeth;
  std::array<PaperCell, kPaperRegionCount> force_N;  // one for each region, in the order of `regions`
  // The corrected reading.
  double true_arc_mm = 0;
  double true_teeth = 0;  // arc / pitch, a real number
  double true_whole_teeth = 0;
  std::array<double, kPaperRegionCount> corrected_N{};              // true_teeth F_1
  std::array<double, kPaperRegionCount> corrected_whole_teeth_N{};  // true_whole_teeth F_1, for comparison
};

/// The paper's advice to use a device of at least 28 N: all 8 teeth of the buried disc in region 24, by the paper's
/// arc.
struct PaperDeviceAdvice {
  int region = 24;
  double teeth = 0;                 // engaged teeth of the buried disc
  double printed_at_least_N = 28;   // in the text
  double from_printed_force_N = 0;  // printed force of one tooth times teeth^3
  double computed_N = 0;
  double corrected_teeth = 0;  // engaged teeth of the buried disc by the true arc
  double corrected_N = 0;
};

/// Largest absolute relative differences.
struct PaperDifferences {
  double force = 0;
  double force_by_rounding = 0;  // largest difference that the printed digits of a force can explain
  double arc = 0;
  double K_region_24 = 0;  // of region 24, whose K the paper prints
  double K = 0;            // of all four regions against that one printed value
  int teeth_that_differ = 0;
  int forces_within_rounding = 0;  // of 24 forces
};

struct PaperTables {
  DiscSaw saw;
  double contact_radius_mm = 0;
  std::array<PaperRegionRow, kPaperRegionCount> regions;
  std::array<PaperDepthRow, kPaperDepthCount> depths;
  PaperDeviceAdvice device;
  PaperDifferences largest;
};

/// Computes all tables through kerf/paper.h, with the disc for which the paper's tables were computed.
PaperTables CalcPaperTables();

/// Disagreement between the paper's text and its tables, in words; the numbers in the text are computed.
struct PaperDiscrepancy {
  std::string id;      // "disc_diameter", "tooth_count", "poisson_ratio", "arc", "cubed_sum"
  std::string title;   // a few words
  std::string text;    // statement of the text
  std::string tables;  // rule that the tables follow
  std::string how;     // evidence
};
std::vector<PaperDiscrepancy> MakePaperDiscrepancies(const PaperTables& tables);

/// Returns a description of the differences beyond rounding that remain among the 24 forces.
std::string DescribeRemainder(const PaperTables& tables);

}  // namespace kerf
