// Tests that the C++ snippet of docs/api.md compiles and runs, and that it is the same as on the page.
#include <gtest/gtest.h>

#include <fstream>
#include <iterator>
#include <string>
#include <utility>

#include "cut/hand_sim/hands.h"
#include "kerf/coupled.h"
#include "kerf/simulation.h"
#include "support/saw.h"
#include "test_paths.h"

namespace kerf {
namespace {

std::string ReadSource(const std::string& name) {
  std::ifstream file(KERF_SOURCE_DIR "/" + name);
  return {std::istreambuf_iterator<char>(file), {}};
}

TEST(ApiPage, SnippetCutsInBothWays) {
  const Bone bone = test::MakeBox(Pose{}, {10, 3, 6}, 0.2);
  SimulationParams params;
  CoupledParams coupled_params = test::DiscParams();
  params.tool = coupled_params.tool = kSaw;
  // The tool is in contact at the start of the tick.
  const Pose X_WT_start = test::DiscPose(Pose{}, {0, 0, 3 + kR - 0.01});
  const Pose X_WT = test::DiscPose(Pose{}, {0, 0, 3 + kR - 0.03});
  const Pose X_WH = X_WT;
  // clang-format off
  // begin
  kerf::Simulation simulation(bone, params, X_WT_start);
  kerf::TickOutput out = simulation.Tick({X_WT, 0.001, 7500});  // out.f_T_W_N: force on the tool, N

  kerf::CoupledSimulation coupled(bone, coupled_params, X_WT_start);
  kerf::CoupledOutput output = coupled.Tick({.X_WH = X_WH});  // output.f_H_W_N: force on the hand, N
  // end
  // clang-format on
  EXPECT_GT(out.f_T_W_N.z, 0);  // both are pushed back
  EXPECT_GT(output.f_H_W_N.z, 0);
}

TEST(ApiPage, SnippetMatchesThePage) {
  const std::string source = ReadSource("tests/cut/hand_sim/api_page_test.cpp");
  const std::string begin = "  // begin\n";
  const std::size_t first = source.find(begin) + begin.size();
  std::string snippet = "\n" + source.substr(first, source.find("  // end\n") - first);
  for (std::size_t at = 0; (at = snippet.find("\n  ", at)) != std::string::npos; ++at) snippet.erase(at + 1, 2);
  EXPECT_NE(ReadSource("docs/api.md").find("```cpp" + snippet + "```"), std::string::npos) << snippet;
}

}  // namespace
}  // namespace kerf
