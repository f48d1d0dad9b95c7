#include "experiment/study/plan.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>

#include "experiment/study/settings.h"
#include "kerf/error.h"

namespace kerf {
namespace {

// Estimated effort for a reference, in units of the effort for the errors of a case. It serves to balance shards.
constexpr double kReferenceWeight = 10;

bool Contains(const std::vector<std::string>& names, const std::string& name) {
  return std::find(names.begin(), names.end(), name) != names.end();
}

/// Estimates the effort: the number of ticks scales with the rate, and the effort of the removal and of the surface
/// with the voxels.
double GuessTickWeight(const StudySettings& settings) {
  const double finer = 0.1 / settings.voxel_mm;
  return 0.5 + 0.5 * finer * finer + 0.02 * settings.rim_samples_per_pitch + 0.3 * (settings.substeps - 1);
}

std::string FileNamePart(std::string text) {
  for (char& c : text) {
    const bool plain =
        (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_' || c == '-' || c == '.';
    if (!plain) c = '-';
  }
  return text;
}

PlannedCase MakeCase(const StudySpec& spec, const std::string& path, const std::string& content, Holding holding,
                     const std::string& knob, const std::string& value, const VariantFunction& variant_of) {
  PlannedCase c;
  c.path = path;
  c.holding = holding;
  c.knob = knob;
  c.value = value;
  c.settings = spec.base;
  if (knob != "default") SetValue(c.settings, knob, value);
  c.id = fmt::format("{}.{}.{}", path, ToString(holding), knob);
  if (knob != "default") c.id += FileNamePart("-" + value);
  const std::string variant = variant_of(c.settings);
  c.reference = fmt::format("{}.{}", path, ToString(holding));
  if (!variant.empty()) c.reference += FileNamePart("." + variant);
  c.costs = knob == "default" || spec.cost_paths.empty() || Contains(spec.cost_paths, path);
  c.ticks = knob == "default" ? spec.ticks_of_defaults : spec.ticks_per_case;
  const double tick = GuessTickWeight(c.settings);
  c.errors_weight = 1 + tick * c.settings.rate_hz / 1000;
  c.costs_weight = 0.5 + 0.3 * tick * c.ticks / 20'000;
  const std::string what = fmt::format("{}{} {} {}", path, content, ToString(holding), ShowSettings(c.settings));
  c.errors_input = fmt::format("{} tolerance={}", what, spec.reference_tolerance);
  c.costs_input = fmt::format("{} ticks={}", what, c.ticks);
  return c;
}

}  // namespace

std::string_view ToString(CaseWork work) {
  return work == CaseWork::kErrors ? "errors" : "costs";
}

StudyPlan MakePlan(const StudySpec& spec, const VariantFunction& variant_of) {
  std::vector<std::pair<std::string, std::string>> paths;  // name, description of its content
  for (const std::string& name : spec.paths) paths.emplace_back(name, "");
  for (const StudyScene& scene : spec.scenes) paths.emplace_back(scene.name, "#" + ShowHash(scene.content_hash));
  StudyPlan plan;
  for (const auto& [path, content] : paths) {
    for (const Holding holding : spec.holdings) {
      plan.cases.push_back(MakeCase(spec, path, content, holding, "default", "", variant_of));
      for (const KnobSweep& sweep : spec.knobs) {
        if (!sweep.paths.empty() && !Contains(sweep.paths, path)) continue;
        if (!sweep.holdings.empty() &&
            std::find(sweep.holdings.begin(), sweep.holdings.end(), holding) == sweep.holdings.end()) {
          continue;
        }
        if (holding == Holding::kPath && !FindKnob(sweep.knob).for_path) continue;
        for (const std::string& value : sweep.values) {
          if (value == ValueOf(spec.base, sweep.knob)) continue;  // this is the case at the base settings
          plan.cases.push_back(MakeCase(spec, path, content, holding, sweep.knob, value, variant_of));
        }
      }
    }
  }
  std::string all;
  for (const PlannedCase& c : plan.cases) {
    all += fmt::format("{}\n{}\n{}\n", c.id, c.errors_input, c.costs ? c.costs_input : "");
  }
  plan.hash = HashText(all);
  return plan;
}

std::vector<std::vector<std::size_t>> SplitPlan(const StudyPlan& plan, int count) {
  std::map<std::string, std::vector<std::size_t>> groups;
  for (std::size_t i = 0; i < plan.cases.size(); ++i) groups[plan.cases[i].reference].push_back(i);
  double whole = 0;
  for (const auto& [reference, members] : groups) {
    whole += kReferenceWeight;
    for (const std::size_t i : members) {
      whole += plan.cases[i].errors_weight + (plan.cases[i].costs ? plan.cases[i].costs_weight : 0);
    }
  }
  std::vector<std::vector<std::size_t>> shards(static_cast<std::size_t>(count));
  double before = 0;
  for (const auto& [reference, members] : groups) {
    // Every shard with some of these cases computes the reference, so its weight is distributed evenly.
    const double fraction = kReferenceWeight / static_cast<double>(members.size());
    for (const std::size_t i : members) {
      const PlannedCase& c = plan.cases[i];
      const double weight = fraction + c.errors_weight + (c.costs ? c.costs_weight : 0);
      const auto shard = static_cast<std::size_t>((before + 0.5 * weight) / whole * count);
      shards[std::min(shard, shards.size() - 1)].push_back(i);
      before += weight;
    }
  }
  return shards;
}

}  // namespace kerf
