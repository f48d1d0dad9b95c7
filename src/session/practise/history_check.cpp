#include "session/practise/history_check.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <map>
#include <nlohmann/json.hpp>
#include <numeric>

#include "base/core/sha256.h"
#include "base/files/json_text.h"
#include "kerf/error.h"

namespace kerf {
namespace {

/// Maximum number of duplicates that are listed for an attempt.
constexpr std::size_t kMaxDuplicates = 5;
/// Maximum size of a sheet; a typical one takes about 10 kB.
constexpr std::size_t kMaxMeasuresBytes = std::size_t{1} << 20;

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
        &row.incomplete, &row.steps_digest, &row.beginning, &row.seal, &row.signer}) {
    all += fmt::format(" {}:{}", text->size(), *text);
  }
  const std::string own = Sum(all);
  return {own, Sum(chain_before + own)};
}

void FindDuplicates(std::vector<Attempt>& attempts) {
  // Union-find: each attempt points to an earlier one of its group, and the first one to itself.
  std::vector<std::size_t> parents(attempts.size());
  std::iota(parents.begin(), parents.end(), std::size_t{0});
  const auto find_first = [&](std::size_t i) {
    for (; parents[i] != i; i = parents[i]) parents[i] = parents[parents[i]];
    return i;
  };
  std::array<std::map<std::string, std::size_t>, 3> first_with;
  for (std::size_t i = 0; i < attempts.size(); ++i) {
    const Attempt& a = attempts[i];
    const std::array<const std::string*, 3> keys{&a.hash, &a.steps_digest, &a.beginning};
    for (std::size_t k = 0; k < keys.size(); ++k) {
      if (keys[k]->empty()) continue;
      const std::size_t other = find_first(first_with[k].try_emplace(*keys[k], i).first->second);
      const std::size_t own = find_first(i);
      parents[std::max(own, other)] = std::min(own, other);
    }
  }
  std::map<std::size_t, std::vector<std::int64_t>> groups;
  for (std::size_t i = 0; i < attempts.size(); ++i) groups[find_first(i)].push_back(attempts[i].number);
  for (std::size_t i = 0; i < attempts.size(); ++i) {
    Attempt& a = attempts[i];
    const std::vector<std::int64_t>& group = groups[find_first(i)];
    a.duplicates.clear();
    for (const std::int64_t number : group) {
      if (number != a.number && a.duplicates.size() < kMaxDuplicates) a.duplicates.push_back(number);
    }
    a.more_duplicates = group.size() - 1 - a.duplicates.size();
  }
}

nlohmann::ordered_json ParseMeasures(const Attempt& attempt) {
  using nlohmann::ordered_json;
  const std::string& text = attempt.measures_json;
  if (attempt.damaged || text.size() > kMaxMeasuresBytes) return ordered_json::object();
  try {
    CheckJsonDepth(text, "it");
  } catch (const Error&) {
    return ordered_json::object();
  }
  ordered_json sheet = ordered_json::parse(text, nullptr, false);
  if (!sheet.is_object() || !sheet.contains("measures")) return ordered_json::object();
  ordered_json& measures = sheet["measures"];
  const auto is_object = [](const ordered_json& measure) { return measure.is_object(); };
  if (!measures.is_object() || !std::all_of(measures.begin(), measures.end(), is_object)) return ordered_json::object();
  return std::move(measures);
}

std::optional<double> FindValue(const nlohmann::ordered_json& measures, const std::string& key) {
  const auto measure = measures.find(key);
  if (measure == measures.end()) return {};
  const auto value = measure->find("value");
  if (value == measure->end() || !value->is_number()) return {};
  return value->get<double>();
}

std::vector<std::string> FindMarks(const Attempt& a) {
  std::vector<std::string> marks;
  if (a.damaged) marks.emplace_back("DAMAGED in the history: changed since it was stored");
  if (a.follows_change) marks.emplace_back("an attempt before this one was changed, removed or added");
  if (!a.incomplete.empty()) marks.push_back(fmt::format("not graded: {}", a.incomplete));
  if (a.seal == "broken") marks.emplace_back("seal broken");
  if (!a.duplicates.empty()) {
    marks.push_back(fmt::format("same recording or beginning as number {}{}", fmt::join(a.duplicates, ", "),
                                a.more_duplicates > 0 ? fmt::format(" and {} more", a.more_duplicates) : ""));
  }
  return marks;
}

}  // namespace kerf
