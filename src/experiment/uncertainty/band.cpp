#include "experiment/uncertainty/band.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "base/core/percentiles.h"
#include "kerf/error.h"

namespace kerf {
namespace {

/// Returns the rank of each value, counted from 1; equal values share their mean rank.
std::vector<double> CalcRanks(const std::vector<double>& values) {
  std::vector<std::size_t> order(values.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return values[a] < values[b]; });
  std::vector<double> ranks(values.size());
  for (std::size_t begin = 0; begin < order.size();) {
    std::size_t end = begin + 1;
    while (end < order.size() && values[order[end]] == values[order[begin]]) ++end;
    for (std::size_t i = begin; i < end; ++i) ranks[order[i]] = 0.5 * static_cast<double>(begin + end + 1);
    begin = end;
  }
  return ranks;
}

template <typename Get>
Spread SpreadOf(const UncertainRun& run, Get get) {
  std::vector<double> values;
  for (const UncertainSample& sample : run.samples) values.push_back(get(sample));
  return CalcSpread(values, get(run.head.nominal));
}

/// Returns the columns of one quantity, which `spread` returns for a row.
Columns<BandRow> SpreadColumns(const std::string& name, const std::string& meaning, Spread BandRow::*spread) {
  struct Part {
    const char* name;
    const char* meaning;
    double Spread::*value;
  };
  Columns<BandRow> columns;
  for (const Part& part :
       {Part{"p5", "5 % of the runs are at or below it", &Spread::p5}, Part{"p50", "median of the runs", &Spread::p50},
        Part{"p95", "95 % of the runs are at or below it", &Spread::p95},
        Part{"nominal", "the run with the scene's own values", &Spread::nominal}}) {
    columns.push_back({name + "_" + part.name + "_N", "{:.6g}", meaning + ": " + part.meaning,
                       [spread, value = part.value](const BandRow& r) { return r.*spread.*value; }});
  }
  return columns;
}

}  // namespace

Spread CalcSpread(const std::vector<double>& values, double nominal) {
  return {CalcPercentile(values, 0.05), CalcPercentile(values, 0.5), CalcPercentile(values, 0.95), nominal};
}

const Columns<BandRow>& BandColumns() {
  using Row = BandRow;
  static const Columns<Row> kColumns = JoinColumns<Row>(
      {{{"time_s", "{:.6f}", "path time at the end of the row's last tick", &Row::time_s},
        {"segment", "{}", "number of the stroke, counted from 1", [](const Row& r) { return r.segment + 1; }},
        {"travel_mm", "{:.6f}",
         "travel of the tool's origin since the first contact of the stroke, in the nominal run; 0 before",
         &Row::travel_mm}},
       SpreadColumns("force", "magnitude of the force on the tool, mean over the row's ticks", &Row::force_N),
       SpreadColumns("thrust", "sum of the magnitudes of the tooth forces, mean over the row's ticks",
                     &Row::thrust_N)});
  return kColumns;
}

std::optional<double> CalcRankCorrelation(const std::vector<double>& a, const std::vector<double>& b) {
  if (a.size() < 3) return std::nullopt;
  const std::vector<double> x = CalcRanks(a);
  const std::vector<double> y = CalcRanks(b);
  const double mean = 0.5 * static_cast<double>(a.size() + 1);
  double xy = 0;
  double xx = 0;
  double yy = 0;
  for (std::size_t i = 0; i < x.size(); ++i) {
    xy += (x[i] - mean) * (y[i] - mean);
    xx += (x[i] - mean) * (x[i] - mean);
    yy += (y[i] - mean) * (y[i] - mean);
  }
  if (xx == 0 || yy == 0) return std::nullopt;
  return xy / std::sqrt(xx * yy);
}

UncertainResult CalcUncertainResult(const UncertainRun& run) {
  if (run.samples.empty()) throw Error(run.head.scene + ": there is no sample");
  using Sample = UncertainSample;
  UncertainResult result;
  const BandRows& rows = run.head.rows;
  for (std::size_t i = 0; i < rows.time_s.size(); ++i) {
    result.rows.push_back({rows.time_s[i], rows.segment[i], rows.travel_mm[i],
                           SpreadOf(run, [i](const Sample& s) { return s.force_N[i]; }),
                           SpreadOf(run, [i](const Sample& s) { return s.thrust_N[i]; })});
  }
  result.peak_N = SpreadOf(run, [](const Sample& s) { return s.peak_N; });
  result.mean_N = SpreadOf(run, [](const Sample& s) { return s.mean_N; });
  result.work_mJ = SpreadOf(run, [](const Sample& s) { return s.work_mJ; });
  const auto known = [](const Sample& s) { return s.cutting_J.has_value(); };
  if (known(run.head.nominal) && std::all_of(run.samples.begin(), run.samples.end(), known)) {
    result.cutting_J = SpreadOf(run, [](const Sample& s) { return *s.cutting_J; });
  }
  std::vector<double> mean_N;
  for (const Sample& s : run.samples) mean_N.push_back(s.mean_N);
  for (std::size_t q = 0; q < run.head.drawing.drawn.size(); ++q) {
    std::vector<double> fractions;  // rise with the value
    for (const Sample& s : run.samples) fractions.push_back(s.fractions[q]);
    result.rank_correlations.push_back(CalcRankCorrelation(fractions, mean_N));
  }
  return result;
}

double CalcChanceCorrelation(std::size_t samples) {
  return samples < 3 ? 1 : std::min(1.0, 1.96 / std::sqrt(static_cast<double>(samples - 1)));
}

}  // namespace kerf
