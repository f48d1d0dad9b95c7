// Merging of the shards of a study.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "experiment/study/study_folder.h"

namespace kerf {

struct MergeOutcome {
  std::size_t shards = 0;            // number of folders from which records were taken
  std::size_t records = 0;           // records in the folder now, each counted once
  std::size_t twice = 0;             // number of additional copies of records that were found more than once
  std::vector<std::string> missing;  // "shard 3/8 is missing: 41 cases: ...", one sentence for each shard
};

/// Collects the records of a study's shards in `out`, as if the study had been run there. `folders`: folders of shards,
/// or folders that contain such folders; if empty, the shards in `out`. A record that is found several times counts
/// once. Throws Error, naming both, if two shards belong to different studies or if two records of one case differ in a
/// result that does not depend on time; `out` is then unchanged.
MergeOutcome MergeShards(const std::vector<std::string>& folders, const std::string& out,
                         const VariantFunction& variant_of, const std::function<void(const std::string&)>& warn);

}  // namespace kerf
