#include <array>

#include "experiment/study/study_csv.h"
#include "target.h"

namespace kerf::fuzz {

/// The input contains the four files one after the other, separated by lines of ====.
KERF_FUZZ_TARGET(study_results) {
  constexpr std::array<const char*, 4> kNames{"study.json", "cases.csv", "cases_times.csv", "references.csv"};
  constexpr std::string_view kBetween = "====\n";
  static const MemoryFolder folder;
  for (const char* name : kNames) {
    const std::size_t end = std::min(bytes.find(kBetween), bytes.size());
    folder.Write(name, bytes.substr(0, end));
    bytes.remove_prefix(std::min(end + kBetween.size(), bytes.size()));
  }
  Accepts([&] { ReadStudyResults(folder.path()); });
}

}  // namespace kerf::fuzz
