#include "app/window/case_sessions.h"

#include <gtest/gtest.h>

namespace kerf {
namespace {

TEST(MakeProjectSession, KeepsTheLargestForceOfALongSession) {
  LiveFigures figures;
  figures.time_s = 120;
  figures.removed_mm3 = 7.5;
  std::vector<PlotPoint> forces;
  for (int i = 0; i < 6000; ++i) forces.push_back({0.02 * i, i == 4321 ? 3.5 : 1});
  const ProjectSession session = MakeProjectSession("fine disc", figures, forces);
  EXPECT_EQ(session.saw, "fine disc");
  EXPECT_EQ(session.duration_s, 120);
  EXPECT_EQ(session.removed_mm3, 7.5);
  EXPECT_EQ(session.largest_force_N, 3.5);
  ASSERT_EQ(session.forces_sN.size(), 1000u);
  const std::pair<double, double> peak{0.02 * 4321, 3.5};
  EXPECT_EQ(session.forces_sN[720], peak);  // the part with points 4320 to 4325
}

TEST(JoinSessions, AddsTimesAndTakesTheLargestForce) {
  const JoinedSessions joined = JoinSessions({{"disc", 10, 2, 1.5, {{0, 0.5}, {4, 1.5}}, true, 1.25, 1.5, 4},
                                              {"burr", 20, 3, 0.5, {{1, 0.5}}, true, 0.5, 0.25, 6},
                                              {"disc", 5, 0, 0, {}, true, 0, 0, 0}});
  EXPECT_EQ(joined.saws, (std::vector<std::string>{"disc", "burr"}));
  EXPECT_EQ(joined.duration_s, 35);
  EXPECT_EQ(joined.in_bone_s, 10);
  EXPECT_EQ(joined.turning_force_N, 1.25);
  EXPECT_EQ(joined.stopped_force_N, 1.5);
  const std::vector<std::pair<double, double>> curve{{0, 0.5}, {4, 1.5}, {11, 0.5}};
  EXPECT_EQ(joined.forces_sN, curve);
}

TEST(JoinSessions, KeepsTheFirstPlaceOfTheHolderInTheBone) {
  HolderPlaces places;
  places.hub_W = Vec3{1, 2, 3};
  const ProjectSession second = MakeProjectSession("disc", {}, {}, places);
  places.hub_W = Vec3{7, 8, 9};
  places.handpiece_W = Vec3{4, 5, 6};
  const JoinedSessions joined = JoinSessions({{"disc"}, second, MakeProjectSession("disc", {}, {}, places)});
  EXPECT_EQ(joined.holder.hub_W, Vec3(1, 2, 3));
  EXPECT_EQ(joined.holder.handpiece_W, Vec3(4, 5, 6));
}

TEST(JoinSessions, DoNotClaimWhatIsNotKnown) {
  // Files of earlier versions have recordings, but no figures.
  Project project;
  project.recordings = {"a.kerf", "b.kerf"};
  std::vector<ProjectSession> sessions = ListSessions(project);
  ASSERT_EQ(sessions.size(), 2u);
  sessions.push_back({"disc", 10, 0, 0, {{0, 0}}});
  const JoinedSessions joined = JoinSessions(sessions);
  EXPECT_EQ(joined.saws, std::vector<std::string>{"disc"});
  EXPECT_FALSE(joined.duration_s);
  EXPECT_FALSE(joined.turning_force_N);
  EXPECT_FALSE(joined.in_bone_s);
  project.sessions = {sessions[2], sessions[2]};
  EXPECT_EQ(ListSessions(project), project.sessions);
}

}  // namespace
}  // namespace kerf
