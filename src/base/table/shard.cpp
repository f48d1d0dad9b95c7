#include "base/table/shard.h"

#include <fmt/format.h>

#include <charconv>
#include <filesystem>

#include "kerf/error.h"

namespace kerf {

Shard ShardFromText(const std::string& text) {
  Shard shard;
  const char* const end = text.data() + text.size();
  const auto [slash, no_index] = std::from_chars(text.data(), end, shard.index);
  const bool divided = no_index == std::errc() && slash != end && *slash == '/';
  const auto [rest, no_count] = std::from_chars(divided ? slash + 1 : end, end, shard.count);
  if (!divided || no_count != std::errc() || rest != end || shard.index < 0 || shard.count < 1 ||
      shard.count > 1'000'000) {
    throw Error(fmt::format("\"{}\" must be I/N, counted from 0: the first of eight is 0/8, the last 7/8", text));
  }
  if (shard.index >= shard.count) {
    throw Error(fmt::format(
        "{} is beyond the last of {} shards, {}/{}: they are counted from 0 (sbatch --array=0-{}); to run some of an "
        "array's tasks again, give the total number of shards",
        text, shard.count, shard.count - 1, shard.count, shard.count - 1));
  }
  return shard;
}

std::string ToString(Shard shard) {
  return fmt::format("{}/{}", shard.index, shard.count);
}

std::string FolderOfShard(const std::string& folder, Shard shard) {
  return (std::filesystem::path(folder) / fmt::format("shard-{}-of-{}", shard.index, shard.count)).string();
}

}  // namespace kerf
