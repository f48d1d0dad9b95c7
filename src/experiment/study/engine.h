// Goes through the cases of a study and leaves a record of each; what is there already is not done again.
#pragma once

#include <atomic>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "experiment/study/study_folder.h"
#include "experiment/study/study_work.h"

namespace kerf {

struct StudyRunOptions {
  std::string folder;
  std::optional<Shard> shard;  // then the work is done in FolderOfShard()
  int jobs = 0;                // references and errors at once; 0: as many as the machine has cores
  bool errors = true;
  bool costs = true;
  std::optional<int> core;  // that the timed ticks are held to; none: the last that this program may use
  bool extend = false;      // into the folder of another study, keeping those of its records that fit
  std::string command;      // that was given, for the report
  const std::atomic<bool>* stop = nullptr;
  std::function<void(const std::string& stage, double fraction)> progress;
  std::function<void(const std::string&)> warn;  // one call at a time
};

/// Why a case is left out whose path can't be held that way; such cases are no part of the results.
inline constexpr std::string_view kNotOffered = "the path is not made for this holding";

struct StudyRunOutcome {
  std::size_t kept = 0;  // records that were there
  std::size_t made = 0;
  bool stopped = false;
  std::vector<std::pair<std::string, std::string>> failed;   // id and work; why
  std::vector<std::pair<std::string, std::string>> omitted;  // the same
};

/// References first, then errors, both on many threads; then costs, one after another. A case that fails leaves a
/// record that says why and is tried again the next time; the study goes on. Throws Error when the folder is another
/// study's or can't be written.
StudyRunOutcome RunStudy(const StudySpec& spec, const StudyWork& work, const StudyRunOptions& options);

/// What the folder's records say. Cases without a record are kOmitted. Damaged records count as none, and are warned
/// of.
StudyResults CollectResults(const StudyFolder& folder, const VariantFunction& variant_of,
                            const std::function<void(const std::string&)>& warn);

/// What is to be done, and about how long it takes.
struct StudyEstimate {
  std::size_t cases = 0;
  std::size_t references = 0;
  std::size_t left = 0;  // records that are not there yet
  double references_s = 0;
  double errors_s = 0;  // of one core
  double costs_s = 0;
  bool measured = false;  // from records in the folder; false: from figures of another machine
};
StudyEstimate EstimateStudy(const StudyPlan& plan, const StudyRunOptions& options);

}  // namespace kerf
