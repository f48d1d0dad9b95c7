// The program as it is, cutting with an emulated Falcon in the hand of somebody who cuts.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <sstream>
#include <vector>

#include "support/program.h"

namespace kerf {
namespace {

using Json = nlohmann::json;
using test::ProgramResult;
using test::Slurp;
using testing::HasSubstr;

// The disc comes down on the block's top, z = 0. The block is wide: where the handle was let go of after homing is the
// middle of its way, to a few millimetres.
constexpr char kScene[] =
    "title = \"A block\"\n[bone]\nmodel = \"block\"\n[bone.block]\nsize_x_mm = 30.0\nsize_y_mm = 40.0\n"
    "size_z_mm = 26.0\nvoxel_mm = 0.25\n[tool]\ndiameter_mm = 22.0\nthickness_mm = 0.5\n[[path.stroke]]\n"
    "start_mm = [0.0, 0.0, 12.0]\nend_mm = [0.0, 0.0, 4.0]\nfeed_mm_per_s = 3.0\ndisc_normal = [0.0, 1.0, 0.0]\n";
constexpr double kRadius_mm = 11;
constexpr double kThickness_mm = 0.5;

class EmulatedCut : public test::ProgramTest {
 protected:
  void SetUp() override {
    ProgramTest::SetUp();
    std::string firmware(7324, '\0');
    for (std::size_t i = 0; i < firmware.size(); ++i) firmware[i] = static_cast<char>(i * 7 + i / 251);
    Write("firmware.bin", firmware);
    Write("scene.toml", kScene);
  }
  ProgramResult Cut(const std::string& options, const std::string& more) const {
    return KerfWithin(
        "'" KERF_EMULATE_USB "' --firmware firmware.bin --scene scene.toml --report report.json " + options + " -- ",
        "loop scene.toml --device falcon --falcon-firmware firmware.bin " + more);
  }
  Json Read(const std::string& file) const { return Json::parse(Slurp(folder_ / file)); }
  /// How deep the disc's centre came, from forces.csv.
  double FindLowest_mm() const {
    std::istringstream lines(Slurp(folder_ / "out/forces.csv"));
    std::string line;
    std::getline(lines, line);
    double lowest = 1e9;
    constexpr int kToolZ = 7;  // column
    while (std::getline(lines, line)) {
      std::istringstream cells(line);
      std::string cell;
      for (int i = 0; i <= kToolZ; ++i) std::getline(cells, cell, ',');
      lowest = std::min(lowest, std::stod(cell));
    }
    return lowest;
  }
};

TEST_F(EmulatedCut, FromFirmwareAndHomingToTheKerf) {
  const ProgramResult result = Cut("", "--seconds 7 -o out");
  ASSERT_EQ(result.code, 0) << result.err;
  EXPECT_THAT(result.err, HasSubstr("pull the Falcon's grip all the way out"));
  const Json report = Read("report.json");
  EXPECT_EQ(report["uploads"], 1);
  EXPECT_EQ(report["firmware_bytes"], 7324);
  EXPECT_EQ(report["homed"], true);
  EXPECT_EQ(report["homing_bit_was_off"], false);
  EXPECT_EQ(report["unknown_calls"], 0);
  EXPECT_EQ(report["motors_at_end"], (std::vector<int>{0, 0, 0}));
  EXPECT_EQ(report["force_at_end_N"], 0.0);
  const Json loop = Read("out/loop.json");
  EXPECT_EQ(loop["device"], "falcon");
  EXPECT_EQ(loop["force"]["not_finite"], 0);
  EXPECT_EQ(loop["force"]["bad_poses"], 0);
  // What the motors made is what the loop asked for, to the gate's smoothing and the motors' steps.
  const double asked_N = loop["force"]["largest_N"];
  EXPECT_GT(asked_N, 0.1);
  EXPECT_NEAR(report["peak_force_N"].get<double>(), asked_N, 0.1 * asked_N);
  // The kerf is a segment of the disc as wide as the disc is thick; the blade wanders by a part of its thickness, and
  // voxels of half the thickness blur its sides.
  const double depth_mm = kRadius_mm - FindLowest_mm();
  ASSERT_GT(depth_mm, 0.5);
  const double rest_mm = kRadius_mm - depth_mm;
  const double segment_mm2 = kRadius_mm * kRadius_mm * std::acos(rest_mm / kRadius_mm) -
                             rest_mm * std::sqrt(kRadius_mm * kRadius_mm - rest_mm * rest_mm);
  const double kerf_mm3 = segment_mm2 * kThickness_mm;
  EXPECT_GT(loop["removed_mm3"].get<double>(), 0.85 * kerf_mm3);
  EXPECT_LT(loop["removed_mm3"].get<double>(), 1.3 * kerf_mm3);
}

// The cable is pulled two seconds into the cut, and put back half a second later: firmware, homing and the user's
// consent by a button, then force again.
TEST_F(EmulatedCut, GoesOnWithConsentAfterTheCableWasPulled) {
  const ProgramResult result = Cut("--unplug-after 5500 --plug-in-after 0.5", "--seconds 18 --json");
  ASSERT_EQ(result.code, 0) << result.err;
  const Json report = Read("report.json");
  EXPECT_EQ(report["uploads"], 2);
  EXPECT_EQ(report["homed"], true);
  EXPECT_EQ(report["homing_bit_was_off"], false);
  EXPECT_EQ(report["force_at_end_N"], 0.0);
  EXPECT_GT(report["commands"], 5500);
  const std::size_t gone = result.err.find("falcon: is gone: no force");
  ASSERT_NE(gone, std::string::npos) << result.err;
  const std::size_t there = result.err.find("press a button on it", gone);
  ASSERT_NE(there, std::string::npos) << result.err;
  EXPECT_NE(result.err.find("in the hand; the force comes on slowly", there), std::string::npos) << result.err;
  EXPECT_GT(Json::parse(result.out)["removed_mm3"].get<double>(), 1);
}

}  // namespace
}  // namespace kerf
