// Runs the cases of a study and stores a record of each. Existing records are not computed again.
#pragma once

#include <atomic>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "experiment/bench/measure.h"
#include "experiment/study/study_folder.h"
#include "experiment/study/study_work.h"

namespace kerf {

struct StudyRunOptions {
  std::string folder;
  std::optional<Shard> shard;  // if set, the work is done in FolderOfShard()
  int jobs = 0;  // number of references and error cases computed in parallel; 0: number of cores of the machine
  bool errors = true;
  bool costs = true;
  std::optional<int> core;  // core for the timed ticks; if unset, the last one that this program may use
  bool extend = false;      // continue in the folder of another study, keeping the records that match
  std::string command;      // command line, for the report
  const std::atomic<bool>* stop = nullptr;
  std::function<void(const std::string& stage, double fraction)> progress;
  std::function<void(const std::string&)> warn;  // never called by two threads at once
};

template <typename V>
void Describe(StudyRunOptions& p, V&& visit) {
  visit("jobs", p.jobs, Range{0, 4096}, "number of references and errors computed at once; 0: one for each core");
  DescribeCore(p.core, visit);
}

/// Reason for leaving out a case whose path does not support the holding; such cases are not part of the results.
inline constexpr std::string_view kNotOffered = "the path does not support this holding";

struct StudyRunOutcome {
  std::size_t kept = 0;  // records that existed already
  std::size_t made = 0;
  bool stopped = false;
  std::vector<std::pair<std::string, std::string>> failed;   // id and work; reason
  std::vector<std::pair<std::string, std::string>> omitted;  // likewise
};

/// Computes the references first, then the errors, both in several threads, and finally the costs, one after another. A
/// case that fails leaves a record with the reason and is computed again in the next run; the study continues. Throws
/// Error if the folder belongs to another study or cannot be written.
StudyRunOutcome RunStudy(const StudySpec& spec, const StudyWork& work, const StudyRunOptions& options);

/// Returns the results that the folder's records contain. Cases without a record count as kOmitted. Damaged records are
/// ignored with a warning.
StudyResults CollectResults(const StudyFolder& folder, const VariantFunction& variant_of,
                            const std::function<void(const std::string&)>& warn);

/// The amount of work, and an estimate of its duration.
struct StudyEstimate {
  std::size_t cases = 0;
  std::size_t references = 0;
  std::size_t left = 0;  // records that do not exist yet
  double references_s = 0;
  double errors_s = 0;  // on one core
  double costs_s = 0;
  bool measured = false;  // true if based on records in the folder; false if based on figures from another machine
};
StudyEstimate EstimateStudy(const StudyPlan& plan, const StudyRunOptions& options);

}  // namespace kerf
