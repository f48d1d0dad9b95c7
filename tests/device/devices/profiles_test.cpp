// The table of devices: its contents, and errors in it.
#include "device/devices/profiles.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <sstream>

#include "device/devices/hand.h"
#include "kerf/error.h"
#include "support/message_of.h"
#include "test_paths.h"

namespace kerf {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::StartsWith;

std::string ReadShipped() {
  std::ifstream in(KERF_SOURCE_DIR "/volumes/device_profiles.csv");
  std::ostringstream text;
  text << in.rdbuf();
  return text.str();
}

std::string MessageOf(const std::string& text) {
  return test::MessageOf([&] { ParseDeviceProfiles(text, "t.csv"); }, "nothing thrown");
}

std::string Replaced(std::string text, const std::string& from, const std::string& to) {
  const auto at = text.find(from);
  if (at == std::string::npos) throw std::runtime_error("no " + from);
  return text.replace(at, from.size(), to);
}

TEST(DeviceProfiles, ContainTheValuesOfChai3d) {
  // Peak force in N, stiffness in N/m, damping in N s/m and workspace in mm, from CHAI3D's constructors
  // (CPhantomDevices.cpp, CDeltaDevices.cpp, CFalconDevice.cpp).
  struct Row {
    const char* name;
    double force, stiffness, damping, radius;
  };
  for (const Row& row :
       {Row{"touch", 3.3, 400, 4, 75}, Row{"omni", 3.3, 700, 5, 100}, Row{"desktop", 7.9, 1000, 5, 100},
        Row{"premium_1_5_6dof", 8.5, 800, 5, 120}, Row{"premium_3_0_6dof", 22, 1000, 5, 250},
        Row{"falcon", 8, 3000, 20, 40}, Row{"omega_3", 12, 5000, 30, 75}, Row{"omega_6", 12, 5000, 30, 75},
        Row{"delta_3", 20, 5000, 30, 150}, Row{"delta_6", 20, 5000, 30, 150}, Row{"sigma_7", 12, 4000, 30, 75}}) {
    const DeviceProfile& p = FindDeviceProfile(row.name);
    EXPECT_DOUBLE_EQ(p.peak_force_N, row.force) << row.name;
    EXPECT_DOUBLE_EQ(p.max_stiffness_N_per_mm * 1000, row.stiffness) << row.name;
    EXPECT_DOUBLE_EQ(p.max_damping_Ns_per_mm * 1000, row.damping) << row.name;
    EXPECT_DOUBLE_EQ(p.workspace_radius_mm, row.radius) << row.name;
    EXPECT_THAT(p.source, HasSubstr("CHAI3D")) << row.name;
  }
}

TEST(DeviceProfiles, NameTheValuesThatWereNotReadInASource) {
  const DeviceProfile& omni = FindDeviceProfile("omni");
  EXPECT_THAT(omni.source, HasSubstr("recalled, not verified: continuous_force_N, resolution_mm, friction_N, mass_kg"));
  EXPECT_THAT(omni.source, HasSubstr("assumed: own_damping_Ns_per_mm"));
  EXPECT_EQ(FindDeviceProfile("falcon").continuous_force_N, 0);  // unknown
}

TEST(DeviceProfiles, BuiltInTableIsTheFile) {
  const std::vector<DeviceProfile> file = ParseDeviceProfiles(ReadShipped(), "device_profiles.csv");
  ASSERT_EQ(file.size(), DeviceProfiles().size());
  for (std::size_t i = 0; i < file.size(); ++i) {
    EXPECT_EQ(file[i].name, DeviceProfiles()[i].name);
    EXPECT_EQ(file[i].source, DeviceProfiles()[i].source);
    EXPECT_EQ(file[i].max_torsion_damping_Nmms, DeviceProfiles()[i].max_torsion_damping_Nmms);
  }
}

TEST(DeviceProfiles, MisspeltNameIsReportedWithTheNearest) {
  const auto message = [](const char* name) -> std::string {
    return test::MessageOf([&] { FindDeviceProfile(name); });
  };
  EXPECT_EQ(message("omega3"), "device \"omega3\" is unknown; the nearest is \"omega_3\"");
  EXPECT_THAT(message("lightsabre"), AllOf(HasSubstr("the devices are ideal, touch, omni"), HasSubstr("maglev_200")));
}

TEST(DeviceProfiles, EveryFaultIsReportedWithItsLine) {
  const std::string good = ReadShipped();
  const auto with = [&](const char* from, const char* to) { return MessageOf(Replaced(good, from, to)); };
  EXPECT_THAT(with("touch,3,3.3 S", "touch,3,3.3"),
              AllOf(StartsWith("t.csv:"), HasSubstr("peak_force_N = \"3.3\" must end with its reliability")));
  EXPECT_THAT(with("touch,3,3.3 S", "touch,3,3.3 X"), HasSubstr("must end with its reliability"));
  EXPECT_THAT(with("touch,3,3.3 S", "touch,3,3,3 S"), HasSubstr("17 fields instead of 16"));
  EXPECT_THAT(with("touch,3,3.3 S", "touch,4,3.3 S"), HasSubstr("degrees_of_freedom = \"4\" must be 3 or 6"));
  EXPECT_THAT(with("touch,3,3.3 S", "touch,3,-3.3 S"),
              HasSubstr("peak_force_N = -3.3 is below 0.01; valid range 0.01 to 10000 N"));
  EXPECT_THAT(with("touch,3,3.3 S", "touch,3,nan S"), HasSubstr("peak_force_N = \"nan\" is not a number"));
  EXPECT_THAT(with("touch,3,3.3 S", "touch,3,unknown"),
              HasSubstr("peak_force_N = unknown is not accepted; give a number"));
  EXPECT_THAT(with("touch,3,3.3 S,0.88 R", "touch,3,3.3 S,4 R"),
              HasSubstr("touch: the continuous force 4 is above the peak 3.3"));
  EXPECT_THAT(with("touch,3,3.3 S,0.88 R,none", "touch,3,3.3 S,0.88 R,5 A"),
              HasSubstr("touch: a device with 3 degrees of freedom has no torque; write none"));
  EXPECT_THAT(with("omni,3,", "touch,3,"), HasSubstr("device \"touch\" is given twice"));
  EXPECT_THAT(with("omni,3,", "Omni,3,"), HasSubstr("name = \"Omni\" must consist of 1 to 40 lower-case letters"));
  EXPECT_THAT(with(",mass_kg,", ",mass_g,"), HasSubstr("unknown column \"mass_g\"; did you mean \"mass_kg\"?"));
  EXPECT_THAT(with("\"Haply Inverse3\"", "\"\""), HasSubstr("source is empty"));
  EXPECT_THAT(MessageOf(good.substr(0, good.find("ideal,"))), HasSubstr("t.csv: no device below the header"));
}

TEST(Hands, AreThoseOfTheLiteratureInMillimetres) {
  ASSERT_EQ(HandModels().size(), 5u);
  const HandModel& arm = FindHandModel("H3");
  EXPECT_DOUBLE_EQ(arm.mass_kg, 0.554);
  EXPECT_DOUBLE_EQ(arm.damping_Ns_per_mm * 1000, 6.45);  // N s/m
  EXPECT_DOUBLE_EQ(arm.stiffness_N_per_mm * 1000, 135);  // N/m
  EXPECT_EQ(test::MessageOf([&] { FindHandModel("H9"); }), "hand \"H9\" is unknown; the hands are H0, H1, H2, H3, H4");
}

}  // namespace
}  // namespace kerf
