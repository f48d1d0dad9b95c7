#include "experiment/study/merge.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <map>
#include <set>

#include "base/files/files.h"
#include "base/files/folder_lock.h"
#include "experiment/study/record_json.h"
#include "experiment/study/settings.h"
#include "kerf/error.h"

namespace kerf {
namespace {

constexpr std::size_t kNamed = 5;  // maximum number of cases in a sentence

struct Source {
  StudyFolder folder;
  StudyDescription description;
};

std::string ShowIds(const std::vector<std::string>& ids) {
  const std::size_t shown = std::min(ids.size(), kNamed);
  const std::vector<std::string> first(ids.begin(), ids.begin() + static_cast<std::ptrdiff_t>(shown));
  return fmt::format("{} case{}: {}{}", ids.size(), ids.size() == 1 ? "" : "s", fmt::join(first, ", "),
                     ids.size() > shown ? ", ..." : "");
}

std::vector<Source> FindSources(const std::vector<std::string>& folders, const std::string& out) {
  std::vector<std::string> names;
  for (const std::string& folder : folders.empty() ? std::vector<std::string>{out} : folders) {
    const StudyFolder one(folder);
    const std::vector<std::string> shards = one.ListShards();
    if (!shards.empty()) {
      names.insert(names.end(), shards.begin(), shards.end());
    } else if (one.HasDescription() && !folders.empty()) {
      names.push_back(folder);
    } else {
      throw Error(fmt::format("{}: contains no shard of a study", folder));
    }
  }
  std::vector<Source> sources;
  for (const std::string& name : names) {
    const auto same = [&](const Source& other) { return IsSameFile(other.folder.path(), name); };
    if (std::any_of(sources.begin(), sources.end(), same)) continue;  // listed twice
    const StudyFolder folder(name);
    sources.push_back({folder, folder.ReadDescription()});
  }
  return sources;
}

void CheckOneStudy(const std::vector<Source>& sources, const std::function<void(const std::string&)>& warn) {
  std::map<std::string, std::string> shards;  // maps "3/8" to its folder
  for (const Source& source : sources) {
    const Source& first = sources.front();
    const StudyDescription& d = source.description;
    if (d.plan_hash != first.description.plan_hash) {
      throw Error(fmt::format("{} (\"{}\", {}) and {} (\"{}\", {}) belong to different studies", first.folder.path(),
                              first.description.spec.name, ShowHash(first.description.plan_hash), source.folder.path(),
                              d.spec.name, ShowHash(d.plan_hash)));
    }
    if (d.commit != first.description.commit && warn) {
      warn(fmt::format("{} was made by kerf {}, {} by {}", first.folder.path(), first.description.commit,
                       source.folder.path(), d.commit));
    }
    if (!d.shard) continue;
    const auto [there, added] = shards.emplace(ToString(*d.shard), source.folder.path());
    if (!added && warn) {
      warn(fmt::format("shard {} is present twice, in {} and {}; each case counts once", there->first, there->second,
                       source.folder.path()));
    }
  }
}

/// Returns the record to keep of two records of a case; throws Error if they contradict each other.
const WorkRecord& Choose(const WorkRecord& a, const std::string& file_a, const WorkRecord& b,
                         const std::string& file_b) {
  if (a.state != b.state) {
    // A case that failed on one machine may have succeeded on another.
    if (a.state == CaseState::kDone) return a;
    if (b.state == CaseState::kDone) return b;
    return a.state == CaseState::kFailed ? a : b;
  }
  if (a.state == CaseState::kDone && !AgreeInAllButTimes(a, b)) {
    throw Error(fmt::format(
        "{} and {} contradict each other in results that do not depend on time (forces {} and {}, bone {} and "
        "{}; kerf {} and "
        "{}); remove the one that is wrong",
        file_a, file_b, ShowHash(a.force_hash), ShowHash(b.force_hash), ShowHash(a.bone_hash), ShowHash(b.bone_hash),
        a.commit, b.commit));
  }
  const bool b_has_more = b.errors && b.errors->impulse_signed && a.errors && !a.errors->impulse_signed;
  return b_has_more ? b : a;
}

class Merger {
 public:
  Merger(const std::vector<Source>& sources, const StudyFolder& out, const VariantFunction& variant_of,
         const std::function<void(const std::string&)>& warn)
      : sources_(sources), out_(out), warn_(warn) {
    whole_ = sources.front().description;
    whole_.shard.reset();
    for (const Source& source : sources) {
      whole_.errors = whole_.errors || source.description.errors;
      whole_.costs = whole_.costs || source.description.costs;
    }
    if (out_.HasDescription()) {  // its earlier requests still apply
      const auto before = out_.ReadDescription();
      whole_.errors = whole_.errors || before.errors;
      whole_.costs = whole_.costs || before.costs;
    }
    plan_ = MakePlan(whole_.spec, variant_of);
    if (plan_.hash != whole_.plan_hash) {
      throw Error(fmt::format("{}: was made by a version of kerf that plans this study differently (commit {})",
                              sources.front().folder.path(), whole_.commit));
    }
  }

  MergeOutcome Merge() {
    Collect();  // detects all contradictions before anything is written
    CollectReferences();
    for (const char* name : {"cases", "references"}) {
      MakeFolder((std::filesystem::path(out_.path()) / name).string());
    }
    for (const auto& [key, found] : records_) {
      if (!found.in_out) out_.Write(found.record, true);
    }
    for (const auto& [name, kept] : references_) out_.WriteReference(kept);
    out_.WriteDescription(whole_);
    outcome_.shards = sources_.size();
    outcome_.records = records_.size();
    FindMissing();
    return outcome_;
  }

 private:
  struct Found {
    WorkRecord record;
    std::string file;
    bool in_out = false;  // whether the file is already in `out`
  };

  bool IsRequested(CaseWork work) const { return work == CaseWork::kErrors ? whole_.errors : whole_.costs; }

  std::vector<const StudyFolder*> Folders() const {
    std::vector<const StudyFolder*> folders;
    if (out_.HasDescription()) folders.push_back(&out_);
    for (const Source& source : sources_) {
      if (!IsSameFile(source.folder.path(), out_.path())) folders.push_back(&source.folder);
    }
    return folders;
  }

  template <typename Read>
  auto ReadOrWarn(Read&& read) -> decltype(read()) {
    try {
      return read();
    } catch (const Error& e) {
      if (warn_) warn_(fmt::format("{}; it counts as missing", e.what()));
      return std::nullopt;
    }
  }

  void Collect() {
    for (const StudyFolder* folder : Folders()) {
      const bool in_out = folder == &out_;
      for (const PlannedCase& c : plan_.cases) {
        for (const CaseWork work : {CaseWork::kErrors, CaseWork::kCosts}) {
          if (!c.Has(work)) continue;
          const auto record = ReadOrWarn([&] { return folder->Read(c.id, work); });
          if (!record || record->input != c.InputOf(work)) continue;
          Found found{*record, folder->FileOf(c.id, work), in_out};
          const auto [there, added] = records_.emplace(std::pair(c.id, work), found);
          if (added) continue;
          if (!there->second.in_out) ++outcome_.twice;
          if (&Choose(there->second.record, there->second.file, found.record, found.file) == &found.record) {
            there->second = found;
          }
        }
      }
    }
  }

  void CollectReferences() {
    std::map<std::string, std::string> from;
    std::set<std::string> names;
    for (const PlannedCase& c : plan_.cases) names.insert(c.reference);
    for (const StudyFolder* folder : Folders()) {
      for (const std::string& name : names) {
        const auto kept = ReadOrWarn([&] { return folder->ReadReference(name); });
        if (!kept) continue;
        const auto [there, added] = references_.emplace(name, *kept);
        if (added) {
          from[name] = folder->path();
          continue;
        }
        StoredReference& first = there->second;
        if (!kept->why.empty()) continue;
        if (!first.why.empty()) {
          first = *kept;
        } else if (first.record.force_hash != kept->record.force_hash || first.input != kept->input) {
          throw Error(fmt::format(
              "the references {} in {} and {} contradict each other (forces {} and {}); remove the "
              "one that is wrong",
              name, from[name], folder->path(), ShowHash(first.record.force_hash), ShowHash(kept->record.force_hash)));
        }
      }
    }
  }

  bool IsThere(const PlannedCase& c) const {
    for (const CaseWork work : {CaseWork::kErrors, CaseWork::kCosts}) {
      if (c.Has(work) && IsRequested(work) && records_.count({c.id, work}) == 0) return false;
    }
    return true;
  }

  void FindMissing() {
    std::map<int, std::set<int>> there;  // total number of shards, and the indices of those that exist
    for (const Source& source : sources_) {
      if (const auto& shard = source.description.shard) there[shard->count].insert(shard->index);
    }
    if (there.size() != 1) {  // no shards, or shards of different splits: the missing work is reported by case
      std::vector<std::string> ids;
      for (const PlannedCase& c : plan_.cases) {
        if (!IsThere(c)) ids.push_back(c.id);
      }
      if (!ids.empty()) outcome_.missing.push_back(fmt::format("missing: {}", ShowIds(ids)));
      return;
    }
    const auto& [count, indices] = *there.begin();
    const auto split = SplitPlan(plan_, count);
    for (int index = 0; index < count; ++index) {
      std::vector<std::string> ids;
      for (const std::size_t i : split[static_cast<std::size_t>(index)]) {
        if (!IsThere(plan_.cases[i])) ids.push_back(plan_.cases[i].id);
      }
      if (ids.empty()) continue;
      outcome_.missing.push_back(fmt::format("shard {}/{} is {}: {}", index, count,
                                             indices.count(index) > 0 ? "not complete" : "missing", ShowIds(ids)));
    }
  }

  const std::vector<Source>& sources_;
  const StudyFolder& out_;
  const std::function<void(const std::string&)>& warn_;
  StudyDescription whole_;
  StudyPlan plan_;
  std::map<std::pair<std::string, CaseWork>, Found> records_;
  std::map<std::string, StoredReference> references_;
  MergeOutcome outcome_;
};

}  // namespace

MergeOutcome MergeShards(const std::vector<std::string>& folders, const std::string& out,
                         const VariantFunction& variant_of, const std::function<void(const std::string&)>& warn) {
  const std::vector<Source> sources = FindSources(folders, out);
  CheckOneStudy(sources, warn);
  const StudyFolder target(out);
  if (target.HasDescription()) {
    const StudyDescription there = target.ReadDescription();
    if (there.plan_hash != sources.front().description.plan_hash) {
      throw Error(
          fmt::format("{}: holds the results of another study (\"{}\"); choose another folder", out, there.spec.name));
    }
  }
  const FolderLock lock(out);
  return Merger(sources, target, variant_of, warn).Merge();
}

}  // namespace kerf
