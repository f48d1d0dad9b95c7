#include "base/core/nearest_name.h"

#include <algorithm>
#include <numeric>

namespace kerf {
namespace {

char Lower(char c) {
  return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
}

}  // namespace

std::size_t CalcEditDistance(std::string_view a, std::string_view b) {
  std::vector<std::size_t> row(b.size() + 1);
  std::iota(row.begin(), row.end(), std::size_t{0});
  for (std::size_t i = 0; i < a.size(); ++i) {
    std::size_t diagonal = row[0];
    row[0] = i + 1;
    for (std::size_t j = 0; j < b.size(); ++j) {
      const std::size_t replace = diagonal + (a[i] == b[j] ? 0 : 1);
      diagonal = row[j + 1];
      row[j + 1] = std::min({replace, row[j] + 1, row[j + 1] + 1});
    }
  }
  return row[b.size()];
}

std::string FindNearestName(std::string_view name, const std::vector<std::string>& names) {
  std::string wanted(name.substr(0, 200));
  std::transform(wanted.begin(), wanted.end(), wanted.begin(), Lower);
  std::size_t best = std::max<std::size_t>(2, wanted.size() / 3) + 1;
  std::string nearest;
  for (const std::string& candidate : names) {
    std::string lower = candidate;
    std::transform(lower.begin(), lower.end(), lower.begin(), Lower);
    const std::size_t distance = CalcEditDistance(wanted, lower);
    if (distance < best && distance < lower.size()) {
      best = distance;
      nearest = candidate;
    }
  }
  return nearest;
}

}  // namespace kerf
