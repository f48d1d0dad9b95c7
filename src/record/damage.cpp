#include "record/damage.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>

namespace kerf {
namespace {

constexpr std::size_t kMostGapsNamed = 3;

std::string DescribeGaps(const RecordingDamage& damage) {
  const std::size_t named = std::min(damage.gaps.size(), kMostGapsNamed);
  std::string where;
  for (std::size_t i = 0; i < named; ++i) {
    const LostSteps& gap = damage.gaps[i];
    where += fmt::format("{}from {:.3f} to {:.3f} s", i == 0 ? "" : ", ", gap.from_s, gap.to_s);
  }
  if (damage.gaps.size() > named) where += fmt::format(" and in {} more places", damage.gaps.size() - named);
  return fmt::format("the steps {} are damaged: {} of {} ticks", where, damage.lost_steps, damage.known_steps);
}

}  // namespace

const char* ToString(RecordingState state) {
  switch (state) {
    case RecordingState::kWhole:
      return "whole";
    case RecordingState::kCutShort:
      return "cut short";
    case RecordingState::kDamaged:
      break;
  }
  return "damaged";
}

std::string Describe(const RecordingDamage& damage, std::uint64_t others, std::uint64_t bad_tail_bytes,
                     double duration_s) {
  if (damage.state == RecordingState::kWhole) return "";
  std::vector<std::string> parts;
  if (!damage.gaps.empty()) parts.push_back(DescribeGaps(damage));
  if (others > 0) {
    parts.push_back(
        fmt::format("{} {} damaged", others,
                    others == 1 ? "block of inputs, events or pieces is" : "blocks of inputs, events or pieces are"));
  }
  if (bad_tail_bytes > 0) parts.push_back(fmt::format("the last {} bytes are damaged", bad_tail_bytes));
  if (damage.has_end && parts.empty())
    parts.push_back(fmt::format("{} bytes in it belong to no block", damage.bad_bytes));
  if (damage.state == RecordingState::kCutShort) {
    parts.push_back(fmt::format("cut short at {:.3f} s: no end", duration_s));
  } else if (!damage.has_end) {
    parts.push_back(fmt::format("no end after {:.3f} s", duration_s));
  }
  return fmt::format("{}", fmt::join(parts, "; "));
}

}  // namespace kerf
