#include "experiment/compare/conclusion.h"
#include "base/core/word_list.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "base/core/number_text.h"

namespace kerf {
namespace {

/// Two cases are said to agree if mean and RMS differ by less than this fraction (of the reference's mean and peak).
constexpr double kAgree = 0.02;
/// A spring whose force falls below this fraction counts as released.
constexpr double kReleased = 0.01;
/// A force beyond the slice's end is not mentioned if it is below this fraction of the reference's peak.
constexpr double kStillCutting = 0.01;
/// Slab mode can replace the reference if it differs from it by at most this fraction of the reference's peak.
constexpr double kMaxSlabDifference = 0.1;
/// A tooth's force counts as independent of the number of teeth if it changes by less than this factor.
constexpr double kSameToothForce = 1.5;
/// Times and sizes that differ by less than this fraction are reported as equal.
constexpr double kAlike = 0.1;

bool Alike(double value, double other) {
  return std::abs(value - other) <= kAlike * other;
}

/// Formats a ratio of forces: "3.20 times the force of" or "31.0 % of the force of".
std::string ShowForceRatio(double ratio, const char* what = "force") {
  return ratio >= 1 ? fmt::format("{} times the {} of", ShowFigure(ratio), what)
                    : fmt::format("{} % of the {} of", ShowFigure(100 * ratio), what);
}

/// Formats a fraction as "1/1440" or, if it is at least a tenth, as "80.0 %".
std::string ShowFraction(double fraction) {
  return fraction < 0.1 ? fmt::format("1/{}", ShowFigure(1 / fraction))
                        : fmt::format("{} %", ShowFigure(100 * fraction));
}

/// Rounds a force as in compare.csv, so that statements about equality hold there too.
double AsInTable(double force_N) {
  return std::stod(fmt::format("{:.6g}", force_N));
}

/// Formats a fraction of the depths: "45 %". Shows "0 %" and "100 %" only for exactly none and all.
std::string ShowDepths(std::size_t some, std::size_t all) {
  const double percent = Percent(static_cast<double>(some), static_cast<double>(all));
  if (some > 0 && percent < 1) return "less than 1 %";
  return some < all && percent > 99 ? "more than 99 %" : fmt::format("{:.0f} %", percent);
}

/// States whether the case is above or below the reference, and beyond which depth.
std::string DescribeSides(const CaseResult& result, const Comparison& c) {
  const std::vector<double>& force = result.curve.force_N;
  const std::vector<double>& reference = c.reference().curve.force_N;
  std::size_t above = 0;
  std::size_t below = 0;
  std::size_t equal = 0;
  std::size_t equal_since = 0;  // number of equal bins since the last change of sides
  int last_side = 0;
  double since_mm = 0;  // depth from which the case has been on the last side
  for (const std::size_t i : c.slice_bins) {
    if (!std::isfinite(force[i]) || !std::isfinite(reference[i])) continue;
    const double difference = AsInTable(force[i]) - AsInTable(reference[i]);
    if (difference == 0) {
      ++equal, ++equal_since;
      continue;
    }
    const int side = difference > 0 ? 1 : -1;
    (side > 0 ? above : below) += 1;
    if (side != last_side) since_mm = c.grid.Centre(i) - 0.5 * c.grid.step_mm, equal_since = 0;
    last_side = side;
  }
  if (above + below == 0) return "";
  const std::size_t all = above + below + equal;
  const std::string side = last_side > 0 ? "larger" : "smaller";
  if (above == all || below == all) return fmt::format("The force is {} at every depth", side);
  if (above == 0 || below == 0) {
    return fmt::format("The force is {} wherever the two differ, at {} of the {} depths", side, above + below, all);
  }
  std::string text = fmt::format("The force is larger over {} of the depth and smaller over {}", ShowDepths(above, all),
                                 ShowDepths(below, all));
  if (c.profile.end_mm - since_mm > 0.1 * c.profile.end_mm) {
    text += fmt::format("; beyond {} mm it {}", ShowFigure(since_mm),
                        equal_since == 0 ? "stays " + side : fmt::format("is {} wherever the two differ", side));
  }
  return text;
}

/// Describes where the case and the reference differ most, and how many teeth each has engaged there.
std::string DescribePeak(const CaseResult& result, const Comparison& c) {
  const auto bin = static_cast<std::size_t>(result.slice.peak_depth_mm / c.grid.step_mm);
  const auto at = [&](const CaseResult& r) {
    const double teeth = r.curve.teeth[bin];
    return teeth > 0
               ? fmt::format("{} teeth at {} N each", ShowFigure(teeth), ShowFigure(r.curve.thrust_N[bin] / teeth))
               : std::string("no tooth engaged");
  };
  return fmt::format("The difference is largest at {} mm: {} N ({}) against {} N ({})",
                     ShowFigure(result.slice.peak_depth_mm), ShowFigure(result.curve.force_N[bin]), at(result),
                     ShowFigure(c.reference().curve.force_N[bin]), at(c.reference()));
}

/// States whether the force on a tooth is larger if more teeth are engaged: compares the depth at which the most teeth
/// are engaged with the one at which the fewest are (at least one).
std::string DescribeTeeth(const CaseResult& result, const Comparison& c) {
  const std::vector<double>& teeth = result.curve.teeth;
  std::size_t few = c.grid.count;
  std::size_t many = c.grid.count;
  for (const std::size_t i : c.slice_bins) {
    if (!(teeth[i] >= 1)) continue;
    if (few == c.grid.count || teeth[i] < teeth[few]) few = i;
    if (many == c.grid.count || teeth[i] > teeth[many]) many = i;
  }
  if (few == c.grid.count || !(teeth[many] > teeth[few])) return "";
  const double with_few = result.curve.thrust_N[few] / teeth[few];
  const double with_many = result.curve.thrust_N[many] / teeth[many];
  if (!(with_few > 0 && with_many > kSameToothForce * with_few)) return "";
  return fmt::format(
      "Here the force on a tooth increases with the number of engaged teeth: {} N at {} mm with {} teeth, {} N at {} "
      "mm with {}",
      ShowFigure(with_few), ShowFigure(c.grid.Centre(few)), ShowFigure(teeth[few]), ShowFigure(with_many),
      ShowFigure(c.grid.Centre(many)), ShowFigure(teeth[many]));
}

std::string DescribeForce(const CaseResult& result, const Comparison& c) {
  const CaseResult& reference = c.reference();
  const double mean = result.slice.mean_N;
  const double reference_mean = result.slice.reference_mean_N;
  const double ratio = reference_mean > 0 ? mean / reference_mean : 0;
  const double rms_fraction = reference.peak_N > 0 ? result.slice.rms_N / reference.peak_N : 0;
  const std::string figures =
      fmt::format("{} N against {} N, rms difference {} N, which is {} % of the reference's peak of {} N",
                  ShowFigure(mean), ShowFigure(reference_mean), ShowFigure(result.slice.rms_N),
                  ShowFigure(100 * rms_fraction), ShowFigure(reference.peak_N));
  if (std::abs(ratio - 1) <= kAgree && rms_fraction <= kAgree) {
    return fmt::format("**{}** agrees with {}: on average over the slice {}.", result.what.label, reference.what.label,
                       figures);
  }
  std::string text = fmt::format("**{}** requires {} {}, on average over the slice ({}).", result.what.label,
                                 ShowForceRatio(ratio), reference.what.label, figures);
  const std::string sides = DescribeSides(result, c);
  if (!sides.empty()) text += " " + sides + ".";
  text += " " + DescribePeak(result, c) + ".";
  const std::string teeth = DescribeTeeth(result, c);
  return teeth.empty() ? text : text + " " + teeth + ".";
}

/// Returns the RMS over several regions, each of which is weighted by its number of bins.
double CalcRms(const std::vector<Difference>& parts) {
  double squares = 0;
  double bins = 0;
  for (const Difference& d : parts) {
    squares += d.rms_N * d.rms_N * static_cast<double>(d.bins);
    bins += static_cast<double>(d.bins);
  }
  return bins > 0 ? std::sqrt(squares / bins) : 0;
}

/// Describes what a layer's name and E refer to, so that a cancellous layer with cortical walls is not mistaken for a
/// uniform one.
std::string DescribeLayers(const Comparison& c) {
  if (c.depth_by != "bone")
    return "The layers and their E are those of the paper's Table 2, regardless of the bone's regions.";
  std::vector<std::string> cancellous;
  for (const CompareRegion& region : c.regions) {
    if (region.tissue != ToString(Tissue::kCancellous)) continue;
    cancellous.push_back(fmt::format("{} {} GPa", region.name, ShowFigure(region.E_MPa / 1000)));
  }
  std::string text =
      "A layer is named after the region with the largest share of its area, and its E is the mean over the whole area";
  if (!cancellous.empty()) {
    text += fmt::format("; so a cancellous layer with cortical walls is stiffer than its name suggests (here {})",
                        JoinWords(cancellous));
  }
  return text + ".";
}

/// Describes where a case differs most and least from the reference, by region and by tissue.
std::string DescribeRegions(const CaseResult& result, const Comparison& c) {
  std::size_t most = 0;
  std::size_t least = 0;
  std::map<std::string, std::vector<Difference>> tissues;
  for (std::size_t k = 0; k < c.regions.size(); ++k) {
    if (result.regions[k].rms_N > result.regions[most].rms_N) most = k;
    if (result.regions[k].rms_N < result.regions[least].rms_N) least = k;
    tissues[c.regions[k].tissue].push_back(result.regions[k]);
  }
  if (c.regions.size() < 2 || most == least) return "";
  const auto of = [&](std::size_t k) {
    return fmt::format("{} (rms {} N; {} N against {} N)", c.regions[k].name, ShowFigure(result.regions[k].rms_N),
                       ShowFigure(result.regions[k].mean_N), ShowFigure(result.regions[k].reference_mean_N));
  };
  std::string text =
      fmt::format("By region, {} differs most in {} and least in {}", result.what.label, of(most), of(least));
  if (tissues.size() > 1) {
    std::vector<std::string> words;
    for (const auto& [tissue, parts] : tissues) {
      words.push_back(fmt::format("{} N over the layers named {}", ShowFigure(CalcRms(parts)), tissue));
    }
    text += "; rms " + JoinWords(words);
  }
  return text + ".";
}

/// Describes the force beyond the slice's end: in slab mode it comes from the spring of the hand, in voxel mode from
/// the bone next to the disc's rim. Empty if there is none.
std::string DescribeBeyond(const CaseResult& result, const Comparison& c) {
  const double mean_N = result.beyond.mean_N;
  if (!result.what.slab) {
    if (&result != &c.reference() || !(mean_N > kStillCutting * c.reference().peak_N)) return "";
    return fmt::format(
        "There the slice is free, and the disc of {} still has bone next to its round rim: {} N on average.",
        result.what.label, ShowFigure(mean_N));
  }
  if (ShowFigure(mean_N) == "0" || c.slice_bins.empty()) return "";
  const std::vector<double>& force = result.curve.force_N;
  double max_N = std::abs(force[c.slice_bins.back()]);
  for (const std::size_t i : c.beyond_bins) max_N = std::max(max_N, std::abs(force[i]));
  double released_mm = 0;
  for (const std::size_t i : c.beyond_bins) {
    if (std::abs(force[i]) > kReleased * max_N)
      released_mm = c.grid.Centre(i) + 0.5 * c.grid.step_mm - c.profile.end_mm;
  }
  const double last_N = force[c.beyond_bins.back()];
  const std::string then =
      std::abs(last_N) > kReleased * max_N
          ? fmt::format("and still carried {} N at the last depth", ShowFigure(last_N))
          : fmt::format("and relaxed within {} mm (to below {:.0f} %)", ShowFigure(released_mm), 100 * kReleased);
  return fmt::format(
      "The mean of {} N that {} shows there is not a cutting force, since the slice is free: it comes from the hand's "
      "spring of {:g} N/mm, which carried {} N when the slice came free {}.",
      ShowFigure(mean_N), result.what.label, c.slab.coupling_N_per_mm, ShowFigure(max_N), then);
}

std::string DescribeCost(const CaseResult& result, const Comparison& c) {
  const CaseResult& reference = c.reference();
  const double ratio = result.times.p50_us > 0 ? reference.times.p50_us / result.times.p50_us : 0;
  const double memory = result.memory_bytes > 0
                            ? static_cast<double>(reference.memory_bytes) / static_cast<double>(result.memory_bytes)
                            : 0;
  const auto compare = [](double times, const char* less, const char* more) {
    if (Alike(times, 1)) return std::string("about the same");
    return times > 1 ? fmt::format("{} times {}", ShowFigure(times), less)
                     : fmt::format("{} times {}", ShowFigure(1 / times), more);
  };
  return fmt::format(
      "A tick of **{}** takes {} (p50; p99 {}) against {} (p99 {}), {}; it accesses {} of memory against {}, {}.",
      result.what.label, ShowTime(result.times.p50_us), ShowTime(result.times.p99_us), ShowTime(reference.times.p50_us),
      ShowTime(reference.times.p99_us), compare(ratio, "less", "more"),
      ShowMemory(static_cast<double>(result.memory_bytes)), ShowMemory(static_cast<double>(reference.memory_bytes)),
      compare(memory, "less", "more"));
}

/// Names the two cases with the smallest difference.
std::string DescribeNearest(const Comparison& c) {
  if (c.cases.size() < 3) return "";
  std::size_t first = 0;
  std::size_t second = 1;
  for (std::size_t a = 0; a < c.cases.size(); ++a) {
    for (std::size_t b = a + 1; b < c.cases.size(); ++b) {
      if (c.rms_between_N[a][b] < c.rms_between_N[first][second]) first = a, second = b;
    }
  }
  const double peak_N = std::max(c.cases[first].peak_N, c.cases[second].peak_N);
  return fmt::format(
      "Of all cases, {} and {} are closest to each other: rms difference {} N, {} % of the larger peak, {} N.",
      c.cases[first].what.label, c.cases[second].what.label, ShowFigure(c.rms_between_N[first][second]),
      ShowFigure(Percent(c.rms_between_N[first][second], peak_N)), ShowFigure(peak_N));
}

/// If a slab case differs from the reference, states how much of this is due to the tooth law and how much to the slab.
/// `equal` is the voxel case with the slab's law.
std::string DescribeCause(const CaseResult& slab, const CaseResult& equal, const Comparison& c) {
  const CaseResult& reference = c.reference();
  const double by_law = equal.slice.mean_N / reference.slice.mean_N;
  const double by_slab = slab.slice.mean_N / equal.slice.mean_N;
  if (!(by_law > 0 && by_slab > 0 && std::isfinite(by_law) && std::isfinite(by_slab))) return "";
  const bool has_more = c.slab.friction_coefficient * c.slab.normal_force_N > 0 || c.slab.stiffness_N_per_mm > 0 ||
                        c.slab.damping_Ns_per_mm > 0;
  const std::string slab_fraction =
      fmt::format("with the same law, {} gives {} {} ({} N against {} N{})", slab.what.label,
                  ShowForceRatio(by_slab, "mean force"), equal.what.label, ShowFigure(slab.slice.mean_N),
                  ShowFigure(equal.slice.mean_N), has_more ? "; friction, springs and dampers included" : "");
  if (&equal == &reference) return fmt::format(" The cause is the slab: {}.", slab_fraction);
  const std::string law_fraction = fmt::format("with the slab's law, voxel mode gives {} {}",
                                               ShowForceRatio(by_law, "mean force"), reference.what.label);
  return std::abs(std::log(by_law)) >= std::abs(std::log(by_slab))
             ? fmt::format(" The cause is the tooth law more than the slab: {}; {}.", law_fraction, slab_fraction)
             : fmt::format(" The cause is the slab more than the tooth law: {}; {}.", slab_fraction, law_fraction);
}

/// States whether a slab can replace the reference. Considers the slab case that is nearest to the voxel case with the
/// same law.
std::string DescribeSubstitute(const Comparison& c) {
  const CaseResult& reference = c.reference();
  const CaseResult* equal = FindEqualLaw(c);
  const auto& rms_N = c.rms_between_N[equal != nullptr ? static_cast<std::size_t>(equal - c.cases.data()) : 0];
  const CaseResult* nearest = nullptr;
  double min_N = 0;
  for (std::size_t k = 0; k < c.cases.size(); ++k) {
    if (!c.cases[k].what.slab || (nearest != nullptr && rms_N[k] >= min_N)) continue;
    nearest = &c.cases[k];
    min_N = rms_N[k];
  }
  const bool measured = reference.peak_N > 0 && reference.slice.mean_N > 0;
  if (nearest == nullptr || !measured || !(nearest->times.p50_us > 0)) return "";
  const double fraction = nearest->slice.rms_N / reference.peak_N;
  const double faster = reference.times.p50_us / nearest->times.p50_us;
  const std::string time = faster >= 1 ? fmt::format("in {} of the time per tick", ShowFraction(1 / faster))
                                       : fmt::format("in {} times the time per tick", ShowFigure(1 / faster));
  const std::string force = fmt::format(
      "{} gives {} {} ({} N against {} N; rms difference {} N), {}.", nearest->what.label,
      ShowForceRatio(nearest->slice.mean_N / reference.slice.mean_N, "mean force"), reference.what.label,
      ShowFigure(nearest->slice.mean_N), ShowFigure(reference.slice.mean_N), ShowFigure(nearest->slice.rms_N), time);
  if (fraction <= kMaxSlabDifference) {
    return fmt::format("**In short:** slab mode can replace {} on this cut: {}", reference.what.label, force);
  }
  return fmt::format("**In short:** slab mode cannot replace {} on this cut: {}{}", reference.what.label, force,
                     equal != nullptr ? DescribeCause(*nearest, *equal, c) : "");
}

/// States which cases meet the tick rate, and how much repetitions differ.
std::string DescribeDeadline(const Comparison& c) {
  const double period_us = 1e6 / c.rate_hz;
  std::vector<std::string> in_time;
  std::vector<std::string> at_times;
  std::vector<std::string> late;
  double spread = 0;
  for (const CaseResult& result : c.cases) {
    const auto kept =
        std::count_if(result.p99_us.begin(), result.p99_us.end(), [&](double p99_us) { return p99_us <= period_us; });
    const auto runs = static_cast<std::ptrdiff_t>(result.p99_us.size());
    (kept == runs ? in_time : kept > 0 ? at_times : late).push_back(result.what.label);
    const auto [low, high] = std::minmax_element(result.p50_us.begin(), result.p50_us.end());
    if (low != result.p50_us.end() && *low > 0) spread = std::max(spread, *high / *low - 1);
  }
  std::vector<std::string> words;
  if (!in_time.empty()) words.push_back(JoinWords(in_time) + " in every repetition");
  if (!at_times.empty()) words.push_back(JoinWords(at_times) + " in some repetitions only");
  if (!late.empty()) words.push_back(JoinWords(late) + " in none");
  std::string text = fmt::format("At {:g} ticks per second a tick may take {}; cases whose p99 met this limit: {}",
                                 c.rate_hz, ShowTime(period_us), fmt::format("{}", fmt::join(words, "; ")));
  if (c.repetitions > 1) {
    text += fmt::format(". Between the {} repetitions, p50 differed by up to {} %", c.repetitions,
                        ShowFigure(100 * spread));
  }
  return text + ".";
}

}  // namespace

double Percent(double part, double whole) {
  return whole > 0 ? 100 * part / whole : 0;
}

std::string ShowFigure(double value) {
  return std::abs(value) < 5e-7 ? "0" : ShowThree(value);
}

std::string ShowTime(double us) {
  return us >= 10'000 ? fmt::format("{} ms", ShowFigure(us / 1000)) : fmt::format("{} us", ShowFigure(us));
}

std::string ShowMemory(double bytes) {
  if (bytes >= 1e6) return fmt::format("{} MB", ShowFigure(bytes / 1e6));
  return bytes >= 1e3 ? fmt::format("{} kB", ShowFigure(bytes / 1e3)) : fmt::format("{:.0f} bytes", bytes);
}

Conclusion WriteConclusion(const Comparison& c) {
  Conclusion words;
  const auto add = [](std::vector<std::string>& to, const std::string& text) {
    if (!text.empty()) to.push_back(text);
  };
  const CaseResult& reference = c.reference();
  add(words.force, DescribeSubstitute(c));
  add(words.force,
      fmt::format("The reference, **{}**, requires {} N on average over the slice and {} N at its peak, at a "
                  "depth of {} mm; the cut takes {} mJ.",
                  reference.what.label, ShowFigure(reference.slice.mean_N), ShowFigure(reference.peak_N),
                  ShowFigure(reference.peak_depth_mm), ShowFigure(reference.work_mJ)));
  for (std::size_t k = 1; k < c.cases.size(); ++k) add(words.force, DescribeForce(c.cases[k], c));
  add(words.force, DescribeNearest(c));
  if (c.cases.size() > 1) {
    std::vector<std::string> work;
    for (const CaseResult& result : c.cases) {
      std::string fraction;
      if (&result != &reference)
        fraction = fmt::format(", {} %", ShowFigure(Percent(result.work_mJ, reference.work_mJ)));
      work.push_back(fmt::format("{} mJ ({}{})", ShowFigure(result.work_mJ), result.what.label, fraction));
    }
    add(words.force, "Work of the hand over the whole path: " + JoinWords(work) + ".");
  }
  add(words.regions, DescribeLayers(c));
  for (std::size_t k = 1; k < c.cases.size(); ++k) add(words.regions, DescribeRegions(c.cases[k], c));
  for (const CaseResult& result : c.cases) add(words.beyond, DescribeBeyond(result, c));
  std::vector<std::string> alike;
  for (std::size_t k = 1; k < c.cases.size(); ++k) {
    const bool same = Alike(c.cases[k].times.p50_us, reference.times.p50_us) &&
                      Alike(static_cast<double>(c.cases[k].memory_bytes), static_cast<double>(reference.memory_bytes));
    if (same) {
      alike.push_back(c.cases[k].what.label);
    } else {
      add(words.cost, DescribeCost(c.cases[k], c));
    }
  }
  if (!alike.empty()) {
    add(words.cost, fmt::format("{} cost{} the same as {}, to within {:.0f} %, in time per tick and in memory.",
                                JoinWords(alike), alike.size() == 1 ? "s" : "", reference.what.label, 100 * kAlike));
  }
  add(words.cost, DescribeDeadline(c));
  return words;
}

}  // namespace kerf
