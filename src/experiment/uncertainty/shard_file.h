// The samples of a shard as a file, and the merge of all shards.
//
//   OUT/shard-1-of-3/samples.json   the head and the samples of one shard, every number exact
#pragma once

#include <string>
#include <vector>

#include "experiment/uncertainty/uncertain.h"

namespace kerf {

inline constexpr const char* kSamplesFile = "samples.json";

std::string FormatSamples(const UncertainRun& run, const std::optional<Shard>& shard);
/// Throws kerf::Error, with the name of the file, if the text is not one of FormatSamples().
UncertainRun ParseSamples(const std::string& text, const std::string& file);

struct MergedRun {
  UncertainRun run;
  std::size_t files = 0;
  std::size_t twice = 0;     // samples that were found more than once; each is counted once
  std::vector<int> missing;  // numbers of the samples that were not found
};
/// Reads the shards in a folder. The result has the same bits as one run. Throws kerf::Error, naming the files, if
/// there is none, one is damaged, two belong to different runs or contradict each other, or they belong to another
/// scene or to other parameters.
MergedRun MergeSamples(const std::string& folder, const Scene& scene, const UncertainParams& params);

/// Returns a sentence such as "67 of 200 samples are missing: those of shard 1/3"; empty if none is missing.
std::string DescribeMissing(const MergedRun& merged, const std::string& folder);

}  // namespace kerf
