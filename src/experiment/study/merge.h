// Shards of a study put together.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "experiment/study/study_folder.h"

namespace kerf {

struct MergeOutcome {
  std::size_t shards = 0;            // folders that records were taken from
  std::size_t records = 0;           // in the folder now, each once
  std::size_t twice = 0;             // found more than once, and the same
  std::vector<std::string> missing;  // "shard 3/8 is missing: 41 cases: ...", a sentence for each shard
};

/// Collects the records of shards of one study in `out`, where the study then stands as if it had been made there.
/// `folders`: of shards, or such that hold folders of shards; empty: those in `out`. A record that is there several
/// times counts once. Throws Error, naming both, when shards are of different studies or two records of one case
/// contradict each other in what does not depend on time; `out` is then as it was.
MergeOutcome MergeShards(const std::vector<std::string>& folders, const std::string& out,
                         const VariantFunction& variant_of, const std::function<void(const std::string&)>& warn);

}  // namespace kerf
