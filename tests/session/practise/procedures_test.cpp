// The scenes of scenes/procedures, done by the synthetic expert on a coarse bone.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <atomic>
#include <span>
#include <string>
#include <vector>

#include "session/practise/agents.h"
#include "session/score/score.h"
#include "support/result_folder.h"
#include "test_paths.h"

namespace kerf {
namespace {

struct Done {
  ScoreSheet sheet;
  std::size_t pieces = 0;
  std::vector<double> volumes_mm3;  // of the pieces
};

class Procedures : public test::ResultFolderTest {
 protected:
  /// Lets the expert do a scene of scenes/procedures with voxels of 0.4 mm and a quarter of the ticks.
  Done Do(const std::string& name) {
    MakeFolder(folder_);
    Scene scene = ReadScene(std::string(KERF_SOURCE_DIR) + "/scenes/procedures/" + name + ".toml");
    scene.bone.mandible.voxel_mm = 0.4;
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
    const LoopSummary summary = RunLoop(scene, loop, {});
    EXPECT_TRUE(done) << name;
    RecordingReader recording(loop.output.record);
    Done made{meter.Score(recording, summary.before, summary.after), summary.piece_bones.size(), {}};
    for (const Bone& piece : summary.piece_bones) made.volumes_mm3.push_back(piece.CalcVolume());
    return made;
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

}  // namespace
}  // namespace kerf
