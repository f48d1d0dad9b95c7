#include "app/window/stroke_watch.h"

#include <gtest/gtest.h>

namespace kerf {
namespace {

enum class Does { kCuts, kTouches, kNothing };

/// Runs ticks and returns the number of strokes that have ended.
int CountEnds(StrokeWatch& watch, int ticks, Does does, bool held = true, bool stands = false) {
  int ended = 0;
  for (int i = 0; i < ticks; ++i) {
    LoopTick tick;
    tick.held = held;
    tick.stands = stands;
    tick.coupled.removed_mm3 = does == Does::kCuts ? 0.01 : 0;
    if (does != Does::kNothing) tick.coupled.f_cut_W_N = {0, 0, 1};
    ended += watch.Take(tick) ? 1 : 0;
  }
  return ended;
}

TEST(StrokeWatch, EndsOnceWhenTheSawIsClearOfTheBone) {
  StrokeWatch watch;
  EXPECT_EQ(CountEnds(watch, 1000, Does::kNothing), 0) << "nothing was cut";
  EXPECT_EQ(CountEnds(watch, 1000, Does::kTouches), 0);
  EXPECT_EQ(CountEnds(watch, 500, Does::kCuts), 0);
  EXPECT_EQ(CountEnds(watch, StrokeWatch::kEnd_ticks - 1, Does::kNothing), 0) << "it only bounces";
  EXPECT_EQ(CountEnds(watch, 500, Does::kCuts), 0);
  EXPECT_EQ(CountEnds(watch, 1000, Does::kTouches), 0) << "a held saw that rests in its kerf goes on";
  EXPECT_EQ(CountEnds(watch, 2000, Does::kNothing), 1);
}

TEST(StrokeWatch, EndsWhenTheHandTakesTheSawAgain) {
  StrokeWatch watch;
  EXPECT_EQ(CountEnds(watch, 500, Does::kCuts), 0);
  EXPECT_EQ(CountEnds(watch, 50, Does::kTouches, false), 0) << "as between two keys";
  EXPECT_EQ(CountEnds(watch, 500, Does::kCuts), 0);
  EXPECT_EQ(CountEnds(watch, 500, Does::kTouches, false), 0);
  EXPECT_EQ(CountEnds(watch, 1, Does::kCuts, false), 0) << "the blade creeps on";
  EXPECT_EQ(CountEnds(watch, 2000, Does::kTouches, false), 0);
  EXPECT_EQ(CountEnds(watch, 2000, Does::kTouches), 1) << "what it cut meanwhile belongs to the stroke";
  EXPECT_EQ(CountEnds(watch, 500, Does::kCuts), 0);
  EXPECT_EQ(CountEnds(watch, 2000, Does::kNothing, false), 1) << "clear of the bone, as after it was taken out";
}

// The step that is undone is none: a checkpoint after it would make redo impossible.
TEST(StrokeWatch, ForgetsWhatIsUndone) {
  StrokeWatch watch;
  EXPECT_EQ(CountEnds(watch, 500, Does::kCuts), 0);
  EXPECT_EQ(CountEnds(watch, 10, Does::kNothing, true, true), 0);
  EXPECT_EQ(CountEnds(watch, 2000, Does::kNothing), 0);
}

}  // namespace
}  // namespace kerf
