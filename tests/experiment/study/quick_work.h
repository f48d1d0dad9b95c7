// Work functions of a study that take no time. Their results are known, because the figures are functions of the
// settings.
#pragma once

#include <algorithm>
#include <atomic>
#include <filesystem>
#include <functional>
#include <memory>
#include <mutex>
#include <set>
#include <string>

#include "base/files/files.h"
#include "experiment/study/settings.h"
#include "experiment/study/study_folder.h"
#include "experiment/study/study_work.h"
#include "kerf/error.h"

namespace kerf::test {

struct QuickWorkLog {
  std::mutex mutex;
  std::multiset<std::string> references;  // path.holding.variant
  std::multiset<std::string> errors;      // path.holding settings
  std::multiset<std::string> costs;
  std::atomic<int> works{0};    // errors and costs
  std::atomic<int> at_once{0};  // costs being measured now
  std::atomic<int> max_at_once{0};
};

inline const std::vector<std::string> kQuickPaths{"entry", "slot", "idle", "absent"};

/// Returns work that omits the path "absent". `before`: called before each piece of work with its zero-based index.
inline StudyWork MakeQuickWork(QuickWorkLog& log, const std::function<void(int)>& before = {}) {
  StudyWork work;
  work.make_paths = [](const std::vector<std::string>& names) {
    StudyPathList list;
    for (const std::string& name : names) {
      if (name == "absent") {
        list.left_out.emplace_back(name, "its data are not there");
        continue;
      }
      StudyPath path;
      path.name = name;
      path.title = "The path " + name;
      path.duration_s = 1;
      path.holdings = {Holding::kHand, Holding::kPath};
      if (name == "idle") path.holdings = {Holding::kHand};
      list.paths.push_back(path);
    }
    return list;
  };
  work.make_scene_path = [](const StudyScene& scene) {
    StudyPath path;
    path.name = scene.name;
    path.holdings = {Holding::kHand, Holding::kPath};
    return path;
  };
  work.variant_of = [](const StudySettings& settings) {
    return settings.law == StudySettings{}.law ? std::string() : "law=" + settings.law;
  };
  work.make_reference = [&log, variant_of = work.variant_of](const StudyPath& path, Holding holding,
                                                             const StudySettings& settings, double,
                                                             const std::string& file, const std::atomic<bool>*) {
    const std::string what = path.name + "." + std::string(ToString(holding)) + "." + variant_of(settings);
    {
      const std::lock_guard lock(log.mutex);
      log.references.insert(what);
    }
    if (settings.law == "hertz_constant_bite") throw Error("this law has no reference");
    WriteTextFile(file, what);
    StudyReference reference;
    reference.record.holding = holding;
    reference.record.path = path.name;
    reference.record.variant = variant_of(settings);
    reference.record.force_hash = HashText(what);
    reference.record.error_bar = 1e-4;
    return reference;
  };
  const auto begin = [&log, before] {
    const int number = log.works++;
    if (before) before(number);
  };
  work.run_for_errors = [&log, begin](const StudyPath& path, Holding holding, const StudySettings& settings,
                                      const StudyReference& reference) {
    begin();
    if (reference.record.path != path.name || reference.record.holding != holding) throw Error("a wrong reference");
    const std::string what = path.name + "." + std::string(ToString(holding)) + " " + ShowSettings(settings);
    {
      const std::lock_guard lock(log.mutex);
      log.errors.insert(what);
    }
    CaseOutcome outcome;
    outcome.errors = ErrorFigures{};
    outcome.errors->force_p95 = 0.1 * settings.voxel_mm;
    outcome.errors->force_l2 = 1.0 / 3.0;
    outcome.force_hash = HashText(what);
    outcome.bone_hash = HashText(what + "bone");
    return outcome;
  };
  work.run_for_costs = [&log, begin](const StudyPath& path, Holding holding, const StudySettings& settings,
                                     std::uint64_t ticks, std::optional<int>) {
    const int now = ++log.at_once;
    int largest = log.max_at_once;
    while (now > largest && !log.max_at_once.compare_exchange_weak(largest, now)) {
    }
    begin();
    {
      const std::lock_guard lock(log.mutex);
      log.costs.insert(path.name + "." + std::string(ToString(holding)) + " " + ShowSettings(settings));
    }
    CaseOutcome outcome;
    outcome.costs = CostFigures{};
    outcome.costs->ticks = ticks;
    outcome.costs->tick.p50_us = 4 / settings.voxel_mm;
    outcome.costs->histogram = {{100, ticks}};
    --log.at_once;
    return outcome;
  };
  return work;
}

inline constexpr char kQuickStudy[] = R"(
title = "Quick"
[study]
paths = ["entry", "slot"]
ticks_per_case = 2000
[[knob]]
name = "voxel_mm"
values = [0.4, 0.2, 0.1]
[[knob]]
name = "law"
values = ["edge_plus_chip"]
)";

inline StudySpec QuickSpec(const std::string& text = kQuickStudy) {
  return ParseStudy(text, "quick.toml", kQuickPaths);
}

/// Returns every record of a folder by its file name, without the fields that vary between runs.
inline std::set<std::string> ReadAllRecords(const std::string& folder) {
  std::set<std::string> records;
  for (const auto& entry : std::filesystem::directory_iterator(std::filesystem::path(folder) / "cases")) {
    WorkRecord record = ParseWorkRecord(ReadTextFile(entry.path().string()));
    record.seconds = 0;
    records.insert(entry.path().filename().string() + FormatWorkRecord(record));
  }
  return records;
}

}  // namespace kerf::test
