// The paper's Tables 1 to 6 as printed, and the same computed anew (docs/paper.md).
#pragma once

#include <array>
#include <cstddef>
#include <string>
#include <vector>

#include "kerf/tool.h"

namespace kerf {

inline constexpr std::size_t kPaperRegionCount = 4;
inline constexpr std::size_t kPaperDepthCount = 6;

/// The radius of a tooth's contact as a share of the tooth pitch: the paper's 1 %.
inline constexpr double kPaperShareOfPitch = 0.01;

/// A number that the paper prints, and the same computed.
struct PaperCell {
  double printed = 0;
  double half_unit = 0;  // of the last digit printed: what rounding can explain
  double computed = 0;

  double relative_difference() const { return computed / printed - 1; }
  bool within_rounding() const;
};

/// A row of Tables 1 and 2: a region along the cut, and what follows for one tooth in it.
struct PaperRegionRow {
  int region = 0;
  double E_GPa = 0;
  double nu = 0;
  double band_top_mm = 0;  // of the band of depths whose middle Table 2 prints: a reading, the paper does not say
  double band_bottom_mm = 0;
  PaperCell depth_mm;        // Table 2; computed: the middle of the band
  PaperCell K_m_per_cbrt_N;  // K in a = K F^(1/3), m N^(-1/3); printed: region 24's, in every table
  double tooth_force_N = 0;  // F_1 = (1 % of the pitch / K)^3
};

/// A row of Tables 3 to 6, which differ by region in the force alone.
struct PaperDepthRow {
  double depth_mm = 0;  // of the disc
  PaperCell arc_mm;
  PaperCell teeth;
  std::array<PaperCell, kPaperRegionCount> force_N;  // in the order of the regions
  // The corrected reading.
  double true_arc_mm = 0;
  double true_teeth = 0;  // arc / pitch, a real number
  double true_whole_teeth = 0;
  std::array<double, kPaperRegionCount> corrected_N{};              // true_teeth F_1
  std::array<double, kPaperRegionCount> corrected_whole_teeth_N{};  // true_whole_teeth F_1, for comparison
};

/// The paper's advice of a device of at least 28 N: all 8 teeth of the buried disc in region 24, by the paper's arc.
struct PaperDeviceAdvice {
  int region = 24;
  double teeth = 0;                 // engaged by the buried disc
  double printed_at_least_N = 28;   // the text
  double from_printed_force_N = 0;  // the printed force of one tooth times teeth^3
  double computed_N = 0;
  double corrected_teeth = 0;  // the buried disc by the true arc
  double corrected_N = 0;
};

/// The largest of the absolute relative differences.
struct PaperDifferences {
  double force = 0;
  double force_by_rounding = 0;  // the largest that the printed digits of a force can explain
  double arc = 0;
  double K_region_24 = 0;  // whose K the paper prints
  double K = 0;            // of all four against that one print
  int teeth_that_differ = 0;
  int forces_within_rounding = 0;  // of 24
};

struct PaperTables {
  DiscSaw saw;
  double contact_radius_mm = 0;
  std::array<PaperRegionRow, kPaperRegionCount> regions;
  std::array<PaperDepthRow, kPaperDepthCount> depths;
  PaperDeviceAdvice device;
  PaperDifferences largest;
};

/// All of it through kerf/paper.h, with the disc that the tables were computed with.
PaperTables CalcPaperTables();

/// Where the paper's text and its tables disagree, in plain words; the figures in them are computed.
struct PaperDiscrepancy {
  std::string id;      // "disc_diameter", "tooth_count", "poisson_ratio", "arc", "cubed_sum"
  std::string title;   // in a few words
  std::string text;    // what the text says
  std::string tables;  // what the tables follow
  std::string how;     // how we know
};
std::vector<PaperDiscrepancy> MakePaperDiscrepancies(const PaperTables& tables);

/// What is left of the 24 differences beyond rounding, in plain words.
std::string DescribeRemainder(const PaperTables& tables);

}  // namespace kerf
