// Collects a folder's records into the results for the report, and estimates the time of the remaining work.
#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <set>

#include "experiment/study/engine.h"
#include "experiment/study/settings.h"
#include "kerf/error.h"

namespace kerf {
namespace {

// Times per unit of PlannedCase's weights and per reference, s, for a first estimate; measured on two cores of an AMD
// EPYC.
constexpr double kErrors_s = 0.5;
constexpr double kCosts_s = 1.0;
constexpr double kReference_s = 20;

double NumberOf(const std::string& value) {
  double number = 0;
  const auto [end, error] = std::from_chars(value.data(), value.data() + value.size(), number);
  return error == std::errc() && end == value.data() + value.size() ? number : 0;
}

template <typename Read>
auto ReadOrWarn(Read&& read, const std::function<void(const std::string&)>& warn) -> decltype(read()) {
  try {
    return read();
  } catch (const Error& e) {
    if (warn) warn(e.what());
    return std::nullopt;
  }
}

CaseRecord RecordOf(const PlannedCase& c) {
  CaseRecord record;
  record.id = c.id;
  record.holding = c.holding;
  record.path = c.path;
  record.knob = c.knob;
  record.value = c.value;
  record.number = NumberOf(c.value);
  return record;
}

/// Adds the results of one kind of work to the case's record.
void AddWork(CaseRecord& record, const WorkRecord& work) {
  if (work.errors) record.errors = work.errors;
  if (work.costs) record.costs = work.costs;
  if (record.force_hash == 0) record.force_hash = work.force_hash;
  if (record.bone_hash == 0) record.bone_hash = work.bone_hash;
  if (work.state == CaseState::kDone) return;
  if (!work.why.empty() && record.why.find(work.why) == std::string::npos) {
    record.why += fmt::format("{}{}", record.why.empty() ? "" : "; ", work.why);
  }
  if (record.state != CaseState::kFailed) record.state = work.state;
}

}  // namespace

StudyResults CollectResults(const StudyFolder& folder, const VariantFunction& variant_of,
                            const std::function<void(const std::string&)>& warn) {
  const StudyDescription description = folder.ReadDescription();
  const StudySpec& spec = description.spec;
  const StudyPlan plan = MakePlan(spec, variant_of);
  StudyResults results;
  results.name = spec.name;
  results.title = spec.title;
  results.command = description.command;
  results.commit = description.commit;
  results.build = description.build;
  results.machine = description.machine;
  results.base = spec.base;
  for (const std::string& path : spec.paths) results.paths.push_back(path);
  for (const StudyScene& scene : spec.scenes) results.paths.push_back(scene.name);
  for (const KnobSweep& sweep : spec.knobs) results.knobs.push_back(sweep.knob);
  std::set<std::string> references;
  std::set<std::string> cpus;
  for (const PlannedCase& c : plan.cases) {
    CaseRecord record = RecordOf(c);
    bool any = false;
    for (const CaseWork work : {CaseWork::kErrors, CaseWork::kCosts}) {
      if (!c.Has(work)) continue;
      const auto found = ReadOrWarn([&] { return folder.Read(c.id, work); }, warn);
      if (!found || found->input != c.InputOf(work)) continue;
      any = true;
      AddWork(record, *found);
      results.seconds += found->seconds;
      if (!found->path_title.empty()) results.path_titles[c.path] = found->path_title;
      if (work == CaseWork::kCosts) cpus.insert(found->cpu);
    }
    if (!any) {
      record.state = CaseState::kOmitted;
      record.why = "not run";
    }
    if (record.state == CaseState::kOmitted && record.why == kNotOffered) continue;
    results.cases.push_back(std::move(record));
    references.insert(c.reference);
  }
  for (const std::string& name : references) {
    const auto kept = ReadOrWarn([&] { return folder.ReadReference(name); }, warn);
    if (!kept) continue;
    results.references.push_back(kept->record);
    results.seconds += kept->record.seconds;
  }
  if (cpus.size() > 1 && warn) {
    warn(fmt::format("costs were measured on {} kinds of machines: {}", cpus.size(), fmt::join(cpus, "; ")));
  }
  return results;
}

StudyEstimate EstimateStudy(const StudyPlan& plan, const StudyRunOptions& options) {
  const StudyFolder folder(options.shard ? FolderOfShard(options.folder, *options.shard) : options.folder);
  std::vector<std::size_t> own;
  if (options.shard) {
    own = SplitPlan(plan, options.shard->count)[static_cast<std::size_t>(options.shard->index)];
  } else {
    for (std::size_t i = 0; i < plan.cases.size(); ++i) own.push_back(i);
  }
  StudyEstimate estimate;
  estimate.cases = own.size();
  struct Sum {
    double weight = 0;
    double seconds = 0;
    double left = 0;

    double Estimate(double guess_s) const { return left * (weight > 0 ? seconds / weight : guess_s); }
  };
  Sum errors;
  Sum costs;
  Sum references;
  std::set<std::string> names;
  for (const std::size_t i : own) {
    const PlannedCase& c = plan.cases[i];
    for (const CaseWork work : {CaseWork::kErrors, CaseWork::kCosts}) {
      if (!c.Has(work) || !(work == CaseWork::kErrors ? options.errors : options.costs)) continue;
      if (work == CaseWork::kErrors) names.insert(c.reference);
      Sum& sum = work == CaseWork::kErrors ? errors : costs;
      const auto record = ReadOrWarn([&] { return folder.Read(c.id, work); }, {});
      if (record && record->input == c.InputOf(work) && record->state == CaseState::kDone) {
        sum.weight += c.WeightOf(work);
        sum.seconds += record->seconds;
      } else {
        sum.left += c.WeightOf(work);
        ++estimate.left;
      }
    }
  }
  for (const std::string& name : names) {
    const auto kept = ReadOrWarn([&] { return folder.ReadReference(name); }, {});
    if (kept && kept->why.empty()) {
      references.weight += 1;
      references.seconds += kept->record.seconds;
    } else {
      references.left += 1;
    }
  }
  estimate.references = names.size();
  estimate.references_s = references.Estimate(kReference_s);
  estimate.errors_s = errors.Estimate(kErrors_s);
  estimate.costs_s = costs.Estimate(kCosts_s);
  estimate.measured = errors.weight + costs.weight + references.weight > 0;
  return estimate;
}

}  // namespace kerf
