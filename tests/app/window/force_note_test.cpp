// Tests of the sentence below the plot of the force.
#include <gtest/gtest.h>

#include <string>

#include "app/window/live_session.h"
#include "session/scene/scene.h"

namespace kerf {
namespace {

std::string ForceNoteAt(const Tool& tool, const char* law, double bite_um) {
  Scene scene;
  scene.tool.shape = tool;
  scene.force = ForceLaw(law);
  LiveFigures figures;
  figures.coupled.mean_bite_mm = 1e-3 * bite_um;
  return LiveSession::MakeForceNote(scene, figures).text;
}

TEST(ForceNote, SaysNothingWhileNothingIsCut) {
  const Tool tools[] = {DiscSaw{}, BallBurr{}, FissureBur{}, TwistDrill{}, ReciprocatingBlade{}, OscillatingBlade{}};
  for (const Tool& tool : tools) EXPECT_EQ(ForceNoteAt(tool, "two_component", 0), "") << DescribeTool(tool);
}

TEST(ForceNote, ComparesTheBiteOfABladeWithThoseOfTheTests) {
  // The tests are at bites of 2.5 to 10 um.
  EXPECT_EQ(ForceNoteAt(OscillatingBlade{}, "two_component", 0.947),
            "The chips are thinner than in published tests on bone: the force is an estimate.");
  EXPECT_EQ(ForceNoteAt(OscillatingBlade{}, "two_component", 5),
            "The chips are as thick as in published tests on bone.");
  EXPECT_EQ(ForceNoteAt(OscillatingBlade{}, "two_component", 11),
            "The chips are thicker than in published tests on bone: the force is an estimate.");
}

TEST(ForceNote, SaysWhatIsKnownOfDrillsAndBurs) {
  EXPECT_EQ(ForceNoteAt(TwistDrill{}, "two_component", 15),
            "The force of drills is about half of the thrust measured on bone: it is an estimate.");
  EXPECT_EQ(ForceNoteAt(TwistDrill{}, "hertz_chip", 15), "The force of drills is an estimate.");
  EXPECT_EQ(ForceNoteAt(FissureBur{}, "two_component", 5),
            "The force of burs has not been compared with tests on bone: it is an estimate.");
}

TEST(ForceNote, NamesThePullOfAGuide) {
  LiveFigures figures;
  figures.guide_force_N = 1;
  EXPECT_EQ(LiveSession::MakeForceNote(Scene{}, figures).text,
            "The saw touches no bone: the force is the pull of the guide.");
}

}  // namespace
}  // namespace kerf
