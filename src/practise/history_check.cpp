#include "practise/history_check.h"

#include <fmt/format.h>

#include <array>
#include <bit>
#include <map>
#include <set>

#include "core/sha256.h"

namespace kerf {
namespace {

std::string Sum(const std::string& text) {
  const std::vector<std::uint8_t> bytes(text.begin(), text.end());
  return CalcSha256(bytes);
}

}  // namespace

RowSums CalcRowSums(const Attempt& row, const std::string& chain_before) {
  std::string all = fmt::format("{} {} {}", row.number, row.level,
                                row.total ? fmt::format("{:016x}", std::bit_cast<std::uint64_t>(*row.total)) : "-");
  for (const std::string* text :
       {&row.student, &row.exercise, &row.taken, &row.recording, &row.hash, &row.measures_json, &row.recording_state,
        &row.incomplete, &row.steps_digest, &row.seal, &row.signer}) {
    all += fmt::format(" {}:{}", text->size(), *text);
  }
  const std::string own = Sum(all);
  return {own, Sum(chain_before + own)};
}

void FindDoubles(std::vector<Attempt>& attempts) {
  std::map<std::string, std::set<std::int64_t>> by_content;
  const auto keys = [](const Attempt& a) { return std::array{"steps " + a.steps_digest, "file " + a.hash}; };
  const auto is_known = [](const Attempt& a, std::size_t i) { return !(i == 0 ? a.steps_digest : a.hash).empty(); };
  for (const Attempt& a : attempts) {
    for (std::size_t i = 0; i < 2; ++i) {
      if (is_known(a, i)) by_content[keys(a)[i]].insert(a.number);
    }
  }
  for (Attempt& a : attempts) {
    std::set<std::int64_t> same;
    for (std::size_t i = 0; i < 2; ++i) {
      if (is_known(a, i)) same.merge(std::set(by_content[keys(a)[i]]));
    }
    same.erase(a.number);
    a.doubles.assign(same.begin(), same.end());
  }
}

std::vector<std::string> FindMarks(const Attempt& a) {
  std::vector<std::string> marks;
  if (a.damaged) marks.emplace_back("DAMAGED in the history: not what was kept");
  if (a.follows_change) marks.emplace_back("an attempt before this one was changed, removed or added");
  if (!a.incomplete.empty()) marks.push_back(fmt::format("not graded: {}", a.incomplete));
  if (a.seal == "broken") marks.emplace_back("seal broken");
  if (!a.doubles.empty()) marks.push_back(fmt::format("same recording as number {}", fmt::join(a.doubles, ", ")));
  return marks;
}

}  // namespace kerf
