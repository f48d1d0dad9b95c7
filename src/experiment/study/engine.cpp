#include "experiment/study/engine.h"

#include <fmt/format.h>
#include <sched.h>

#include <algorithm>
#include <filesystem>
#include <map>
#include <mutex>
#include <set>

#include "base/files/folder_lock.h"
#include "experiment/bench/measure.h"
#include "experiment/study/case_run.h"
#include "experiment/study/settings.h"
#include "kerf/error.h"
#include "kerf/version.h"
#include "session/run/work_list.h"

namespace kerf {
namespace {

/// Describes the current exception; call it inside a catch (...).
std::string DescribeFailure() {
  try {
    throw;
  } catch (const std::bad_alloc&) {
    return "not enough memory";
  } catch (const std::exception& e) {
    return e.what();
  } catch (...) {
    return "it failed";
  }
}

/// Returns the last core that this program may use, because the system's own work runs on the first ones.
std::optional<int> FindLastCore() {
  cpu_set_t set;
  CPU_ZERO(&set);
  if (sched_getaffinity(0, sizeof set, &set) != 0) return std::nullopt;
  for (int core = CPU_SETSIZE - 1; core >= 0; --core) {
    if (CPU_ISSET(core, &set)) return core;
  }
  return std::nullopt;
}

std::string InputOfReference(const PlannedCase& c) {
  // One reference serves all settings that share its name, so its input is only the path's content and the tolerance.
  const std::string& all = c.errors_input;
  return fmt::format("{} {}{}", all.substr(0, all.find(' ')), c.reference, all.substr(all.rfind(" tolerance=")));
}

/// The paths of a set of cases, each created once, and the reasons why some of them could not be created.
class Paths {
 public:
  Paths(const StudySpec& spec, const StudyWork& work, const std::set<std::string>& wanted) {
    std::vector<std::string> built_in;
    for (const std::string& name : spec.paths) {
      if (wanted.count(name) > 0) built_in.push_back(name);
    }
    if (!built_in.empty()) {
      StudyPathList list = work.make_paths(built_in);
      for (StudyPath& path : list.paths) {
        const std::string name = path.name;
        paths_.emplace(name, std::move(path));
      }
      for (const auto& [name, why] : list.left_out) left_out_[name] = {CaseState::kOmitted, why};
    }
    for (const StudyScene& scene : spec.scenes) {
      if (wanted.count(scene.name) == 0) continue;
      try {
        paths_.emplace(scene.name, work.make_scene_path(scene));
      } catch (...) {
        left_out_[scene.name] = {CaseState::kFailed, DescribeFailure()};
      }
    }
  }

  /// Returns null if there is no such path; see WhyNot().
  const StudyPath* Find(const std::string& name) const {
    const auto found = paths_.find(name);
    return found == paths_.end() ? nullptr : &found->second;
  }
  std::pair<CaseState, std::string> WhyNot(const std::string& name) const {
    const auto found = left_out_.find(name);
    return found == left_out_.end() ? std::pair(CaseState::kOmitted, std::string("this path is not available"))
                                    : found->second;
  }

 private:
  std::map<std::string, StudyPath> paths_;
  std::map<std::string, std::pair<CaseState, std::string>> left_out_;
};

/// A reference that several cases need; it stays in memory while some of them still need it.
struct SharedReference {
  const PlannedCase* first = nullptr;
  std::mutex mutex;
  std::shared_ptr<const StudyReference> reference;
  std::string why;  // reason if it cannot be made
  std::size_t left = 0;
  bool needed = false;  // whether a case that is not left out needs it
};

class Runner {
 public:
  Runner(const StudySpec& spec, const StudyWork& work, const StudyRunOptions& options, const StudyFolder& folder,
         const StudyPlan& plan, const std::vector<std::size_t>& own)
      : spec_(spec), work_(work), options_(options), folder_(folder), cpu_(ReadRunInfo().cpu) {
    for (const std::size_t i : own) own_.push_back(&plan.cases[i]);
  }

  StudyRunOutcome Run() {
    if (options_.costs) CheckCore(options_.core);
    FindRemainingWork();
    std::set<std::string> wanted;
    for (const auto& list : {left_errors_, left_costs_}) {
      for (const PlannedCase* c : list) wanted.insert(c->path);
    }
    const Paths paths(spec_, work_, wanted);
    outcome_.stopped = !(MakeReferences(paths) && RunErrors(paths) && RunCosts(paths));
    for (auto* list : {&outcome_.failed, &outcome_.omitted}) std::sort(list->begin(), list->end());
    return outcome_;
  }

 private:
  bool Stopped() const { return options_.stop != nullptr && options_.stop->load(); }

  void Warn(const std::string& what) {
    const std::lock_guard lock(mutex_);
    if (options_.warn) options_.warn(what);
  }

  void FindRemainingWork() {
    std::set<std::string> others;  // commits of the other versions of kerf that made existing records
    for (const CaseWork work : {CaseWork::kErrors, CaseWork::kCosts}) {
      if (!(work == CaseWork::kErrors ? options_.errors : options_.costs)) continue;
      for (const PlannedCase* c : own_) {
        if (!c->Has(work)) continue;
        std::optional<WorkRecord> record;
        try {
          record = folder_.Read(c->id, work);
        } catch (const Error& e) {
          Warn(fmt::format("{}; it is computed again", e.what()));
        }
        if (record && record->input == c->InputOf(work) && record->state == CaseState::kDone) {
          ++outcome_.kept;
          if (record->commit != CommitString()) others.insert(record->commit);
        } else {
          (work == CaseWork::kErrors ? left_errors_ : left_costs_).push_back(c);
        }
      }
    }
    for (const std::string& commit : others) {
      Warn(fmt::format("some records were made by kerf {}, while this is {}; they are kept", commit, CommitString()));
    }
  }

  bool MakeReferences(const Paths& paths) {
    for (const PlannedCase* c : left_errors_) {
      SharedReference& shared = references_[c->reference];
      if (shared.first == nullptr) shared.first = c;
      ++shared.left;
      const StudyPath* path = paths.Find(c->path);
      shared.needed = shared.needed || (path != nullptr && FindOmission(*path, c->holding, c->settings).empty());
    }
    WorkList list;
    for (auto& [name, shared] : references_) {
      if (!shared.needed) continue;
      const StudyPath* path = paths.Find(shared.first->path);
      if (path == nullptr || !Offers(*path, shared.first->holding)) continue;
      const std::string& key = name;
      SharedReference& one = shared;
      list.Add("references", 1, [this, &key, &one, path] {
        // The reference is not kept in memory, because its cases may come much later in the list.
        if (!IsReferenceThere(key, one)) MakeReference(key, one, *path);
      });
    }
    return list.Run(options_.jobs, options_.stop, options_.progress) && !Stopped();
  }

  bool IsReferenceThere(const std::string& name, const SharedReference& shared) {
    std::error_code ignored;
    if (!std::filesystem::exists(folder_.FileOfReference(name), ignored)) return false;
    try {
      const auto kept = folder_.ReadReference(name);
      return kept && kept->why.empty() && kept->input == InputOfReference(*shared.first);
    } catch (const Error& e) {
      Warn(fmt::format("{}; it is computed again", e.what()));
      return false;
    }
  }

  /// Returns null if it cannot be made (`shared.why`) or the study was stopped.
  std::shared_ptr<const StudyReference> MakeReference(const std::string& name, SharedReference& shared,
                                                      const StudyPath& path) {
    const PlannedCase& c = *shared.first;
    StoredReference kept{name, InputOfReference(c), "", {}};
    std::shared_ptr<const StudyReference> made;
    const std::int64_t start_ns = ReadClock_ns();
    try {
      made = std::make_shared<const StudyReference>(work_.make_reference(
          path, c.holding, c.settings, spec_.reference_tolerance, folder_.FileOfReference(name), options_.stop));
      kept.record = made->record;
    } catch (...) {
      shared.why = DescribeFailure();
      if (Stopped()) return nullptr;
      kept.why = shared.why;
      kept.record.holding = c.holding;
      kept.record.path = c.path;
      kept.record.variant = work_.variant_of(c.settings);
      kept.record.note = "could not be made: " + shared.why;
      kept.record.seconds = CalcSecondsSince(start_ns);
    }
    if (!Stopped()) folder_.WriteReference(kept);
    return Stopped() ? nullptr : made;
  }

  static bool Offers(const StudyPath& path, Holding holding) {
    return std::find(path.holdings.begin(), path.holdings.end(), holding) != path.holdings.end();
  }

  /// Does the work on one case and writes its record; calls `run` with the path if there is one.
  void Do(const PlannedCase& c, CaseWork work, const Paths& paths,
          const std::function<CaseOutcome(const StudyPath&)>& run) {
    WorkRecord record;
    record.id = c.id;
    record.work = work;
    record.input = c.InputOf(work);
    record.commit = CommitString();
    record.cpu = cpu_;
    const std::int64_t start_ns = ReadClock_ns();
    if (const StudyPath* path = paths.Find(c.path); path == nullptr) {
      std::tie(record.state, record.why) = paths.WhyNot(c.path);
    } else {
      record.path_title = path->title;
      try {
        const CaseOutcome outcome =
            Offers(*path, c.holding)
                ? run(*path)
                : CaseOutcome{CaseState::kOmitted, std::string(kNotOffered), std::nullopt, std::nullopt, 0, 0};
        record.state = outcome.state;
        record.why = outcome.why;
        record.errors = outcome.errors;
        record.costs = outcome.costs;
        record.force_hash = outcome.force_hash;
        record.bone_hash = outcome.bone_hash;
        const bool figures = work == CaseWork::kErrors ? outcome.errors.has_value() : outcome.costs.has_value();
        if (record.state == CaseState::kDone && !figures) {
          record.state = CaseState::kFailed;
          record.why = "it returned no figures";
        }
        ParseWorkRecord(FormatWorkRecord(record));  // throws if a figure is not finite
      } catch (...) {
        record.state = CaseState::kFailed;
        record.why = DescribeFailure();
        record.errors.reset();
        record.costs.reset();
        if (Stopped()) return;  // the stop may be the reason for the failure
      }
    }
    record.seconds = CalcSecondsSince(start_ns);
    folder_.Write(record);
    const std::lock_guard lock(mutex_);
    ++outcome_.made;
    const std::string name = fmt::format("{}, {}", c.id, ToString(work));
    if (record.state == CaseState::kFailed) outcome_.failed.emplace_back(name, record.why);
    if (record.state == CaseState::kOmitted) outcome_.omitted.emplace_back(name, record.why);
  }

  std::shared_ptr<const StudyReference> TakeReference(const PlannedCase& c, const StudyPath& path) {
    SharedReference& shared = references_.at(c.reference);
    const std::lock_guard lock(shared.mutex);
    if (!shared.why.empty()) throw Error("there is no reference: " + shared.why);
    if (!shared.reference) shared.reference = MakeReference(c.reference, shared, path);
    if (!shared.reference) throw Error("there is no reference: " + shared.why);
    return shared.reference;
  }

  void LeaveReference(const PlannedCase& c) {
    SharedReference& shared = references_.at(c.reference);
    const std::lock_guard lock(shared.mutex);
    if (--shared.left == 0) shared.reference.reset();
  }

  bool RunErrors(const Paths& paths) {
    // Sorted by reference, so that few references are in memory at once.
    std::stable_sort(left_errors_.begin(), left_errors_.end(),
                     [](const PlannedCase* a, const PlannedCase* b) { return a->reference < b->reference; });
    WorkList list;
    for (const PlannedCase* c : left_errors_) {
      list.Add("errors", c->errors_weight, [this, c, &paths] {
        Do(*c, CaseWork::kErrors, paths, [&](const StudyPath& path) {
          CaseOutcome omitted;
          omitted.state = CaseState::kOmitted;
          omitted.why = FindOmission(path, c->holding, c->settings);
          if (!omitted.why.empty()) return omitted;  // no reference is computed for an omitted case
          return work_.run_for_errors(path, c->holding, c->settings, *TakeReference(*c, path));
        });
        LeaveReference(*c);
      });
    }
    return list.Run(options_.jobs, options_.stop, options_.progress) && !Stopped();
  }

  bool RunCosts(const Paths& paths) {
    const std::optional<int> core = options_.core ? options_.core : FindLastCore();
    WorkList list;
    for (const PlannedCase* c : left_costs_) {
      list.Add("costs", c->costs_weight, [this, c, &paths, core] {
        Do(*c, CaseWork::kCosts, paths, [&](const StudyPath& path) {
          return work_.run_for_costs(path, c->holding, c->settings, static_cast<std::uint64_t>(c->ticks), core);
        });
      });
    }
    return list.Run(1, options_.stop, options_.progress) && !Stopped();
  }

  const StudySpec& spec_;
  const StudyWork& work_;
  const StudyRunOptions& options_;
  const StudyFolder& folder_;
  std::string cpu_;
  std::vector<const PlannedCase*> own_;
  std::vector<const PlannedCase*> left_errors_;
  std::vector<const PlannedCase*> left_costs_;
  std::map<std::string, SharedReference> references_;
  std::mutex mutex_;  // protects the outcome and the warnings
  StudyRunOutcome outcome_;
};

/// Throws Error if the folder belongs to another study.
void CheckFolder(const StudyFolder& folder, const StudyDescription& mine, bool extend) {
  if (!folder.HasDescription()) return;
  const StudyDescription there = folder.ReadDescription();
  if (there.plan_hash == mine.plan_hash || extend) return;
  throw Error(
      fmt::format("{}: holds the results of another study (\"{}\", {}; this is \"{}\", {}); choose another folder, or "
                  "use --extend to keep the results that fit",
                  folder.path(), there.spec.name, ShowHash(there.plan_hash), mine.spec.name, ShowHash(mine.plan_hash)));
}

}  // namespace

StudyRunOutcome RunStudy(const StudySpec& spec, const StudyWork& work, const StudyRunOptions& options) {
  const StudyPlan plan = MakePlan(spec, work.variant_of);
  const StudyFolder folder(options.shard ? FolderOfShard(options.folder, *options.shard) : options.folder);
  const FolderLock lock(folder.path());
  StudyDescription description{spec,           plan.hash,        options.shard,
                               options.errors, options.costs,    options.command,
                               CommitString(), CompilerString(), ReadRunInfo()};
  CheckFolder(folder, description, options.extend);
  if (folder.HasDescription()) {
    // Earlier requests still apply.
    const StudyDescription before = folder.ReadDescription();
    description.errors = description.errors || before.errors;
    description.costs = description.costs || before.costs;
  }
  folder.WriteDescription(description);
  std::vector<std::size_t> own;
  if (options.shard) {
    own = SplitPlan(plan, options.shard->count)[static_cast<std::size_t>(options.shard->index)];
  } else {
    for (std::size_t i = 0; i < plan.cases.size(); ++i) own.push_back(i);
  }
  return Runner(spec, work, options, folder, plan, own).Run();
}

}  // namespace kerf
