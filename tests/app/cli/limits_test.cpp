// Tests that inputs that are too large are refused with one sentence, before the work begins.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <regex>

#include "support/block_scene.h"
#include "support/program.h"

namespace kerf {
namespace {

using test::ProgramResult;
using testing::HasSubstr;
using testing::MatchesRegex;

const std::string kBlock = test::BlockToml({4, 4, 4}, 0.4);

class Limits : public test::ProgramTest {};

TEST_F(Limits, BoneLargerThanMemoryIsRefused) {
  // The limit of `ulimit -v` counts as the free memory. The sanitizers' own memory would exceed it.
  const char* few = "ulimit -v 4000000;";
  if (KerfWithin(few, "model block --size 4,4,4 -o small.vdb").code != 0) GTEST_SKIP() << "4 GB are too few here";
  const ProgramResult result = KerfWithin(few, "model block --size 800,800,800 --voxel 0.2 -o b.vdb");
  EXPECT_EQ(result.code, 1);
  EXPECT_EQ(result.out, "");
  EXPECT_THAT(result.err, MatchesRegex("kerf: a bone of this size with voxels of 0.2 mm needs more than [0-9.]+ GB of "
                                       "memory and [0-9.]+ GB are free; use larger voxels\n"));
  // The required memory is summed until it exceeds the free memory; the two printed numbers must differ.
  EXPECT_FALSE(std::regex_search(result.err, std::regex("than ([0-9.]+ GB) of memory and \\1 are"))) << result.err;
  EXPECT_FALSE(Exists("b.vdb"));
}

TEST_F(Limits, RunWithTooManyTicksIsRefusedWithItsSize) {
  Write("p.csv", "time_s,x_mm,y_mm,z_mm,qw,qx,qy,qz\n0,0,0,50,1,0,0,0\n30000,1,0,50,1,0,0,0\n");
  Write("s.toml", kBlock + "[path]\nfile = \"p.csv\"\n[simulation]\nrate_hz = 1000\n");
  const ProgramResult result = Kerf("run s.toml -o o");
  EXPECT_EQ(result.code, 1);
  EXPECT_THAT(result.err, MatchesRegex("kerf: 30000000 ticks \\(30000 s at 1000 Hz\\) would need [0-9.]+ GB of memory; "
                                       "a run has at most 20000000 ticks: lower .simulation. rate_hz or make several "
                                       "runs of it\n"));
  EXPECT_FALSE(Exists("o/scene.toml"));
  // The same applies to input that does not fit into memory.
  Write("s.toml", kBlock + "[path]\nfile = \"p.csv\"\n[simulation]\nrate_hz = 500\n");
  const char* few = "ulimit -v 4000000;";
  if (KerfWithin(few, "model block --size 4,4,4 -o small.vdb").code != 0) GTEST_SKIP() << "4 GB are too few here";
  EXPECT_THAT(KerfWithin(few, "run s.toml -o o").err, HasSubstr("kerf: a run of 15000000 ticks needs about "));
}

TEST_F(Limits, ALoopIsAtMostTenHours) {
  Write("s.toml", kBlock);
  EXPECT_EQ(Kerf("loop s.toml --seconds 36001").code, 2);
  EXPECT_THAT(Kerf("loop --help").out, HasSubstr("0.01 to 36000"));
  EXPECT_EQ(Kerf("bench hour s.toml --minutes 601").code, 2);
}

}  // namespace
}  // namespace kerf
