// Tests of the alarms of a bone's own structures.
#include "app/window/nerve_alarm.h"

#include <gtest/gtest.h>

#include "app/window/injury_texts.h"
#include "support/chunks.h"

namespace kerf {
namespace {

TEST(ToothAlarm, IsANoticeNearATooth) {
  const auto tooth = test::MakeCube({0, 0, 0}, 2);
  const Tool tool = DiscSaw{.diameter_mm = 20, .thickness_mm = 0.5};
  // The blade's plane is x-y. Its centre is above a corner of the cube, at z = 1.
  const auto at = [&](double distance_mm) { return Pose{{1, 0, 0, 0}, {0, 0, 1 + 0.25 + distance_mm}}; };
  EXPECT_FALSE(MakeToothAlarm(*tooth, false, tool, at(1.1)));
  const auto near = MakeToothAlarm(*tooth, false, tool, at(0.6));
  ASSERT_TRUE(near);
  EXPECT_EQ(near->level, AlarmLevel::kNotice);
  EXPECT_EQ(near->label, "tooth: 0.6 mm");
  EXPECT_NEAR(near->p_W.z, 1, 1e-12);
}

TEST(ToothAlarm, IsADangerWhileAToothIsCut) {
  const auto tooth = test::MakeCube({0, 0, 0}, 2);
  const Tool tool = DiscSaw{.diameter_mm = 20, .thickness_mm = 0.5};
  const auto cut = MakeToothAlarm(*tooth, true, tool, {{1, 0, 0, 0}, {0, 0, 0.9}});
  ASSERT_TRUE(cut);
  EXPECT_EQ(cut->level, AlarmLevel::kDanger);
  EXPECT_EQ(cut->label, "the blade cuts a tooth");
  EXPECT_FALSE(MakeToothAlarm({}, true, tool, {})) << "a bone without teeth";
}

TEST(Injuries, AreNamedWithVolumeAndPlace) {
  StructureResult nerve{.kind = MarkKind::kCanal,
                        .side = BodySide::kLeft,
                        .is_cut = true,
                        .removed_mm3 = 4.23,
                        .p_W = {25.14, -3.2, -8.93}};
  EXPECT_EQ(DescribeInjury(nerve),
            "Canal of the nerve, patient's left: injured. 4.2 mm³ removed at 25.1 mm left, 3.2 mm front, 8.9 mm down.");
  nerve.is_severed = true;
  const StructureResult tooth{.kind = MarkKind::kTooth,
                              .side = BodySide::kRight,
                              .number = 3,
                              .is_cut = true,
                              .removed_mm3 = 0.04,
                              .p_W = {-8, 2, 1}};
  EXPECT_EQ(DescribeInjury(tooth),
            "Tooth 3 from the middle, patient's right: cut. Less than 0.1 mm³ removed at 8.0 mm right, 2.0 mm back, "
            "1.0 mm up.");
  StructureResult numbered = tooth;
  numbered.fdi = 43;
  EXPECT_EQ(DescribeInjury(numbered).substr(0, 14), "Tooth 43: cut.");
  const StructureResult lesion{.kind = MarkKind::kLesion, .is_cut = true, .removed_mm3 = 2};
  EXPECT_EQ(DescribeInjury(lesion).substr(0, 12), "Lesion: cut.");
  HudState hud;
  ShowInjuries({tooth, nerve}, hud);
  ASSERT_EQ(hud.injuries.size(), 2u);
  EXPECT_EQ(hud.injuries[1].substr(0, 44), "Canal of the nerve, patient's left: severed.");
  EXPECT_EQ(hud.values.nerve_injury, "severed");
  EXPECT_EQ(hud.values.teeth_injury, "cut");
  // With many, the rest is counted.
  HudState many;
  ShowInjuries(std::vector<StructureResult>(6, tooth), many);
  ASSERT_EQ(many.injuries.size(), 4u);
  EXPECT_EQ(many.injuries[3], "3 more structures are injured.");
  EXPECT_TRUE(many.values.nerve_injury.empty());
}

}  // namespace
}  // namespace kerf
