// The scenes of scenes/procedures, done by the synthetic expert on a coarse bone.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <atomic>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "bone/import/import.h"
#include "bone/vdb/bonefile.h"
#include "session/marks/structures.h"
#include "session/practise/agents.h"
#include "session/run/make_bone.h"
#include "session/score/score.h"
#include "support/result_folder.h"
#include "test_paths.h"

namespace kerf {
namespace {

const std::string kVisibleHuman = std::string(KERF_TEST_DATA) + "/visible_human_female/dicom";

struct Done {
  ScoreSheet sheet;
  std::size_t pieces = 0;
  std::vector<double> volumes_mm3;  // of the pieces
  Bone before;
  Bone after;
};

class Procedures : public test::ResultFolderTest {
 protected:
  /// Lets the expert do a scene of scenes/procedures with voxels of 0.4 mm and a quarter of the ticks. `bone_file`: in
  /// place of the scene's.
  Done Do(const std::string& name, const std::string& bone_file = "") {
    MakeFolder(folder_);
    Scene scene = ReadScene(std::string(KERF_SOURCE_DIR) + "/scenes/procedures/" + name + ".toml");
    scene.bone.mandible.voxel_mm = 0.4;
    if (!bone_file.empty()) scene.bone.file = bone_file;
    scene.loop.rate_hz = 250;
    const AgentParams params = MakeAgentParams("expert", 1);
    std::atomic<bool> done{false};
    LoopOptions loop;
    loop.virtual_time = true;
    loop.seconds = CalcAgentTime(params, scene);
    loop.output.log = LoopLog::kNone;
    loop.output.record = folder_ + "/" + name + ".kerf";
    loop.output.scene_file = name + ".toml";
    loop.output.keep_bones = true;
    loop.stop = &done;
    SessionMeter meter(scene);
    loop.watchers.take_tick = [&](const LoopTick& tick, std::span<const double>) { meter.Take(tick); };
    loop.driver.make_hand = MakeAgent(params, scene, &done);
    LoopSummary summary = RunLoop(scene, loop, {});
    EXPECT_TRUE(done) << name;
    RecordingReader recording(loop.output.record);
    Done made{meter.Score(recording, summary.before, summary.after), summary.piece_bones.size(), {}, {}, {}};
    for (const Bone& piece : summary.piece_bones) made.volumes_mm3.push_back(piece.CalcVolume());
    made.before = std::move(summary.before);
    made.after = std::move(summary.after);
    return made;
  }
  /// Returns the file of the Visible Human's mandible, with voxels of 0.4 mm.
  std::string ImportVisibleHuman() {
    MakeFolder(folder_);
    ImportOptions options;
    options.voxel_mm = 0.4;
    std::string file = folder_ + "/visible_human.vdb";
    WriteBone(Import(kVisibleHuman, options).bone, file);
    return file;
  }
};

TEST_F(Procedures, FourHolesForAPlateGoThroughWithoutPlunging) {
  const Done made = Do("plate_holes");
  EXPECT_GT(made.sheet.total.value(), 85) << FormatSheet(made.sheet);
  EXPECT_EQ(made.sheet.Get("holes_through"), 4);
  EXPECT_LT(made.sheet.Get("plunge_max_mm").value(), 3);
  EXPECT_GT(made.sheet.Get("nerve_distance_mm").value(), 5);
}

TEST_F(Procedures, SegmentOfASegmentalResectionComesFree) {
  const Done made = Do("segmental_resection");
  EXPECT_GT(made.sheet.total.value(), 85) << FormatSheet(made.sheet);
  EXPECT_EQ(made.pieces, 3U);
}

TEST_F(Procedures, MarginalResectionLeavesTheLowerBorderAndTheNerve) {
  const Done made = Do("marginal_resection");
  EXPECT_GT(made.sheet.total.value(), 80) << FormatSheet(made.sheet);
  EXPECT_EQ(made.pieces, 2U);
  EXPECT_GT(made.sheet.Get("nerve_distance_mm").value(), 5);
}

TEST_F(Procedures, GutterBesideAThirdMolarSparesTheNerve) {
  const Done made = Do("third_molar_access");
  EXPECT_GT(made.sheet.total.value(), 85) << FormatSheet(made.sheet);
  EXPECT_EQ(made.pieces, 1U);
  EXPECT_GT(made.sheet.Get("nerve_distance_mm").value(), 2);
  EXPECT_LT(made.sheet.Get("too_deep_mm").value(), 1);
}

TEST_F(Procedures, LowerPartOfTheChinComesFreeInAGenioplasty) {
  const Done made = Do("genioplasty");
  EXPECT_GT(made.sheet.total.value(), 80) << FormatSheet(made.sheet);
  EXPECT_EQ(made.pieces, 2U) << fmt::format("{} mm3", fmt::join(made.volumes_mm3, ", "));
  EXPECT_GT(made.volumes_mm3.at(1), 1500);
  EXPECT_GT(made.sheet.Get("nerve_distance_mm").value(), 4);
}

TEST_F(Procedures, SagittalSplitSeparatesTheRamusWithoutCuttingTheNerve) {
  const Done bur = Do("sagittal_split_bur");
  EXPECT_GT(bur.sheet.total.value(), 85) << FormatSheet(bur.sheet);
  EXPECT_EQ(bur.pieces, 1U);
  const std::string file = folder_ + "/bone.vdb";
  WriteBone(bur.after, file);
  const Done saw = Do("sagittal_split_saw", file);
  EXPECT_GT(saw.sheet.total.value(), 80) << FormatSheet(saw.sheet);
  EXPECT_GT(saw.sheet.Get("nerve_distance_mm").value(), 0);
  ASSERT_EQ(saw.pieces, 2U) << fmt::format("{} mm3", fmt::join(saw.volumes_mm3, ", "));
  // The ramus behind and above the cuts, of the whole bone's 67 cm3.
  EXPECT_GT(saw.volumes_mm3[1], 5000);
  EXPECT_LT(saw.volumes_mm3[1], 8000);
  for (const StructureResult& structure : AssessStructures(bur.before, saw.after, {}).structures) {
    EXPECT_FALSE(structure.is_cut) << FormatMessage(NameStructure(structure));
  }
}

TEST_F(Procedures, SawAloneDoesNotSeparateTheRamus) {
  Bone whole;
  {
    Scene scene = ReadScene(std::string(KERF_SOURCE_DIR) + "/scenes/procedures/sagittal_split_bur.toml");
    scene.bone.mandible.voxel_mm = 0.4;
    whole = MakeSceneBone(scene, {});
  }
  MakeFolder(folder_);
  WriteBone(whole, folder_ + "/whole.vdb");
  EXPECT_EQ(Do("sagittal_split_saw", folder_ + "/whole.vdb").pieces, 1U);
}

TEST_F(Procedures, SegmentOfTheVisibleHumanComesFree) {
  if (!std::filesystem::exists(kVisibleHuman)) GTEST_SKIP() << "not found: " << kVisibleHuman;
  const Done made = Do("visible_human_segmental_resection", ImportVisibleHuman());
  EXPECT_GT(made.sheet.total.value(), 85) << FormatSheet(made.sheet);
  EXPECT_EQ(made.pieces, 3U) << fmt::format("{} mm3", fmt::join(made.volumes_mm3, ", "));
}

TEST_F(Procedures, LowerPartOfTheVisibleHumansChinComesFree) {
  if (!std::filesystem::exists(kVisibleHuman)) GTEST_SKIP() << "not found: " << kVisibleHuman;
  const Done made = Do("visible_human_genioplasty", ImportVisibleHuman());
  EXPECT_GT(made.sheet.total.value(), 80) << FormatSheet(made.sheet);
  EXPECT_EQ(made.pieces, 2U) << fmt::format("{} mm3", fmt::join(made.volumes_mm3, ", "));
  EXPECT_GT(made.volumes_mm3.at(1), 1500);
}

TEST_F(Procedures, FourHolesGoThroughTheChinOfTheVisibleHuman) {
  if (!std::filesystem::exists(kVisibleHuman)) GTEST_SKIP() << "not found: " << kVisibleHuman;
  const Done made = Do("visible_human_plate_holes", ImportVisibleHuman());
  EXPECT_GT(made.sheet.total.value(), 80) << FormatSheet(made.sheet);
  EXPECT_EQ(made.sheet.Get("holes_through"), 4);
  EXPECT_LT(made.sheet.Get("plunge_max_mm").value(), 3);
}

}  // namespace
}  // namespace kerf
