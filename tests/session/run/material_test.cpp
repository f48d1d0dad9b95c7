// Tests of a scene's material, from its keys to the bone, the results and the messages.
#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>

#include "base/files/files.h"
#include "bone/grid/ct_modulus.h"
#include "bone/models/block.h"
#include "bone/vdb/bonefile.h"
#include "kerf/error.h"
#include "session/run/make_bone.h"
#include "session/run/run_scene.h"
#include "support/block_scene.h"
#include "support/message_of.h"

namespace kerf {
namespace {

namespace fs = std::filesystem;

const std::string kPath =
    test::StrokeToml({0, 0, 11.5}, {0, 0, 8}, 10, {0, 1, 0}) + "[output]\npictures = false\npieces = false\n";

/// A folder with a block of 8 x 4 x 6 mm in two layers, with CT numbers (hu.vdb) and without (plain.vdb).
class SceneMaterialRun : public testing::Test {
 protected:
  void SetUp() override {
    folder_ = (fs::temp_directory_path() / ("kerf_material_" + std::to_string(getpid()))).string();
    fs::remove_all(folder_);
    fs::create_directories(folder_);
    BlockParams block;
    block.size_mm = {8, 4, 6};
    block.voxel_mm = 0.2;
    block.layers = {{1, 24}, {5, 32}};
    Bone bone = MakeBlock(block, [] {
      MaterialTable table;
      table.Add({24, "cortex", Tissue::kCortical, 19300, 0.28, false, "test"});
      table.Add({32, "marrow", Tissue::kCancellous, 1370, 0.30, true, "test"});
      return table;
    }());
    WriteBone(bone, folder_ + "/plain.vdb");
    // A fifth of the height is below 100 HU.
    SetHu(
        bone, [](const Vec3& p) { return p.z < -4.8 ? 50 : 1000; }, 0.25);
    WriteBone(bone, folder_ + "/hu.vdb");
    std::ofstream(folder_ + "/laws.csv") << "name,tissue,density,calibration,bands,tag,source\n"
                                            "linear,test,qct,0:0 3000:3,0.1 to 3: 2000 rho^1,R,made up\n";
  }
  void TearDown() override { fs::remove_all(folder_); }

  Scene SceneOf(const std::string& bone, const std::string& material) const {
    return ParseScene("[bone]\nfile = \"" + bone + "\"\n[material]\n" + material + "\n" + kPath, folder_ + "/s.toml");
  }
  static std::string MessageOf(const Scene& scene) {
    return test::MessageOf([&] { MakeSceneBone(scene, {}); }, "accepted");
  }

  std::string folder_;
};

const char kLinear[] = "kind = \"ct\"\nct_law = \"linear\"\nct_law_file = \"laws.csv\"";

TEST_F(SceneMaterialRun, TakesTheModulusFromTheCtInCancellousBone) {
  MaterialSummary summary;
  const Bone bone = MakeSceneBone(SceneOf("hu.vdb", kLinear), {}, &summary);
  EXPECT_NEAR(bone.ModulusAt({0, 0, -3}), 2000, 1e-3);
  EXPECT_NEAR(bone.ModulusAt({0, 0, -5.5}), 200, 1e-3);  // limited to the end of the law's range
  EXPECT_NEAR(bone.ModulusAt({0, 0, -0.5}), 19300, 1e-6);
  EXPECT_EQ(summary.law.name, "linear");
  EXPECT_EQ(summary.ct_regions, std::vector<int>{32});
  EXPECT_NEAR(summary.ct.fraction_below, 1.2 / 5, 0.05);  // layers of voxels of 0.25 mm in 5 mm
  EXPECT_EQ(summary.ct.fraction_above, 0);
  ASSERT_EQ(summary.warnings.size(), 2u);
  EXPECT_NE(summary.warnings[0].find("lies outside the range of linear (100 to 3000 HU)"), std::string::npos);
  EXPECT_EQ(summary.warnings[1], "part of the law linear is quoted from memory, not verified: made up");
}

TEST_F(SceneMaterialRun, LoadsCtNumbersOnlyIfTheSceneUsesThem) {
  const Bone plain = MakeSceneBone(SceneOf("plain.vdb", ""), {});
  const Bone regions = MakeSceneBone(SceneOf("hu.vdb", ""), {});
  const Bone uniform = MakeSceneBone(SceneOf("hu.vdb", "kind = \"uniform\""), {});
  for (const Bone* bone : {&regions, &uniform}) {
    EXPECT_FALSE(bone->has_hu());
    EXPECT_EQ(bone->CalcMemoryBytes(), plain.CalcMemoryBytes());
    EXPECT_EQ(bone->CalcHash(), plain.CalcHash());
  }
  EXPECT_NEAR(regions.ModulusAt({0, 0, -3}), 1370, 1e-6);
  EXPECT_NEAR(uniform.ModulusAt({0, 0, -3}), 19300, 1e-6);
}

TEST_F(SceneMaterialRun, ReportsMissingOrWrongInput) {
  EXPECT_EQ(
      MessageOf(SceneOf("plain.vdb", kLinear)),
      folder_ +
          "/plain.vdb: contains no CT numbers, which kind = \"ct\" requires; import the CT again with 'kerf import "
          "--keep-hu'");
  EXPECT_EQ(MessageOf(SceneOf("hu.vdb", "kind = \"ct\"\nct_law = \"linaer\"\nct_law_file = \"laws.csv\"")),
            folder_ + "/laws.csv: ct_law = \"linaer\" is unknown; the nearest is \"linear\"");
  EXPECT_EQ(MessageOf(SceneOf("hu.vdb", "kind = \"ct\"\nct_law = \"linear\"\nct_law_file = \"none.csv\"")),
            folder_ + "/none.csv: there is no such file");
  EXPECT_EQ(MessageOf(SceneOf("hu.vdb", "kind = \"ct\"\nct_law = \"morgan_2003_vertebra\"")),
            "ct_law = \"morgan_2003_vertebra\" requires apparent density and has no calibration of its own, since that "
            "depends on the scanner; give ct_calibration = \"HU:density HU:density ...\" in g/cm3, from a phantom");
  EXPECT_EQ(MessageOf(SceneOf("hu.vdb", std::string(kLinear) + "\nct_calibration = \"0:4 1000:5\"")),
            "the calibration covers 4 to 5 g/cm3, but the bands cover 0.1 to 3");
  EXPECT_EQ(MessageOf(SceneOf("hu.vdb", std::string(kLinear) + "\nct_calibration = \"0:0 1000:2\"")), "accepted");
}

TEST_F(SceneMaterialRun, WritesTheUsedMaterialAndKeepsTheBonesTable) {
  const Scene ct = SceneOf("hu.vdb", kLinear);
  RunScene(ct, folder_ + "/ct", {});
  const auto json = nlohmann::json::parse(ReadTextFile(folder_ + "/ct/summary.json"))["material"];
  EXPECT_EQ(json["kind"], "ct");
  EXPECT_EQ(json["law"], "linear");
  EXPECT_EQ(json["source"], "made up");
  EXPECT_EQ(json["estimate"], true);
  EXPECT_EQ(json["tag"], "R");
  EXPECT_NEAR(json["valid_HU"][0].get<double>(), 100, 1e-9);
  EXPECT_NEAR(json["share_below_range"].get<double>(), 0.24, 0.05);
  EXPECT_NEAR(json["E_GPa"]["max"].get<double>(), 2, 1e-6);
  // The cut bone keeps its CT numbers, so that the next cut can use them.
  EXPECT_TRUE(ReadBone(folder_ + "/ct/bone.vdb", {.hu = true}).has_hu());
  EXPECT_EQ(MessageOf(ParseScene(ReadTextFile(folder_ + "/ct/scene.toml"), folder_ + "/x.toml")), "accepted");

  RunScene(SceneOf("hu.vdb", "kind = \"uniform\"\nE_GPa = 5.0\nnu = 0.2"), folder_ + "/uniform", {});
  const auto uniform = nlohmann::json::parse(ReadTextFile(folder_ + "/uniform/summary.json"));
  EXPECT_EQ(uniform["material"]["kind"], "uniform");
  EXPECT_EQ(uniform["material"]["E_GPa"], 5.0);
  EXPECT_EQ(uniform["removed"]["by_region"][0]["E_GPa"], 5.0);
  EXPECT_EQ(ReadBone(folder_ + "/uniform/bone.vdb").materials().At(24).E_MPa, 19300);

  RunScene(SceneOf("plain.vdb", ""), folder_ + "/regions", {});
  EXPECT_EQ(nlohmann::json::parse(ReadTextFile(folder_ + "/regions/summary.json"))["material"]["kind"], "regions");
}

TEST_F(SceneMaterialRun, TheCutIsTheSameWhateverTheMaterial) {
  Scene scene = SceneOf("hu.vdb", ""), by_ct = SceneOf("hu.vdb", kLinear);
  scene.force = by_ct.force = ForceLaw("hertz_chip");  // depends on E
  const RunSummary regions = RunScene(scene, folder_ + "/a", {});
  const RunSummary ct = RunScene(by_ct, folder_ + "/b", {});
  EXPECT_EQ(regions.hash_after, ct.hash_after);
  EXPECT_EQ(regions.removed_mm3, ct.removed_mm3);
  EXPECT_GT(ct.force.peak_N, 0);
  EXPECT_NE(regions.force.impulse_Ns, ct.force.impulse_Ns);
}

}  // namespace
}  // namespace kerf
