// Runs every target on its corpus and on earlier findings, in an ordinary build.
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <functional>
#include <map>
#include <random>
#include <sstream>

#include "base/files/files.h"
#include "fuzz_targets.h"
#include "test_paths.h"

namespace kerf::fuzz {
namespace {

namespace fs = std::filesystem;

std::vector<std::string> ListFiles(const std::string& folder) {
  std::vector<std::string> files;
  std::error_code none;
  for (const auto& file : fs::directory_iterator(folder, none)) files.push_back(file.path().string());
  std::sort(files.begin(), files.end());
  return files;
}

class FuzzCorpus : public testing::TestWithParam<Target> {};

TEST_P(FuzzCorpus, IsReadOrRefusedWithASentence) {
  const std::string folder = std::string(KERF_SOURCE_DIR) + "/tests/fuzz";
  const std::vector<std::string> corpus = ListFiles(folder + "/corpus/" + GetParam().name);
  EXPECT_FALSE(corpus.empty()) << "no seeds for " << GetParam().name;
  std::vector<std::string> files = ListFiles(folder + "/regressions/" + GetParam().name);
  files.insert(files.end(), corpus.begin(), corpus.end());
  for (const std::string& file : files) {
    SCOPED_TRACE(file);
    GetParam().run(ReadTextFile(file));
  }
}

/// Replaces a fuzzer: truncates the files, changes bytes, duplicates parts.
TEST_P(FuzzCorpus, DamagedInputIsReadOrRefusedWithASentence) {
  std::mt19937 random(7);
  for (const std::string& file : ListFiles(std::string(KERF_SOURCE_DIR) + "/tests/fuzz/corpus/" + GetParam().name)) {
    const std::string whole = ReadTextFile(file);
    for (int n = 0; n < 300; ++n) {
      std::string spoiled = whole;
      if (n % 3 == 0) spoiled.resize(random() % (whole.size() + 1));
      if (n % 3 == 1) spoiled.insert(random() % whole.size(), whole.substr(random() % whole.size(), 1 + random() % 40));
      for (int k = 0; k < n % 5 && !spoiled.empty(); ++k)
        spoiled[random() % spoiled.size()] = static_cast<char>(random());
      GetParam().run(spoiled);
    }
  }
}

INSTANTIATE_TEST_SUITE_P(All, FuzzCorpus, testing::ValuesIn(Targets()), [](const auto& one) { return one.param.name; });

}  // namespace
}  // namespace kerf::fuzz
