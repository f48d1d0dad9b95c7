// The five disagreements between the paper's text and its tables, each with computed evidence.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "cut/paper/paper_tables.h"
#include "kerf/paper.h"

namespace kerf {
namespace {

// Smallest and largest number of teeth on the disc that give the printed counts with the printed arcs.
struct ToothCounts {
  int lower, upper;
};
ToothCounts CalcPossibleTeeth(const PaperTables& tables) {
  double shortest = 0;
  double longest = std::numeric_limits<double>::infinity();
  for (const PaperDepthRow& row : tables.depths) {
    // teeth <= arc / pitch < teeth + 1
    shortest = std::max(shortest, row.arc_mm.printed / (row.teeth.printed + 1));
    longest = std::min(longest, row.arc_mm.printed / row.teeth.printed);
  }
  const double rim_mm = tables.saw.pitch_mm() * tables.saw.teeth;
  return {static_cast<int>(std::ceil(rim_mm / longest)), static_cast<int>(std::floor(rim_mm / shortest))};
}

PaperDiscrepancy MakeDiameter(const PaperTables& tables) {
  DiscSaw text = tables.saw;
  text.diameter_mm = 30;
  const PaperDepthRow& row = tables.depths[0];
  const PaperRegionRow& region = tables.regions[0];
  return {"disc_diameter", "22 mm, not 30", "The saw is a steel disc of 30 mm diameter.",
          "A disc of 22 mm, in the arcs and in K.",
          fmt::format("At a depth of {} mm, a 30 mm disc gives an arc of {:.4f} mm and a 22 mm disc {:.4f}; the paper "
                      "prints {:.4f}. K is {:.2f}e-5 with 30 mm and {:.2f}e-5 with 22; the paper prints {:.2f}e-5.",
                      row.depth_mm, CalcPaperArc(row.depth_mm, 30), row.arc_mm.computed, row.arc_mm.printed,
                      1e2 * CalcHertzK(text, 1000 * region.E_GPa, region.nu), 1e5 * region.K_m_per_cbrt_N.computed,
                      1e5 * region.K_m_per_cbrt_N.printed)};
}

PaperDiscrepancy MakeToothCount(const PaperTables& tables) {
  const ToothCounts counts = CalcPossibleTeeth(tables);
  DiscSaw fewer = tables.saw;
  fewer.teeth = counts.lower;
  const PaperRegionRow& region = tables.regions[0];
  const double other = CalcPaperToothForce(fewer, kPaperShareOfPitch, 1000 * region.E_GPa, region.nu);
  return {"tooth_count", "24 teeth",
          "A tooth's contact is 1 % of the tooth pitch; the number of teeth of the disc is not stated.",
          fmt::format("24 teeth: a pitch of {:.4f} mm and a contact radius of {:.5f} mm.", tables.saw.pitch_mm(),
                      tables.contact_radius_mm),
          fmt::format("The printed arcs and tooth counts allow only {} or {} teeth on a disc of 22 mm; "
                      "with {} every force would be {:.0f} % larger than printed.",
                      counts.lower, counts.upper, counts.lower, 100 * (other / region.tooth_force_N - 1))};
}

PaperDiscrepancy MakePoisson(const PaperTables& tables) {
  const PaperRegionRow& region = tables.regions[0];
  const double steel = (1 - tables.saw.nu) / (1e-3 * tables.saw.E_MPa);
  const double K_mm = std::cbrt(3 * tables.saw.diameter_mm / 8 * 1e-3 * (steel + (1 - region.nu) / region.E_GPa));
  const PaperCell& force = tables.depths[0].force_N[0];
  const double force_N = std::pow(tables.contact_radius_mm / K_mm, 3);
  return {
      "poisson_ratio", "(1 - nu^2)/E, not (1 - nu)/E", "Eq. (3) has (1 - nu)/E for steel and for bone.",
      "Hertz's own (1 - nu^2)/E, with 205 GPa and 0.28 for steel. The tables print the K of region 24 for every "
      "region; the forces follow from each region's own K.",
      fmt::format("As printed, eq. (3) gives K = {:.2f}e-5 in region 24 (printed: {:.2f}e-5) and {:.5f} N on one tooth "
                  "(printed: {:.5f}). One K for all regions would give them all the same force.",
                  1e2 * K_mm, 1e5 * region.K_m_per_cbrt_N.printed, force_N, force.printed)};
}

PaperDiscrepancy MakeArc(const PaperTables& tables) {
  const PaperDepthRow& first = tables.depths.front();
  const PaperDepthRow& last = tables.depths.back();
  const auto shortfall = [](const PaperDepthRow& row) { return 100 * (row.true_arc_mm / row.arc_mm.printed - 1); };
  return {"arc", "the diameter in place of the radius",
          "Teeth engage along the arc of the disc's edge that is in the bone.",
          "d acos(1 - h/(2 d)), whole teeth only: floor(arc / pitch). The arc from the lowest point to the surface is "
          "(d/2) acos(1 - 2 h/d).",
          fmt::format(
              "The formula gives the six printed arcs to their last digit. The true arcs are {:.1f} to {:.1f} % "
              "longer: {:.4f} mm at {} mm, {:.4f} at {}.",
              shortfall(first), shortfall(last), first.true_arc_mm, first.depth_mm, last.true_arc_mm, last.depth_mm)};
}

PaperDiscrepancy MakeCubedSum(const PaperTables& tables) {
  const auto printed = [&](std::size_t row) { return tables.depths[row].force_N[0].printed; };
  return {"cubed_sum", "radii added before cubing, so n^3 for n teeth",
          "a = K F^(1/3) holds for one contact, and each tooth is one contact, so n teeth give n times its force.",
          "The contact radii of the engaged teeth are added first: F = (n a / K)^3 = n^3 F_1.",
          fmt::format("The printed forces of 2, 3 and 4 teeth in region 24 are {:.2f}, {:.2f} and {:.2f} times that of "
                      "one. Summed, 4 teeth give {:.3f} N; the paper prints {:.3f}.",
                      printed(1) / printed(0), printed(3) / printed(0), printed(5) / printed(0),
                      4 * tables.regions[0].tooth_force_N, printed(5))};
}

}  // namespace

std::vector<PaperDiscrepancy> MakePaperDiscrepancies(const PaperTables& tables) {
  return {MakeDiameter(tables), MakeToothCount(tables), MakePoisson(tables), MakeArc(tables), MakeCubedSum(tables)};
}

std::string DescribeRemainder(const PaperTables& tables) {
  double lowest = std::numeric_limits<double>::infinity();
  double highest = -lowest;
  for (const PaperDepthRow& row : tables.depths) {
    for (const PaperCell& force : row.force_N) {
      if (force.within_rounding()) continue;
      lowest = std::min(lowest, force.relative_difference());
      highest = std::max(highest, force.relative_difference());
    }
  }
  const int beyond = static_cast<int>(kPaperDepthCount * kPaperRegionCount) - tables.largest.forces_within_rounding;
  return fmt::format(
      "The largest relative difference of a force is {:.1e}; the five printed decimals explain up to {:.1e} of it. {} "
      "of the 24 forces differ by more than their own rounding, by {:+.1e} to {:+.1e}: the computed ones are larger "
      "throughout, as if a constant had been rounded in its fifth digit.",
      tables.largest.force, tables.largest.force_by_rounding, beyond, lowest, highest);
}

}  // namespace kerf
