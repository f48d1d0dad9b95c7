// Tests of whether a cut must still be saved.
#include "app/window/unsaved_cut.h"

#include <gtest/gtest.h>

namespace kerf {
namespace {

TEST(UnsavedCut, IsSetByChangesAfterTheLastSaving) {
  UnsavedCut cut;
  cut.Follow(0);
  EXPECT_FALSE(cut.is_unsaved());
  cut.Follow(3);
  EXPECT_TRUE(cut.is_unsaved());
  cut.set_unsaved(false);
  cut.Follow(3);
  EXPECT_FALSE(cut.is_unsaved()) << "nothing was cut after it was saved";
  cut.Follow(4);
  EXPECT_TRUE(cut.is_unsaved());
}

TEST(UnsavedCut, KeepsTheCutsOfEarlierSessions) {
  UnsavedCut cut;
  cut.Follow(5);
  cut.Follow(0);  // the next session begins
  EXPECT_TRUE(cut.is_unsaved());
  cut.set_unsaved(false);
  cut.Follow(0);
  EXPECT_FALSE(cut.is_unsaved());
  cut.Follow(2);
  EXPECT_TRUE(cut.is_unsaved()) << "fewer changes than in the session before";
}

}  // namespace
}  // namespace kerf
