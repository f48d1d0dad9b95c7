#include "loop/record/damage.h"

#include <fmt/format.h>

#include <algorithm>

namespace kerf {
namespace {

constexpr std::size_t kMaxGapsListed = 3;

std::string DescribeGaps(const RecordingDamage& damage) {
  const std::size_t named = std::min(damage.gaps.size(), kMaxGapsListed);
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

std::string Describe(const LostBlocks& lost) {
  if (lost.count > 1 || !lost.last_kind) {
    return fmt::format("{} of the blocks that hold inputs, events and pieces {} damaged", lost.count,
                       lost.count == 1 ? "is" : "are");
  }
  switch (*lost.last_kind) {
    case BlockKind::kMeta:
      return "one of the two copies of its header is damaged";
    case BlockKind::kFile:
      return "an input of its scene is damaged";
    case BlockKind::kPiece:
      return "a piece of bone is damaged";
    case BlockKind::kEvent:
      return "an event is damaged";
    case BlockKind::kEnd:
      return "the block that describes its end is damaged";
    case BlockKind::kSteps:
    case BlockKind::kSeal:
      break;
  }
  return fmt::format("a block ({}) is damaged", ToString(*lost.last_kind));
}

std::string Describe(const RecordingDamage& damage, const std::vector<std::string>& faults, double duration_s) {
  if (damage.state == RecordingState::kWhole) return "";
  std::string sentence;
  const auto add = [&](const std::string& part) { sentence += (sentence.empty() ? "" : "; ") + part; };
  if (!damage.gaps.empty()) add(DescribeGaps(damage));
  for (const std::string& fault : faults) add(fault);
  if (damage.state == RecordingState::kCutShort && !damage.has_end) {
    add(fmt::format("cut short at {:.3f} s: its end is missing", duration_s));
  } else if (!damage.has_end) {
    add(fmt::format("its end after {:.3f} s is missing", duration_s));
  }
  if (sentence.empty()) add(fmt::format("{} bytes in it do not belong to a block", damage.bad_bytes));
  return sentence;
}

}  // namespace kerf
