// Tests that the resolved scene is equivalent, that the default scene is valid, and that damage never crashes the
// reader.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <random>

#include "scene_text.h"
#include "session/scene/path.h"
#include "session/scene/plan_section.h"
#include "session/scene/schema.h"
#include "support/folder.h"
#include "support/message_of.h"

namespace kerf {
namespace {

/// Assigns each field of a description a random valid value, so that a missing key cannot be hidden by its default.
class Randomizer {
 public:
  explicit Randomizer(std::mt19937& random) : random_(random) {}
  void operator()(const char*, double& value, Range range, const char*) { value = Draw(range); }
  void operator()(const char*, int& value, Range range, const char*) {
    value = static_cast<int>(std::floor(Draw({range.lower, std::min(range.upper, 1e6)})));
  }
  void operator()(const char*, bool& value, const char*) { value = random_() % 2 == 0; }
  void operator()(const char*, Vec3& value, Range range, const char*) {
    value = {Draw(range), Draw(range), Draw(range)};
  }
  void operator()(const char*, Quat& value, const char*) {
    value = glm::normalize(Quat(Draw({-1, 1}), Draw({-1, 1}), Draw({-1, 1}), Draw({0.1, 1})));
  }
  void operator()(const char*, std::string& value, TextLimit, const char*) {
    value = fmt::format("name \"{}\"", ++names_);
  }
  void operator()(const char*, std::string& value, const Choices& choices, const char*) {
    value = std::string(choices.words[random_() % choices.words.size()]);
  }

 private:
  double Draw(Range range) { return std::uniform_real_distribution<double>(range.lower, range.upper)(random_); }
  std::mt19937& random_;
  int names_ = 0;
};

/// Prints all values of a description as text, with all digits.
class Printer {
 public:
  void operator()(const char* key, double& value, Range, const char*) { text += fmt::format("{} {:a}\n", key, value); }
  void operator()(const char* key, int& value, Range, const char*) { text += fmt::format("{} {}\n", key, value); }
  void operator()(const char* key, bool& value, const char*) { text += fmt::format("{} {}\n", key, value); }
  void operator()(const char* key, Vec3& v, Range, const char*) {
    text += fmt::format("{} {:a} {:a} {:a}\n", key, v.x, v.y, v.z);
  }
  void operator()(const char* key, Quat& q, const char*) {
    text += fmt::format("{} {:a} {:a} {:a} {:a}\n", key, q.w, q.x, q.y, q.z);
  }
  void operator()(const char* key, std::string& value, const Choices&, const char*) {
    text += fmt::format("{} {}\n", key, value);
  }
  void operator()(const char* key, std::string& value, TextLimit, const char*) {
    text += fmt::format("{} {}\n", key, value);
  }
  std::string text;
};

std::string Print(Scene scene) {
  Printer printer;
  printer.text = fmt::format("{}\n{}\n{}\n{}\n{}\n", scene.title, static_cast<int>(scene.bone.source), scene.bone.file,
                             scene.bone.materials, scene.path.file);
  if (scene.bone.source == BoneSource::kBlock || scene.bone.source == BoneSource::kPlate) {
    Describe(scene.bone.block, printer);
    for (MaterialLayer& layer : scene.bone.block.layers) Describe(layer, printer);
  }
  if (scene.bone.source == BoneSource::kMandible) Describe(scene.bone.mandible, printer);
  DescribeMaterialKind(scene.material, printer);
  if (scene.material.kind == MaterialKind::kUniform) DescribeUniform(scene.material, printer);
  if (scene.material.kind == MaterialKind::kCt) {
    DescribeCt(scene.material, printer);
    printer.text +=
        fmt::format("{}\n{}\n{}\n", scene.material.ct_law, scene.material.ct_law_file, scene.material.ct_calibration);
  }
  Describe(scene.tool, printer);
  for (SceneStroke& stroke : scene.path.strokes) Describe(stroke, printer);
  Describe(scene.force, printer);
  Describe(scene.simulation, printer);
  if (scene.slab.given || scene.simulation.mode == SceneMode::kSlab) Describe(scene.slab, printer);
  Describe(scene.output, printer);
  for (PlannedPlane& plane : scene.plan.planes) Describe(plane, printer);
  for (DepthStop& stop : scene.plan.stops) Describe(stop, printer);
  // For a section that the file omits, the defaults apply.
  if (scene.coupling.given) Describe(scene.coupling, printer);
  if (scene.device.given) {
    Describe(scene.device, printer);
    printer.text += fmt::format("{}\n{}\n", scene.device.profile, scene.device.file);
  }
  if (scene.hand.given) Describe(scene.hand, printer);
  if (scene.loop.given) Describe(scene.loop, printer);
  if (scene.exercise.given) Describe(scene.exercise, printer);
  return printer.text;
}

Scene RandomScene(std::mt19937& random) {
  Randomizer randomize(random);
  Scene scene;
  scene.title = "a \"title\" with \\ and \xc3\xa9";
  scene.bone.source = static_cast<BoneSource>(random() % 4);
  if (scene.bone.source == BoneSource::kFile) scene.bone.file = "/a/b \"c\"/d.vdb";
  if (random() % 2 == 0) scene.bone.materials = "/a/t.csv";
  Describe(scene.bone.block, randomize);
  Describe(scene.bone.mandible, randomize);
  scene.bone.block.layers.resize(random() % 4);
  // A plate has default layers, which remain if the file gives none.
  if (scene.bone.source == BoneSource::kPlate && scene.bone.block.layers.empty()) scene.bone.block.layers.resize(1);
  for (MaterialLayer& layer : scene.bone.block.layers) Describe(layer, randomize);
  DescribeMaterialKind(scene.material, randomize);
  if (scene.material.kind == MaterialKind::kCt) scene.bone.source = BoneSource::kFile;
  if (scene.bone.source == BoneSource::kFile) scene.bone.file = "/a/b \"c\"/d.vdb";
  DescribeUniform(scene.material, randomize);
  DescribeCt(scene.material, randomize);
  if (random() % 2 == 0) scene.material.osteon_direction = Vec3(1, -2, 0.5);
  scene.material.ct_law = random() % 2 == 0 ? "morgan_2003_tibia" : "mandible_matmap";
  if (random() % 2 == 0) scene.material.ct_law_file = "/a/laws.csv";
  if (random() % 2 == 0) scene.material.ct_calibration = "0:0.1 1000:1.2";
  do {  // a bur or drill that is shorter than its own tip is drawn again
    Describe(scene.tool, randomize);
  } while (!test::MessageOf([&] { Validate(scene.tool.shape); }).empty());
  scene.path.strokes.resize(1 + random() % 4);
  for (std::size_t i = 0; i < scene.path.strokes.size(); ++i) {
    SceneStroke& stroke = scene.path.strokes[i];
    Describe(stroke, randomize);
    stroke.feed_mm_per_s += 900;  // keeps the duration within bounds
    stroke.feed_mm_per_s = std::min(stroke.feed_mm_per_s, 1000.0);
    if (i == 0) stroke.retract = true;
    if (!stroke.retract) {
      stroke.start_mm = scene.path.strokes[i - 1].end_mm;
      stroke.disc_normal = scene.path.strokes[i - 1].disc_normal;
    }
  }
  Describe(scene.force, randomize);
  Describe(scene.simulation, randomize);
  scene.slab.given = random() % 2 == 0;
  Describe(scene.slab, randomize);
  if (!scene.slab.params.segments_move) scene.slab.hold = SlabBody::kSlice;
  if (!std::holds_alternative<DiscSaw>(scene.tool.shape)) {  // slab mode requires a disc
    scene.slab.given = false;
    scene.simulation.mode = SceneMode::kVoxel;
  }
  Describe(scene.output, randomize);
  scene.plan.planes.resize(random() % 3);
  for (PlannedPlane& plane : scene.plan.planes) {
    Describe(plane, randomize);
    plane.plane.normal_W = glm::normalize(plane.plane.normal_W);
    plane.up_W = glm::normalize(plane.up_W);
  }
  scene.plan.stops.resize(random() % 3);
  for (DepthStop& stop : scene.plan.stops) {
    Describe(stop, randomize);
    stop.direction_W = glm::normalize(stop.direction_W);
  }
  scene.coupling.given = random() % 2 == 0;
  Describe(scene.coupling, randomize);
  scene.device.given = random() % 2 == 0;
  Describe(scene.device, randomize);
  scene.device.profile = random() % 2 == 0 ? "touch" : "omega_6";
  if (random() % 2 == 0) scene.device.file = "/a/profiles.csv";
  scene.hand.given = random() % 2 == 0;
  Describe(scene.hand, randomize);
  scene.loop.given = random() % 2 == 0;
  Describe(scene.loop, randomize);
  scene.exercise.given = random() % 2 == 0;
  Describe(scene.exercise, randomize);
  if (GetForm(scene.tool.shape) != ToolForm::kRound && scene.exercise.kind == ExerciseKind::kDrillHoles) {
    scene.exercise.kind = ExerciseKind::kOsteotomy;
  }
  if (std::holds_alternative<TwistDrill>(scene.tool.shape)) {
    scene.exercise.kind = ExerciseKind::kDrillHoles;
  }
  if (scene.exercise.kind == ExerciseKind::kDrillHoles) scene.exercise.end_mm = SceneExercise{}.end_mm;  // not a key
  if (GetDrive(scene.tool.shape) == DriveMotion::kStroke) {  // these require a tool that turns
    scene.exercise.given = false;
    scene.plan = {};
  }
  return scene;
}

TEST(ResolvedScene, ReadsBackAsTheSameScene) {
  std::mt19937 random(1);
  for (int i = 0; i < 300; ++i) {
    const Scene scene = RandomScene(random);
    const std::string text = ResolvedToml(scene);
    ASSERT_EQ(test::MessageFor(text), "") << text;
    const Scene again = ParseScene(text, "s.toml");
    ASSERT_EQ(Print(scene), Print(again)) << text;
    ASSERT_EQ(ResolvedToml(again), text);
  }
}

// The scene of a result folder must be readable: it must not contain the ratios that such a law makes an error.
TEST(ResolvedScene, LawWithItsOwnCuttingForceAndTableReadsBack) {
  const test::Folder folder;
  const std::string table = folder.file("forces.csv");
  test::WriteBytes(
      table, "tissue,bite_um,thrust_N_per_mm,cutting_N_per_mm,source\ncortical,1,4,3,test\ncortical,2,5,3,test\n");
  for (const std::string& law :
       {std::string("law = \"two_component\"\n"), "law = \"tabulated\"\nfile = \"" + table + "\"\n"}) {
    const Scene scene = ParseScene(test::ShortScene() +
                                       "[material]\nosteon_direction = [0, 3, 4]\n[effects.tangential_force]\n"
                                       "[effects.tooth_vibration]\n[force]\n" +
                                       law,
                                   "s.toml");
    const std::string text = ResolvedToml(scene);
    ASSERT_EQ(test::MessageFor(text), "") << text;
    const Scene again = ParseScene(text, "s.toml");
    EXPECT_EQ(ResolvedToml(again), text);
    EXPECT_EQ(again.material.osteon_direction, Vec3(0, 3, 4));
    EXPECT_EQ(text.find(table), std::string::npos) << "the scene must not depend on the file";
    EXPECT_EQ(again.force.table() != nullptr, law.find("tabulated") != std::string::npos);
    if (again.force.table() != nullptr) {
      EXPECT_EQ(again.force.table()->rows()[0][1].thrust_N_per_mm, 5);
    }
  }
}

TEST(ResolvedScene, StatesUnitAndRangeOfEveryNumber) {
  const std::string text = ResolvedToml(ParseScene(test::ShortScene(), "s.toml"));
  EXPECT_NE(text.find("diameter_mm = 22.0                  # diameter of the disc over the teeth [1 to 200 mm]\n"),
            std::string::npos)
      << text;
  EXPECT_NE(text.find("feed_mm_per_s = 3.0                 # feed rate of the tool's origin [0.001 to 1000 mm/s]\n"),
            std::string::npos)
      << text;
}

TEST(ResolvedScene, OmitsHandSectionsThatTheSceneOmits) {
  const std::string text = ResolvedToml(ParseScene(test::ShortScene(), "s.toml"));
  for (const char* section : {"[coupling]", "[device]", "[hand]", "[loop]", "[exercise]"}) {
    EXPECT_EQ(text.find(section), std::string::npos) << section;
  }
}

TEST(DefaultScene, IsValid) {
  const std::string text = DefaultSceneToml();
  ASSERT_EQ(test::MessageFor(text), "");
  const Scene scene = ParseScene(text, "s.toml");
  EXPECT_GT(MakePath(scene).duration_s(), 0);
}

TEST(DefaultScene, NamesEveryKey) {
  const std::string text = DefaultSceneToml();
  for (const char* key : {"file = \"bone.vdb\"",
                          "materials = \"table.csv\"",
                          "[bone.mandible]",
                          "[bone.block]",
                          "[bone.plate]",
                          "[[bone.block.layer]]",
                          "file = \"path.csv\"",
                          "kind = \"regions\"",
                          "kind = \"uniform\"",
                          "kind = \"ct\"",
                          "E_GPa = ",
                          "nu = ",
                          "ct_law = ",
                          "ct_law_file = ",
                          "ct_calibration = ",
                          "ct_applies_to = ",
                          "dwell_s = ",
                          "retract = ",
                          "law = ",
                          "rate_hz = ",
                          "forces_every_ticks = ",
                          "[[plan.plane]]",
                          "margin_mm = ",
                          "[[plan.stop]]",
                          "[coupling]",
                          "stiffness_N_per_mm = ",
                          "[device]",
                          "profile = \"omega_6\"",
                          "[hand]",
                          "model = \"H3\"",
                          "[loop]",
                          "watchdog_ms = "}) {
    EXPECT_NE(text.find(key), std::string::npos) << key;
  }
  for (const ForceLawInfo* law : ForceLaws()) {
    EXPECT_NE(text.find(fmt::format("law = \"{}\"", law->name)), std::string::npos) << law->name;
    for (const LawParameter& p : law->parameters) {
      EXPECT_NE(text.find(fmt::format("{} = ", p.key)), std::string::npos) << p.key;
    }
  }
}

TEST(SceneReader, DamagedFilesLoadOrReportThePosition) {
  std::mt19937 random(5);
  const std::string good = ResolvedToml(RandomScene(random));
  ASSERT_EQ(test::MessageFor(good), "");
  int refused = 0;
  for (int i = 0; i < 6000; ++i) {
    std::string text = good;
    for (int k = 0; k < 1 + i % 4; ++k) {
      const std::size_t at = random() % text.size();
      switch (random() % 4) {
        case 0:
          text[at] = static_cast<char>(random() % 256);
          break;
        case 1:
          text[at] = "[]{}\"'=.#,\n\\-+0"[random() % 15];
          break;
        case 2:
          text.erase(at, random() % 40);
          break;
        default:
          text.insert(at, text.substr(random() % text.size(), random() % 40));
      }
      if (text.empty()) break;
    }
    const std::string message = test::MessageFor(text);
    if (message.empty()) continue;
    ++refused;
    // Each line is file:line:column: text, or the number of faults that are not shown.
    EXPECT_EQ(message.rfind("s.toml:", 0), 0U) << message;
    EXPECT_NE(message[7], '0') << message;
  }
  EXPECT_GT(refused, 3000);
}

}  // namespace
}  // namespace kerf
