// The report of a comparison with measurements, in Markdown.
#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cmath>

#include "base/core/append_format.h"
#include "base/files/markdown_text.h"
#include "base/table/table.h"
#include "cut/force/measured.h"
#include "experiment/validation/validation_files.h"

namespace kerf {
namespace {

std::string ShowNumber(double value) {
  return fmt::format("{:.3g}", value);
}

/// Returns "198.4 +- 14.2", "8 to 11" or "20.07".
std::string ShowMeasured(const MeasuredValue& m) {
  if (IsGiven(m.low)) return fmt::format("{:g} to {:g}", m.low, m.high);
  if (IsGiven(m.sd)) return fmt::format("{:g} +- {:g}", m.value, m.sd);
  return fmt::format("{:g}", m.value);
}

/// Returns the conditions that differ between the values of a set, with those of the row.
std::string ShowRowConditions(const MeasuredSet& set, const MeasuredConditions& at) {
  const std::string own = ShowConditions(at);
  return own.empty() ? ShowConditions(set.conditions) : own;
}

/// Returns the headings, those of the laws, and that of the notes.
std::vector<std::string> WithLaws(std::vector<std::string> headings, const Validation& v, const MeasuredSet& set) {
  for (std::size_t law = 0; law < v.laws.size(); ++law) {
    const bool calibrated = IsCalibrated(set, v.laws[law]);
    headings.push_back(fmt::format("`{}`{}", v.names[law], calibrated ? " (calibration)" : ""));
  }
  headings.emplace_back("note");
  return headings;
}

std::string ShowComparison(const ValueComparison& c) {
  if (!c.simulated.why.empty()) return "-";
  const std::string value = ShowNumber(c.simulated.value) + (c.simulated.assumed_ratio ? " *" : "");
  return fmt::format("{}: {}", value, c.agrees && !*c.agrees ? "**" + c.verdict + "**" : c.verdict);
}

std::string ShowTrend(const TrendComparison& c) {
  if (!c.right) return "-";
  const std::string verdict = *c.right ? c.verdict : "**" + c.verdict + "**";
  return verdict + (c.at_from.assumed_ratio ? " *" : "");
}

void AddIntroduction(std::string& text, const Validation& v) {
  text +=
      "# Force laws compared with published measurements\n\n"
      "Written by `kerf validate`. Each set of published measurements that states enough is simulated with each force "
      "law, with the law's default parameters, and compared with what was measured. There is no overall verdict: a law "
      "that agrees with one set says nothing about another tool, bone or bite.\n\n"
      "- A mean with its standard deviation (SD): the table gives the simulated value and its difference in SDs. Up to "
      "2 SDs count as agreement. The SD is that between specimens.\n"
      "- A range: the value is *inside*, *below* or *above*; the factor is to the nearest end.\n"
      "- A trend: the sign of a change, *right* or *wrong*, and the factor of the change.\n"
      "- **Bold**: the law disagrees.\n"
      "- *calibration*: the law's parameters were derived from this set, so an agreement shows nothing. These rows are "
      "never counted as validation.\n"
      "- A star: the law has no cutting force; thrust / 1.6 is assumed.\n"
      "- *obtained*: read in the publication, derived by arithmetic from such numbers, or recalled from memory.\n"
      "- The bone is bovine or human cortical bone; kerf uses the constants of region 24 (19.3 GPa) for all sets.\n\n"
      "`kerf validate --sets FOLDER` adds sets of your own; docs/formats.md of kerf describes their files.\n\n";
  if (v.names.empty() || v.names.back() == v.laws.back().name()) return;
  AppendFormat(
      text,
      "`{}` is the law of a scene with its own values. Its rows count as calibration only if all values are the "
      "defaults; kerf does not know from which measurements other values come.\n\n",
      v.names.back());
}

void AddCounts(std::string& text, const Validation& v) {
  text +=
      "## Counts\n\nValues that were read, with a known scatter (derived values repeat them), and trends. The sets "
      "differ in weight and are not independent of one another, so the counts are not a score.\n\n";
  TextTable table({"law", "values that agree", "trends that are right", "calibration: values", "calibration: trends"});
  for (const LawCounts& c : v.counts) {
    const auto of = [](int part, int whole) { return whole > 0 ? fmt::format("{} of {}", part, whole) : "-"; };
    table.Add({fmt::format("`{}`", v.names[c.law]), of(c.values_agree, c.values), of(c.trends_right, c.trends),
               of(c.calibration_values_agree, c.calibration_values),
               of(c.calibration_trends_right, c.calibration_trends)});
  }
  text += table.FormatMarkdown() + "\n";
}

void AddValues(std::string& text, const Validation& v, std::size_t set_index) {
  const MeasuredSet& set = v.sets[set_index];
  TextTable table(WithLaws({"quantity", "conditions", "measured", "obtained"}, v, set));
  for (std::size_t row = 0; row < set.values.size(); ++row) {
    const MeasuredValue& m = set.values[row];
    std::vector<TableCell> cells{
        std::string(FindQuantity(m.quantity).label) + (m.material == "cortical" ? "" : ", " + m.material + " bone"),
        ShowRowConditions(set, m.at), ShowMeasured(m), m.obtained};
    for (std::size_t law = 0; law < v.laws.size(); ++law) {
      for (const ValueComparison& c : v.values) {
        if (c.set == set_index && c.row == row && c.law == law) cells.emplace_back(ShowComparison(c));
      }
    }
    cells.emplace_back(EscapeMarkdown(m.note));
    table.Add(cells);
  }
  if (!table.empty()) text += table.FormatMarkdown() + "\n";
}

void AddTrends(std::string& text, const Validation& v, std::size_t set_index) {
  const MeasuredSet& set = v.sets[set_index];
  TextTable table(WithLaws({"trend", "measured", "obtained"}, v, set));
  for (std::size_t row = 0; row < set.trends.size(); ++row) {
    const MeasuredTrend& m = set.trends[row];
    std::vector<TableCell> cells;
    for (std::size_t law = 0; law < v.laws.size(); ++law) {
      for (const TrendComparison& c : v.trends) {
        if (c.set != set_index || c.row != row || c.law != law) continue;
        if (law == 0) {
          cells.emplace_back(fmt::format("{}, {} to {}", FindQuantity(m.quantity).label,
                                         ShowCondition(m.against, c.from), ShowCondition(m.against, c.to)));
          cells.emplace_back(m.sign + (IsGiven(m.ratio) ? ", x " + ShowNumber(m.ratio) : ""));
          cells.emplace_back(m.obtained);
        }
        cells.emplace_back(ShowTrend(c));
      }
    }
    cells.emplace_back(EscapeMarkdown(m.note));
    table.Add(cells);
  }
  if (!table.empty()) text += table.FormatMarkdown() + "\n";
}

/// Returns a text as a sentence.
std::string Sentence(std::string text) {
  if (!text.empty()) text[0] = static_cast<char>(std::toupper(static_cast<unsigned char>(text[0])));
  return EscapeMarkdown(text) + ".";
}

/// Lists each reason for which rows of a set were not compared, with the laws.
void AddReasons(std::string& text, const Validation& v, std::size_t set) {
  std::vector<std::string> seen;
  const auto add = [&](std::size_t law, const std::string& quantity, const std::string& why) {
    if (why.empty()) return;
    const bool of_law = why.find("law") != std::string::npos;
    std::string line = fmt::format("{} not compared{}: {}", FindQuantity(quantity).label,
                                   of_law ? fmt::format(" with `{}`", v.names[law]) : "", why);
    if (std::find(seen.begin(), seen.end(), line) == seen.end()) seen.push_back(std::move(line));
  };
  for (const ValueComparison& c : v.values) {
    if (c.set == set) add(c.law, v.value_of(c).quantity, c.simulated.why);
  }
  for (const TrendComparison& c : v.trends) {
    if (c.set == set) add(c.law, v.trend_of(c).quantity, c.at_from.why);
  }
  for (const std::string& line : seen) AppendFormat(text, "- {}\n", Sentence(line));
}

/// Lists what was not compared, the remarks, and the teeth that a set's force carries.
std::string ListNotes(const Validation& v, std::size_t index) {
  const MeasuredSet& set = v.sets[index];
  std::string text;
  AddReasons(text, v, index);
  for (const MeasuredRemark& r : set.remarks) AppendFormat(text, "- {} ({})\n", Sentence(r.text), r.obtained);
  for (const CarriedTeeth& c : v.carried) {
    if (c.set != index) continue;
    AppendFormat(text, "- With `{}`, a force of {:g} N {}.\n", v.names[c.law], c.force_N,
                 c.teeth > 100 ? "is enough to cut with any number of teeth up to 100"
                 : c.teeth < 1
                     ? "cannot cut with even one tooth"
                     : fmt::format("can cut with at most {:g} engaged {}", c.teeth, c.teeth < 2 ? "tooth" : "teeth"));
  }
  return text;
}

void AddSet(std::string& text, const Validation& v, std::size_t index) {
  const MeasuredSet& set = v.sets[index];
  AppendFormat(text, "### {}: {}\n\n", set.name, EscapeMarkdown(set.title));
  AppendFormat(text, "{}{}. Specimen: {}. Set-up: {}.", EscapeMarkdown(set.citation),
               set.doi.empty() ? "" : ", DOI " + EscapeMarkdown(set.doi), EscapeMarkdown(set.specimen),
               EscapeMarkdown(set.setup));
  if (!set.assumptions.empty()) AppendFormat(text, " Assumed by kerf: {}.", EscapeMarkdown(set.assumptions));
  AppendFormat(text, " Licence: {}.\n\n", EscapeMarkdown(set.licence));
  AddValues(text, v, index);
  AddTrends(text, v, index);
  const std::string notes = ListNotes(v, index);
  if (!notes.empty()) text += notes + "\n";
}

bool IsCompared(const MeasuredSet& set) {
  return !set.values.empty() || !set.trends.empty();
}

void AddTeeth(std::string& text, const Validation& v) {
  if (v.teeth.empty()) return;
  text +=
      "## The single tooth\n\n"
      "Values of a single tooth come from a cut in the contact and removal code that every tick uses: a disc of 200 mm "
      "with one tooth moves into the edge of a rib of bone that is 10 mm long, with a feed per turn equal to the bite. "
      "The bite that is reached is the volume removed per turn divided by the length of the rib and the width of the "
      "tooth.\n\n";
  TextTable table(
      {"law", "bite (um)", "bite reached (um)", "thrust in the cut (N)", "law at the nominal bite (N)", "difference"});
  for (const ToothCheck& check : v.teeth) {
    const ToothRun& r = check.run;
    table.Add({fmt::format("`{}`", v.names[check.law]), fmt::format("{:g}", r.bite_um),
               fmt::format("{:.4g}", r.removed_bite_um), fmt::format("{:.4g}", r.thrust_N),
               fmt::format("{:.4g}", r.law_N),
               r.law_N > 0 ? fmt::format("{:+.2f} %", 100 * (r.thrust_N / r.law_N - 1)) : "-"});
  }
  text += table.FormatMarkdown() + "\n";
}

void AddBlades(std::string& text, const Validation& v) {
  if (v.blades.empty()) return;
  text +=
      "## The blades\n\n"
      "Where a set gives the pitch and the stroke of a reciprocating blade, its trends are also sawn in the contact "
      "and removal code "
      "that every tick uses: a reciprocating blade cuts through a rib of bone that is as long as the engaged teeth "
      "need, with 16 ticks in each period. Under a given force, the blade hangs on a coupling that is at its limit of "
      "force, and its teeth cut the same depth all along their way; otherwise it has the feed that makes its mean bite "
      "the nominal one. The bite of a tooth is then zero at the ends of the stroke and about twice its mean in "
      "between, "
      "so the mean thrust is not that of the law at the mean bite. Where a "
      "set gives the pitch, radius and swing of an oscillating blade, its trends of temperature are sawn with it to a "
      "depth of 0.8 mm, in ticks of 1 ms and with the default parameters of the effect heat (dry), five teeth "
      "engaged. Boiling water holds the bone at 100 C for a while, a rise of 63 K.\n\n";
  TextTable table(
      {"set", "law", "trend", "measured", "bite (um)", "thrust of a tooth (N)", "removal (mm3/s)", "rise (K)", "sawn"});
  for (const BladeCheck& b : v.blades) {
    const TrendComparison& c = v.trends[b.trend];
    const MeasuredTrend& m = v.trend_of(c);
    const auto ends = [](double from, double to) { return fmt::format("{:.3g} to {:.3g}", from, to); };
    const std::string verdict = IsGiven(b.ratio) ? fmt::format("{}, x {:.3g}", b.sign, b.ratio) : b.sign;
    table.Add({v.sets[c.set].name, fmt::format("`{}`", v.names[c.law]),
               fmt::format("{}, {} to {}", FindQuantity(m.quantity).label, ShowCondition(m.against, c.from),
                           ShowCondition(m.against, c.to)),
               m.sign + (IsGiven(m.ratio) ? ", x " + ShowNumber(m.ratio) : ""), ends(b.from.bite_um, b.to.bite_um),
               ends(b.from.thrust_N, b.to.thrust_N), ends(b.from.removal_mm3_per_s, b.to.removal_mm3_per_s),
               b.to.rise_K > 0 ? ends(b.from.rise_K, b.to.rise_K) : "-",
               b.right ? "right: " + verdict : "**wrong: " + verdict + "**"});
  }
  text += table.FormatMarkdown() + "\n";
}

void AddMethods(std::string& text) {
  AppendFormat(
      text,
      "## How each tool is simulated\n\n"
      "- **Tooth**: the cut above. The resultant is sqrt(thrust^2 + cutting^2); the energy per volume is the cutting "
      "force divided by bite x width. Hertz's laws ignore the width; they use the disc of the paper (22 mm, 24 "
      "teeth).\n"
      "- **Drill**, from the law alone: two lips with an angle between them (the point angle). With s = sin(half that "
      "angle), a lip is diameter / 2 / s wide and bites feed / (2 rpm) x s. Thrust = 2 x thrust of a lip x s; torque = "
      "2 x cutting force of a lip x diameter / 4; energy per volume = (torque x angular speed + thrust x feed) / (area "
      "x feed). The chisel edge adds 0.45 / 0.55 of the thrust and 0.2 times that fraction of the torque "
      "(docs/tools.md of kerf). The margins and the friction of the chips are left out, so a torque below the measured "
      "one is expected.\n"
      "- **Blade under a given force**, from the law alone: the bite at which the engaged teeth carry the force; "
      "removal rate = bite x width x speed x number of teeth.\n"
      "- **Blade with a given feed**, from the law alone: the bite is proportional to feed / speed. The temperature "
      "rise is taken as proportional to energy per volume x sqrt(feed): the floor of the kerf receives a heat flux of "
      "energy per volume x feed for a time proportional to 1 / feed, and the surface of a half space warms with flux x "
      "sqrt(time). Only its sign is compared.\n"
      "- **Constant** means a change of at most {:g} % where a constant was measured, and of at most {:g} % where a "
      "change was measured.\n",
      100 * kConstantWithin, 100 * kChangeFrom);
}

}  // namespace

std::string FormatValidationReport(const Validation& v) {
  std::string text;
  AddIntroduction(text, v);
  AddCounts(text, v);
  text += "## Figures\n\n";
  for (const ValidationFigure& figure : MakeValidationFigures(v)) {
    AppendFormat(text, "![{}]({}.png)\n\n", figure.caption, figure.name);
  }
  text += "## Sets\n\n";
  for (std::size_t i = 0; i < v.sets.size(); ++i) {
    if (IsCompared(v.sets[i])) AddSet(text, v, i);
  }
  text += "## Sets of which nothing is compared\n\n";
  for (std::size_t i = 0; i < v.sets.size(); ++i) {
    if (!IsCompared(v.sets[i])) AddSet(text, v, i);
  }
  AddTeeth(text, v);
  AddBlades(text, v);
  AddMethods(text);
  return text;
}

}  // namespace kerf
