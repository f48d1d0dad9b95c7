// A part of a computation that is distributed over several machines.
#pragma once

#include <string>

namespace kerf {

struct Shard {
  int index = 0;  // zero-based
  int count = 1;
};
/// Parses a shard such as "3/8", the fourth of eight. Throws Error if the text is not a shard or the index is not below
/// the count; the message says what to set in Slurm.
Shard ShardFromText(const std::string& text);
std::string ToString(Shard shard);  // "3/8"
/// Returns the path of the folder of a shard: "OUT/shard-3-of-8".
std::string FolderOfShard(const std::string& folder, Shard shard);

}  // namespace kerf
