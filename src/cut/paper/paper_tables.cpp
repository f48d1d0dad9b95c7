#include "cut/paper/paper_tables.h"

#include <algorithm>
#include <cmath>

#include "kerf/paper.h"

namespace kerf {
namespace {

// Tables 1 and 2, and the bands whose middles Table 2 prints.
struct PrintedRegion {
  int region;
  double E_GPa;
  double nu;
  double depth_mm;
  double band_top_mm;
  double band_bottom_mm;
};
constexpr std::array<PrintedRegion, kPaperRegionCount> kRegions{{
    {24, 19.3, 0.28, 3.75, 0, 7.5},
    {21, 20.5, 0.25, 12.5, 7.5, 17.5},
    {13, 19.3, 0.25, 18.75, 17.5, 20},
    {6, 17.3, 0.38, 26.25, 20, 32.5},
}};
constexpr double kPrintedK = 7.55e-5;

// Tables 3 to 6. Forces have five decimals, arcs three or four.
struct PrintedDepth {
  double depth_mm;
  double arc_mm;
  double arc_half_unit;
  int teeth;
  std::array<double, kPaperRegionCount> force_N;
};
constexpr std::array<PrintedDepth, kPaperDepthCount> kDepths{{
    {1.1, 4.9297, 5e-5, 1, {0.05541, 0.05763, 0.05455, 0.05365}},
    {2.2, 6.9863, 5e-5, 2, {0.44325, 0.46107, 0.43637, 0.42924}},
    {3.3, 8.575, 5e-4, 2, {0.44325, 0.46107, 0.43637, 0.42924}},
    {4.4, 9.9226, 5e-5, 3, {1.49595, 1.55610, 1.47273, 1.44867}},
    {5.5, 11.118, 5e-4, 3, {1.49595, 1.55610, 1.47273, 1.44867}},
    {6.6, 12.206, 5e-4, 4, {3.54596, 3.68854, 3.49092, 3.43389}},
}};

PaperRegionRow CalcRegionRow(const PrintedRegion& printed, const DiscSaw& saw) {
  PaperRegionRow row;
  row.region = printed.region;
  row.E_GPa = printed.E_GPa;
  row.nu = printed.nu;
  row.band_top_mm = printed.band_top_mm;
  row.band_bottom_mm = printed.band_bottom_mm;
  row.depth_mm = {printed.depth_mm, 5e-3, 0.5 * (printed.band_top_mm + printed.band_bottom_mm)};
  row.K_m_per_cbrt_N = {kPrintedK, 5e-8, 1e-3 * CalcHertzK(saw, 1000 * printed.E_GPa, printed.nu)};
  row.tooth_force_N = CalcPaperToothForce(saw, kPaperShareOfPitch, 1000 * printed.E_GPa, printed.nu);
  return row;
}

PaperDepthRow CalcDepthRow(const PrintedDepth& printed, const DiscSaw& saw,
                           const std::array<PaperRegionRow, kPaperRegionCount>& regions) {
  const double h = printed.depth_mm;
  PaperDepthRow row;
  row.depth_mm = h;
  row.arc_mm = {printed.arc_mm, printed.arc_half_unit, CalcPaperArc(h, saw.diameter_mm)};
  row.teeth = {static_cast<double>(printed.teeth), 0, CalcPaperTeeth(saw, h, PaperReading::kAsComputed)};
  row.true_arc_mm = CalcTrueArc(h, saw.diameter_mm);
  row.true_teeth = CalcPaperTeeth(saw, h, PaperReading::kCorrected);
  row.true_whole_teeth = FloorTeeth(row.true_teeth);
  for (std::size_t i = 0; i < kPaperRegionCount; ++i) {
    const double E_MPa = 1000 * regions[i].E_GPa;
    const double nu = regions[i].nu;
    row.force_N[i] = {printed.force_N[i], 5e-6,
                      CalcPaperForce(saw, kPaperShareOfPitch, h, E_MPa, nu, PaperReading::kAsComputed)};
    row.corrected_N[i] = CalcPaperForce(saw, kPaperShareOfPitch, h, E_MPa, nu, PaperReading::kCorrected);
    row.corrected_whole_teeth_N[i] = row.true_whole_teeth * regions[i].tooth_force_N;
  }
  return row;
}

PaperDeviceAdvice CalcDeviceAdvice(const PaperTables& tables) {
  const PaperRegionRow& region = tables.regions[0];
  const DiscSaw& saw = tables.saw;
  PaperDeviceAdvice advice;
  advice.region = region.region;
  advice.teeth = CalcPaperTeeth(saw, saw.diameter_mm, PaperReading::kAsComputed);
  advice.from_printed_force_N = kDepths[0].force_N[0] * advice.teeth * advice.teeth * advice.teeth;
  const auto force = [&](PaperReading reading) {
    return CalcPaperForce(saw, kPaperShareOfPitch, saw.diameter_mm, 1000 * region.E_GPa, region.nu, reading);
  };
  advice.computed_N = force(PaperReading::kAsComputed);
  advice.corrected_teeth = CalcPaperTeeth(saw, saw.diameter_mm, PaperReading::kCorrected);
  advice.corrected_N = force(PaperReading::kCorrected);
  return advice;
}

PaperDifferences CalcDifferences(const PaperTables& tables) {
  PaperDifferences largest;
  const auto raise = [](double& value, double difference) { value = std::max(value, std::abs(difference)); };
  for (const PaperDepthRow& row : tables.depths) {
    raise(largest.arc, row.arc_mm.relative_difference());
    largest.teeth_that_differ += row.teeth.computed == row.teeth.printed ? 0 : 1;
    for (const PaperCell& force : row.force_N) {
      raise(largest.force, force.relative_difference());
      raise(largest.force_by_rounding, force.half_unit / force.printed);
      largest.forces_within_rounding += force.within_rounding() ? 1 : 0;
    }
  }
  for (const PaperRegionRow& row : tables.regions) raise(largest.K, row.K_m_per_cbrt_N.relative_difference());
  raise(largest.K_region_24, tables.regions[0].K_m_per_cbrt_N.relative_difference());
  return largest;
}

}  // namespace

bool PaperCell::within_rounding() const {
  // Slightly more than half a unit, for the rounding of the difference itself.
  return std::abs(computed - printed) <= half_unit * (1 + 1e-9);
}

PaperTables CalcPaperTables() {
  PaperTables tables;
  tables.saw = {};
  tables.saw.diameter_mm = 22;
  tables.saw.teeth = 24;
  tables.saw.E_MPa = 205000;
  tables.saw.nu = 0.28;
  tables.contact_radius_mm = kPaperShareOfPitch * tables.saw.pitch_mm();
  for (std::size_t i = 0; i < kPaperRegionCount; ++i) tables.regions[i] = CalcRegionRow(kRegions[i], tables.saw);
  for (std::size_t i = 0; i < kPaperDepthCount; ++i) {
    tables.depths[i] = CalcDepthRow(kDepths[i], tables.saw, tables.regions);
  }
  tables.device = CalcDeviceAdvice(tables);
  tables.largest = CalcDifferences(tables);
  return tables;
}

}  // namespace kerf
