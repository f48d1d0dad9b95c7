// The configuration file of a wooden arm: the shipped file equals the built-in values, and errors name their position.
#include "device/drivers/wooden_config.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <map>

#include "device/devices/hid/wooden_kinematics.h"
#include "kerf/error.h"
#include "support/message_of.h"
#include "test_paths.h"

namespace kerf {
namespace {

using testing::AllOf;
using testing::HasSubstr;

/// Collects all keys and values.
struct Values {
  void operator()(const char* key, double& value, Range, const char*) { all[key] = {value}; }
  void operator()(const char* key, bool& value, const char*) { all[key] = {value ? 1.0 : 0.0}; }
  void operator()(const char* key, Vec3& value, Range, const char*) { all[key] = {value.x, value.y, value.z}; }
  std::map<std::string, std::vector<double>> all;
};

std::map<std::string, std::vector<double>> ValuesOf(WoodenParams params) {
  Values values;
  Describe(params, values);
  return values.all;
}

std::string MessageOf(const std::string& text) {
  return test::MessageOf([&] { ParseWoodenConfig(text, "arm.toml"); }, "nothing thrown");
}

TEST(WoodenConfig, ShippedFileIsTheDefaultAndNamesEachKey) {
  const std::string path = KERF_SOURCE_DIR "/volumes/wooden_2016.toml";
  EXPECT_EQ(ValuesOf(ReadWoodenConfig(path)), ValuesOf(WoodenParams{}));
  EXPECT_EQ(ValuesOf(ParseWoodenConfig("", "none")), ValuesOf(WoodenParams{}));
}

TEST(WoodenConfig, ZeroPoseOfTheAluminiumArmIsTheMiddle) {
  const WoodenParams params = ReadWoodenConfig(KERF_SOURCE_DIR "/volumes/wooden_aluminium_2017.toml");
  const Vec3 p_D_mm = CalcWoodenPosition(params, CalcWoodenAngles(params, {}));
  for (int i = 0; i < 3; ++i) EXPECT_NEAR(p_D_mm[i], 0, 1e-9);
}

TEST(WoodenConfig, FaultsAreReportedWithTheirPosition) {
  EXPECT_THAT(MessageOf("base_mm = 80\nforarm_mm = 200\n"), AllOf(HasSubstr("arm.toml:2:1"), HasSubstr("forearm_mm")));
  EXPECT_THAT(MessageOf("base_mm = -3"), AllOf(HasSubstr("arm.toml:1:1"), HasSubstr("0 to 1000")));
  EXPECT_THAT(MessageOf("gear = [16, 0, 12]"), AllOf(HasSubstr("arm.toml:1:1"), HasSubstr("gear[1] = 0")));
  EXPECT_THAT(MessageOf("counts_per_turn = [2000, 20000, 2000]\ngear = [16, 16, 16]"),
              AllOf(HasSubstr("arm.toml:2:1"), HasSubstr("gear[1] gives 320000 counts per turn of the joint")));
  EXPECT_THAT(MessageOf("counts_per_turn = [1, 2]"), HasSubstr("2 items"));
  EXPECT_THAT(MessageOf("zero_at_start = 1"), HasSubstr("true or false"));
  EXPECT_THAT(MessageOf("middle_mm = [900, 0, 0]"), HasSubstr("can't reach"));
  EXPECT_THAT(MessageOf("max_current_A = 4"), HasSubstr("0.01 to 3"));
  EXPECT_THAT(MessageOf("base_mm = \n"), HasSubstr("arm.toml:1"));
  EXPECT_THROW(ReadWoodenConfig("/no/such/file.toml"), Error);
}

}  // namespace
}  // namespace kerf
