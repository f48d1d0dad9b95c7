#include "experiment/study/study_file.h"

#include <gmock/gmock.h>

#include <fstream>
#include <nlohmann/json.hpp>
#include <random>

#include "base/files/files.h"
#include "bone/import/import.h"
#include "bone/models/block.h"
#include "bone/models/mandible.h"
#include "experiment/study/case_run.h"
#include "experiment/study/plan.h"
#include "experiment/study/settings.h"
#include "kerf/coupled.h"
#include "kerf/error.h"
#include "kerf/simulation.h"
#include "session/scene/scene.h"
#include "support/folder.h"
#include "support/seeded_check.h"
#include "test_paths.h"

namespace kerf {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

const std::vector<std::string> kStudyFilePaths{"entry", "slot", "plunge", "mandible"};

StudySpec Parse(const std::string& text) {
  return ParseStudy(text, "study.toml", kStudyFilePaths);
}

std::string Fault(const std::string& text) {
  return test::MessageOf([&] { Parse(text); });
}

TEST(StudyFile, EmptyFileIsTheBaseSettingsOnAllPaths) {
  const StudySpec spec = Parse("");
  EXPECT_EQ(spec.name, "study");
  EXPECT_EQ(spec.paths, kStudyFilePaths);
  EXPECT_THAT(spec.holdings, ElementsAre(Holding::kHand, Holding::kPath));
  EXPECT_EQ(ShowSettings(spec.base), ShowSettings(StudySettings{}));
  // These are the defaults of a scene and of a model.
  EXPECT_EQ(spec.base.voxel_mm, BlockParams{}.voxel_mm);
  EXPECT_EQ(spec.base.voxel_mm, MandibleParams{}.voxel_mm);
  EXPECT_EQ(spec.base.voxel_mm, ImportOptions{}.voxel_mm);
  EXPECT_EQ(spec.base.rim_samples_per_pitch, SimulationParams{}.rim_samples_per_pitch);
  EXPECT_EQ(spec.base.rim_samples_per_pitch, CoupledParams{}.rim_samples_per_pitch);
  EXPECT_EQ(spec.base.rim_samples_per_pitch, SceneSimulation{}.rim_samples_per_pitch);
  EXPECT_GE(spec.ticks_of_defaults, 100'000);
}

TEST(StudyFile, ReadsEveryKey) {
  const StudySpec spec = Parse(R"(
title = "All"
[study]
paths = ["slot", "entry"]
holdings = ["path"]
cost_paths = ["slot", "mine"]
ticks_per_case = 3000
ticks_of_defaults = 4000
reference_tolerance = 1e-3
[base]
voxel_mm = 0.2
law = "edge_plus_chip"
[[knob]]
name = "rate_hz"
values = [500, 1000.5]
paths = ["mine"]
[[knob]]
name = "law"
values = ["hertz_chip"]
holdings = ["hand"]
[[scene]]
name = "mine"
file = "a/b.toml"
)");
  EXPECT_EQ(spec.title, "All");
  EXPECT_THAT(spec.paths, ElementsAre("slot", "entry"));
  EXPECT_THAT(spec.holdings, ElementsAre(Holding::kPath));
  EXPECT_THAT(spec.cost_paths, ElementsAre("slot", "mine"));
  EXPECT_EQ(spec.ticks_per_case, 3000);
  EXPECT_EQ(spec.ticks_of_defaults, 4000);
  EXPECT_EQ(spec.reference_tolerance, 1e-3);
  EXPECT_EQ(spec.base.voxel_mm, 0.2);
  EXPECT_EQ(spec.base.law, "edge_plus_chip");
  ASSERT_EQ(spec.knobs.size(), 2u);
  EXPECT_THAT(spec.knobs[0].values, ElementsAre("500", "1000.5"));
  EXPECT_THAT(spec.knobs[0].paths, ElementsAre("mine"));
  EXPECT_THAT(spec.knobs[1].holdings, ElementsAre(Holding::kHand));
  ASSERT_EQ(spec.scenes.size(), 1u);
  EXPECT_THAT(spec.scenes[0].file, HasSubstr("/a/b.toml"));
  // When it is read back from a folder, it is the same study.
  const StudySpec again = SpecFromJson(nlohmann::ordered_json::parse(SpecToJson(spec).dump()));
  EXPECT_EQ(SpecToJson(again), SpecToJson(spec));
  EXPECT_EQ(HashOf(again), HashOf(spec));
}

TEST(StudyFile, ScenesAloneExcludeTheBuiltInPaths) {
  EXPECT_TRUE(Parse("[[scene]]\nname = \"a\"\nfile = \"a.toml\"\n").paths.empty());
}

// A simulation accepts the values that the study file accepts, and refuses those that the study file refuses.
TEST(StudyFile, RangesAreThoseOfTheSimulation) {
  struct Bounds {
    const char* knob;
    int lower, upper;
  };
  const StudyPath path = MakeStudyPaths({"idle"}, "").paths.front();
  for (const Bounds& b :
       {Bounds{"substeps", 1, 64}, Bounds{"carve_interval_ticks", 1, 64}, Bounds{"band_voxels", 2, 8}}) {
    for (const int value : {b.lower - 1, b.lower, b.upper, b.upper + 1}) {
      const bool good = value >= b.lower && value <= b.upper;
      EXPECT_EQ(Fault(fmt::format("[base]\n{} = {}", b.knob, value)).empty(), good) << b.knob << " = " << value;
      for (const Holding holding : {Holding::kHand, Holding::kPath}) {
        StudySettings settings;
        settings.voxel_mm = 0.4;
        SetValue(settings, b.knob, fmt::format("{}", value));
        const std::string fault =
            test::MessageOf([&] { MakeCaseSubject(path, holding, settings, MakeCaseBone(path, settings)); });
        EXPECT_EQ(fault.empty(), good) << b.knob << " = " << value << ": " << fault;
      }
    }
  }
}

TEST(StudyFile, FaultsAreReportedWithPlaceAndCorrection) {
  const std::vector<std::pair<std::string, std::string>> cases = {
      {"titel = \"x\"", "study.toml:1:1: unknown key \"titel\" in the study file; the nearest valid key is \"title\""},
      {"[study]\npath = [\"slot\"]",
       "study.toml:2:1: unknown key \"path\" in [study]; the nearest valid key is \"paths\""},
      {"[study]\npaths = [\"slot\", \"slt\"]", "study.toml:2:18: there is no path \"slt\"; the nearest is \"slot\""},
      {"[study]\npaths = [\"slot\", \"slot\"]", "study.toml:2:18: \"slot\" is listed twice in paths"},
      {"[study]\npaths = []", "study.toml:2:1: paths is empty; omit it for all"},
      {"[study]\npaths = \"slot\"", "study.toml:2:1: paths must be a list of names of paths"},
      {"[study]\nholdings = [\"foot\"]", "study.toml:2:13: there is no holding \"foot\"; there are hand, path"},
      {"[study]\nticks_per_case = 10", "study.toml:2:1: ticks_per_case = 10 is below 1000; valid range 1000 to 1"},
      {"[study]\nticks_per_case = 2e3", "study.toml:2:1: ticks_per_case = 2000 is a number; it must be a whole number"},
      {"[study]\nreference_tolerance = nan", "reference_tolerance = nan is not a finite number"},
      {"[base]\nvoxel = 0.1", "study.toml:2:1: unknown key \"voxel\" in [base]; the nearest valid key is \"voxel_mm\""},
      {"[base]\nvoxel_mm = 5", "study.toml:2:1: voxel_mm = 5 is above 4; valid range 0.02 to 4 mm"},
      {"[base]\nlaw = \"herz\"",
       "study.toml:2:1: law = \"herz\" is unknown; it must be \"two_component\" or \"hertz_chip\""},
      {"[[knob]]\nname = \"voxel\"\nvalues = [1]", "study.toml:2:1: there is no knob \"voxel\"; the nearest is"},
      {"[[knob]]\nname = \"voxel_mm\"", "[[knob]] has no values"},
      {"[[knob]]\nvalues = [1]", "[[knob]] has no name"},
      {"[[knob]]\nname = \"voxel_mm\"\nvalues = []", "study.toml:3:1: values must be a list of 1 to 1000 values"},
      {"[[knob]]\nname = \"voxel_mm\"\nvalues = [0.1,\n 7]",
       "study.toml:4:2: voxel_mm = 7 is above 4; valid range 0.02 to 4 mm"},
      {"[[knob]]\nname = \"voxel_mm\"\nvalues = [\"fine\"]", "study.toml:3:11: voxel_mm = \"fine\" is a string"},
      {"[[knob]]\nname = \"substeps\"\nvalues = [1.5]",
       "study.toml:3:11: substeps = 1.5 is a number; it must be a whole"},
      {"[[knob]]\nname = \"voxel_mm\"\nvalues = [0.1, 0.10]", "study.toml:3:16: 0.1 is listed twice in values"},
      {"[[knob]]\nname = \"law\"\nvalues = [\"hertz\"]", "study.toml:3:11: law = \"hertz\" is unknown"},
      {"[[knob]]\nname = \"voxel_mm\"\nvalues = [1]\n[[knob]]\nname = \"voxel_mm\"\nvalues = [2]",
       "study.toml:5:1: the knob \"voxel_mm\" is listed twice"},
      {"[[scene]]\nname = \"a/b\"\nfile = \"x\"", "study.toml:2:1: a name has 1 to 60 letters, digits, '-' and '_'"},
      {"[[scene]]\nname = \"slot\"\nfile = \"x\"", "study.toml:2:1: there is already a path \"slot\""},
      {"[[scene]]\nname = \"a\"\nfile = \"\"", "study.toml:3:1: file is empty"},
      {"[study\n", "study.toml:1:7: not valid TOML"},
  };
  for (const auto& [text, message] : cases) EXPECT_THAT(Fault(text), HasSubstr(message)) << text;
}

TEST(StudyFile, SeveralFaultsAreReportedAtOnce) {
  const std::string message =
      Fault("[study]\nx = 1\n[base]\nvoxel_mm = 9\n[[knob]]\nname = \"rate_hz\"\nvalues = [1]\n");
  EXPECT_THAT(message, HasSubstr("study.toml:2:1: "));
  EXPECT_THAT(message, HasSubstr("\nstudy.toml:4:1: "));
  EXPECT_THAT(message, HasSubstr("\nstudy.toml:7:11: "));
}

TEST(StudyFile, ShippedStudiesAreValidAndTheDefaultOneHasTheDefaultSettings) {
  const std::vector<std::string> all = NamesOfStudyPaths();
  const std::string folder = std::string(KERF_SOURCE_DIR) + "/scenes/";
  const StudySpec spec = ReadStudyFile(folder + "study_default.toml", all);
  EXPECT_EQ(DefaultStudyToml(), ReadTextFile(folder + "study_default.toml"));
  EXPECT_EQ(ShowSettings(spec.base), ShowSettings(StudySettings{}));
  EXPECT_GE(spec.ticks_of_defaults, 100'000);
  EXPECT_EQ(spec.knobs.size(), StudyKnobs().size());  // one curve each
  const StudySpec quick = ReadStudyFile(folder + "study_quick.toml", all);
  EXPECT_EQ(quick.paths.size(), 3u);
  EXPECT_EQ(quick.knobs.size(), 3u);
}

TEST(StudyFile, ScenesOfAStudyAreReadAndTheirContentAffectsTheHash) {
  test::Folder folder;
  const std::string scene = ReadTextFile(std::string(KERF_SOURCE_DIR) + "/scenes/slot_in_block.toml");
  test::WriteBytes(folder.file("cut.toml"), scene);
  test::WriteBytes(folder.file("study.toml"), "[[scene]]\nname = \"cut\"\nfile = \"cut.toml\"\n");
  const std::uint64_t before = HashOf(ReadStudyFile(folder.file("study.toml"), kStudyFilePaths));
  EXPECT_EQ(HashOf(ReadStudyFile(folder.file("study.toml"), kStudyFilePaths)), before);
  test::WriteBytes(folder.file("cut.toml"), scene + "\n# changed\n");
  EXPECT_NE(HashOf(ReadStudyFile(folder.file("study.toml"), kStudyFilePaths)), before);
  test::WriteBytes(folder.file("cut.toml"), scene + "\nfoo = 1\n");
  EXPECT_THAT(test::MessageOf([&] { ReadStudyFile(folder.file("study.toml"), kStudyFilePaths); }),
              HasSubstr("cut.toml:"));
  std::filesystem::remove(folder.file("cut.toml"));
  EXPECT_THAT(test::MessageOf([&] { ReadStudyFile(folder.file("study.toml"), kStudyFilePaths); }),
              HasSubstr("cut.toml: there is no such file"));
}

TEST(StudyFile, LawIsThatOfTheScenesUnlessTheBaseNamesOne) {
  test::Folder folder;
  const std::string scene = ReadTextFile(std::string(KERF_SOURCE_DIR) + "/scenes/bur_groove.toml");
  ASSERT_THAT(scene, Not(HasSubstr("[force]")));
  test::WriteBytes(folder.file("a.toml"), scene);
  test::WriteBytes(folder.file("b.toml"), scene + "\n[force]\nlaw = \"edge_plus_chip\"\n");
  const std::string a = "[[scene]]\nname = \"a\"\nfile = \"a.toml\"\n";
  const std::string b = "[[scene]]\nname = \"b\"\nfile = \"b.toml\"\n";
  const auto law_of = [&](const std::string& text) {
    test::WriteBytes(folder.file("study.toml"), text);
    return ReadStudyFile(folder.file("study.toml"), kStudyFilePaths).base.law;
  };
  EXPECT_EQ(law_of(""), ForceLaw().name());  // of the study's own paths
  EXPECT_EQ(law_of(a), ForceLaw().name());
  EXPECT_EQ(law_of(b), "edge_plus_chip");
  EXPECT_EQ(law_of("[base]\nlaw = \"hertz_chip\"\n" + a + b), "hertz_chip");
  EXPECT_THAT(test::MessageOf([&] { law_of(a + b); }),
              HasSubstr("\"a\" and \"b\" name the laws two_component and edge_plus_chip; name one in [base]"));
}

TEST(StudyFile, HashDependsOnlyOnWhatAffectsResults) {
  const std::string text = "title = \"a\"\n[[knob]]\nname = \"voxel_mm\"\nvalues = [0.2]\n";
  const std::uint64_t hash = HashOf(Parse(text));
  EXPECT_EQ(HashOf(Parse("# words\ntitle = \"b\"\n[[knob]]\nvalues = [0.20]\nname = \"voxel_mm\"\n")), hash);
  EXPECT_NE(HashOf(Parse("[[knob]]\nname = \"voxel_mm\"\nvalues = [0.25]\n")), hash);
  EXPECT_NE(HashOf(Parse(text + "[base]\nsubsteps = 2\n")), hash);
  EXPECT_NE(HashOf(Parse(text + "[study]\nticks_per_case = 5000\n")), hash);
}

// If any bytes are changed, a study is read or is refused with a message.
TEST(StudyFile, MutatedFilesAreReadOrRefused) {
  const std::string text = DefaultStudyToml() + "\n[[scene]]\nname = \"mine\"\nfile = \"x.toml\"\n";
  EXPECT_TRUE(test::CheckSeeded(20261120, 400, [&] {
    std::mt19937_64 random(*rc::gen::arbitrary<std::uint64_t>());
    std::string changed = text;
    const std::size_t changes = 1 + random() % 8;
    for (std::size_t i = 0; i < changes && !changed.empty(); ++i) {
      const std::size_t at = random() % changed.size();
      const std::size_t length = std::min<std::size_t>(random() % 12, changed.size() - at);
      switch (random() % 4) {
        case 0:
          changed[at] = static_cast<char>(random());
          break;
        case 1:
          changed.erase(at, length);
          break;
        case 2:
          changed.insert(at, changed.substr(random() % changed.size(), length));
          break;
        default:
          changed[at] = "[]{}\"'=.,#\n0123456789-+e"[random() % 24];
      }
    }
    try {
      const StudySpec spec = Parse(changed);
      const std::string kept = SpecToJson(spec).dump();
      RC_ASSERT(SpecToJson(SpecFromJson(nlohmann::ordered_json::parse(kept))).dump() == kept);
    } catch (const Error& e) {
      RC_ASSERT(std::string(e.what()).rfind("study.toml:", 0) == 0);
    }
  }));
}

TEST(StudySettingsTest, ValuesReadBackTheSame) {
  StudySettings settings;
  for (const Knob& knob : StudyKnobs()) {
    StudySettings copy;
    SetValue(copy, knob.name, ValueOf(settings, knob.name));
    EXPECT_EQ(ShowSettings(copy), ShowSettings(settings)) << knob.name;
  }
  SetValue(settings, "voxel_mm", "0.07");
  EXPECT_EQ(settings.voxel_mm, 0.07);
  EXPECT_THROW(SetValue(settings, "substeps", "1.5"), Error);
  EXPECT_THROW(SetValue(settings, "voxel", "1"), Error);
}

}  // namespace
}  // namespace kerf
