// Percentiles over the samples of an uncertain run, and the influence of each drawn quantity.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "base/table/table.h"
#include "experiment/uncertainty/uncertain.h"

namespace kerf {

/// Nearest-rank percentiles over the samples (core/percentiles.h), and the value of the nominal run.
struct Spread {
  double p5 = 0;
  double p50 = 0;
  double p95 = 0;
  double nominal = 0;
};
/// `values`: one for each sample, at least one.
Spread CalcSpread(const std::vector<double>& values, double nominal);

struct BandRow {
  double time_s = 0;
  std::size_t segment = 0;  // zero-based
  double travel_mm = 0;
  Spread force_N;
  Spread thrust_N;
};
/// Columns of band.csv.
const Columns<BandRow>& BandColumns();

/// Returns Spearman's rank correlation of two lists of the same length: the correlation of the ranks, where equal
/// values share their mean rank. Returns nullopt if there are fewer than three values or all values of a list are
/// equal.
std::optional<double> CalcRankCorrelation(const std::vector<double>& a, const std::vector<double>& b);

struct UncertainResult {
  std::vector<BandRow> rows;
  Spread peak_N;
  Spread mean_N;
  Spread work_mJ;
  std::optional<Spread> cutting_J;                       // none if the cutting work of the runs is unknown
  std::vector<std::optional<double>> rank_correlations;  // with the mean force, in the order of Drawing::drawn
};
/// Throws kerf::Error if there is no sample.
UncertainResult CalcUncertainResult(const UncertainRun& run);

/// Magnitude below which a rank correlation of independent quantities lies in 95 % of cases, for a number of samples.
double CalcChanceCorrelation(std::size_t samples);

}  // namespace kerf
