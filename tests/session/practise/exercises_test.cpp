// Tests of the built-in exercises.
#include "session/practise/exercises.h"

#include <gtest/gtest.h>

#include <cmath>
#include <glm/geometric.hpp>
#include <set>
#include <span>

#include "base/files/files.h"
#include "kerf/error.h"
#include "kerf/models.h"
#include "session/scene/path.h"
#include "session/scene/warnings.h"
#include "session/score/region_distance.h"
#include "test_paths.h"

namespace kerf {
namespace {

TEST(Exercises, AreTheFilesOfTheFolderFromEasyToHard) {
  std::set<std::string> ids;
  std::set<ExerciseKind> kinds;
  int difficulty = 0;
  for (const Exercise& exercise : ListExercises()) {
    EXPECT_EQ(exercise.difficulty, ++difficulty);
    EXPECT_EQ(exercise.toml, ReadTextFile(std::string(KERF_SOURCE_DIR) + "/scenes/practise/" + exercise.file));
    EXPECT_TRUE(ids.insert(exercise.id).second);
    EXPECT_EQ(exercise.goal.back(), '.');
    kinds.insert(MakeExerciseScene(exercise.id, 1).exercise.kind);
    EXPECT_EQ(FindExerciseOf(MakeExerciseScene(exercise.id, 1).name), &exercise);
  }
  kinds.insert(ExerciseKind::kDrillHoles);  // only among the procedures
  EXPECT_EQ(kinds.size(), kExerciseKindWords.size());
  EXPECT_THROW(FindExercise("juggling"), Error);
  EXPECT_EQ(FindExerciseOf("body_osteotomy"), nullptr);
}

TEST(ListProcedures, AreTheFilesOfTheirFolder) {
  std::set<ExerciseKind> kinds;
  const std::string folder = std::string(KERF_SOURCE_DIR) + "/scenes/procedures/";
  for (const Exercise& procedure : ListProcedures()) {
    EXPECT_EQ(procedure.toml, ReadTextFile(folder + procedure.file));
    EXPECT_EQ(procedure.id + ".toml", procedure.file);
    EXPECT_EQ(procedure.difficulty, 0);
    EXPECT_EQ(procedure.goal.back(), '.');
    EXPECT_EQ(&FindExercise(procedure.id), &procedure);
    EXPECT_EQ(FindExerciseOf(procedure.id), &procedure);
    // A file of the same name is the same exercise, so that its attempts count for it.
    const Exercise read = ReadExercise(folder + procedure.file);
    EXPECT_EQ(read.id, procedure.id);
    EXPECT_EQ(read.goal, procedure.goal);
    EXPECT_EQ(read.file, folder + procedure.file);
    kinds.insert(MakeExerciseScene(read, 2).exercise.kind);
  }
  EXPECT_TRUE(kinds.contains(ExerciseKind::kDrillHoles));
  EXPECT_EQ(FindExercise("plate_holes").goal.substr(0, 13), "Drill 4 holes");
  EXPECT_EQ(FindExercise("genioplasty").goal.substr(0, 24), "Make the 3 planned cuts,");
}

TEST(Exercises, OpenFromAFileOrByTheirId) {
  EXPECT_EQ(OpenExercise("groove").id, "groove");
  EXPECT_EQ(OpenExercise(std::string(KERF_SOURCE_DIR) + "/scenes/practise/01_groove.toml").id, "groove");
  EXPECT_THROW(OpenExercise("juggling"), Error);
  try {
    OpenExercise(std::string(KERF_SOURCE_DIR) + "/scenes/ball_slot.toml");
    FAIL() << "it has no [exercise]";
  } catch (const Error& e) {
    EXPECT_NE(std::string(e.what()).find("ball_slot.toml: is not an exercise"), std::string::npos) << e.what();
  }
}

TEST(Exercises, PathsAreTheWantedCuts) {
  for (const Exercise& exercise : ListExercises()) {
    const Scene scene = MakeExerciseScene(exercise.id, 1);
    const WantedCut cut = MakeWantedCut(scene.exercise, MakeTool(scene));
    const Path path = MakePath(scene);
    // A disc goes down, along and up. A blade with a stroke plunges.
    const std::size_t places = cut.plunges > 1 ? static_cast<std::size_t>(cut.plunges) : 2;
    ASSERT_EQ(path.segments().size(), cut.plunges > 1 ? places : 3) << exercise.id;
    for (std::size_t i = 0; i < places; ++i) {
      const double s_mm = cut.length_mm * static_cast<double>(i) / static_cast<double>(places - 1);
      const Vec3 p_W = path.CalcPose(i, path.segments()[i].end_s).p_AB;
      // The files' coordinates are rounded to 0.01 mm and directions to 0.001, over lengths of up to 40 mm.
      EXPECT_LT(glm::distance(p_W, cut.CalcToolPose(s_mm, cut.depth_mm).p_AB), 0.08) << exercise.id;
    }
    const Vec3 n = path.CalcPose(0, 0).Vector({0, 0, 1});
    EXPECT_NEAR(std::abs(glm::dot(n, cut.across_W)), 1, 1e-5) << exercise.id;
    EXPECT_TRUE(FindToolWarnings(scene, 0.2).empty()) << exercise.id;
  }
}

// What the exercise's text says about its plane.
TEST(Exercises, PlaneOfTheOsteotomyCrossesAMolarAndTheNerveCanal) {
  const Scene scene = MakeExerciseScene("osteotomy", 1);
  MandibleParams params = scene.bone.mandible;
  params.voxel_mm = 1;  // the crossed part of the molar is 10 mm high
  const Bone bone = MakeMandible(params);
  const WantedCut cut = MakeWantedCut(scene.exercise, MakeTool(scene));
  int tooth = 0;
  int canal = 0;
  for (double s_mm = 0; s_mm <= cut.length_mm; s_mm += 0.25) {
    for (double depth_mm = -5; depth_mm <= cut.depth_mm; depth_mm += 0.25) {
      const Vec3 p_W = cut.ToWorld({s_mm, depth_mm, 0});
      if (bone.SignedDistance(p_W) >= 0) continue;
      const int region = bone.RegionAt(p_W);
      if (region == 0) continue;
      const Tissue tissue = bone.materials().At(region).tissue;
      tooth += tissue == Tissue::kTooth ? 1 : 0;
      canal += tissue == Tissue::kCanal ? 1 : 0;
    }
  }
  EXPECT_GT(tooth, 50) << "of 0.06 mm² each";
  EXPECT_GT(canal, 20) << "of 0.06 mm² each";
  EXPECT_NE(FindExercise("osteotomy").goal.find("The plane crosses a molar and the nerve canal"), std::string::npos);
}

// What the text of the mandibulotomy says: its plane is between the roots of the incisors, and far from the canals.
TEST(Exercises, PlaneOfTheMandibulotomySparesTeethAndTheNerveCanal) {
  const Scene scene = MakeExerciseScene("mandibulotomy", 1);
  MandibleParams params = scene.bone.mandible;
  const Bone bone = MakeMandible(params);
  const WantedCut cut = MakeWantedCut(scene.exercise, MakeTool(scene));
  // The mental foramina are 24.6 mm from the midline (docs/mandible.md); the canals end there.
  EXPECT_GT(RegionDistance(bone, Tissue::kCanal).CalcFrom(std::span(&cut, 1)), 15);
  EXPECT_GT(RegionDistance(bone, Tissue::kTooth).CalcFrom(std::span(&cut, 1)), 0);
  EXPECT_LT(RegionDistance(bone, Tissue::kCancellous).CalcFrom(std::span(&cut, 1)), 0);
}

// Attempts at the exercise as its scene was named before count for it.
TEST(Exercises, RecordingsOfTheOsteotomyKeepTheirName) {
  EXPECT_EQ(FindExerciseOf("06_osteotomy"), &FindExercise("osteotomy"));
}

TEST(MakeLevel, RemovesOneAidPerLevel) {
  int before = 5;
  for (int level = 1; level <= kLevels; ++level) {
    const SceneExercise e = MakeExerciseScene("groove", level).exercise;
    EXPECT_EQ(e.level, level);
    const int aids = (e.gauge ? 1 : 0) + (e.colour ? 1 : 0) + (e.sound ? 1 : 0) + (e.depth_stop ? 1 : 0);
    EXPECT_EQ(aids, before - 1);
    before = aids;
  }
  EXPECT_EQ(before, 0);
  EXPECT_THROW(MakeExerciseScene("groove", 0), Error);
  EXPECT_THROW(MakeExerciseScene("groove", 6), Error);
  Scene none = MakeExerciseScene("groove", 1);
  none.exercise.given = false;
  EXPECT_THROW(MakeLevel(none, 1), Error);
}

}  // namespace
}  // namespace kerf
