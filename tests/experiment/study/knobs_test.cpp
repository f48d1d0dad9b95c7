#include "experiment/study/knobs.h"

#include <gtest/gtest.h>

#include "kerf/error.h"

namespace kerf {
namespace {

TEST(Knobs, UnknownKnobIsReportedWithTheMostSimilarOne) {
  try {
    FindKnob("voxel_m");
    FAIL();
  } catch (const Error& error) {
    EXPECT_NE(std::string(error.what()).find("voxel_mm"), std::string::npos) << error.what();
  }
}

}  // namespace
}  // namespace kerf
