// The file of a set of measurements: what is read, and the messages about faults.
#include "experiment/validation/measured_set.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>

#include "base/files/files.h"
#include "experiment/validation/measured_sets.h"
#include "support/message_of.h"
#include "support/result_folder.h"
#include "test_paths.h"

namespace kerf {
namespace {

using ::testing::HasSubstr;

constexpr const char* kHeader = R"(title = "t"
citation = "c"
doi = ""
specimen = "s"
setup = "u"
licence = "l"
calibrated = []
)";
constexpr const char* kTooth = "[tool]\nkind = \"tooth\"\nwidth_mm = 0.64\n";
constexpr const char* kValue =
    "[[value]]\nquantity = \"thrust_N\"\nbite_um = 2\nvalue = 5\nsd = 1\nobtained = \"read\"\n";

std::string MessageOfSet(const std::string& text) {
  return test::MessageOf([&] { ParseMeasuredSet(text, "set.toml", "set"); });
}

TEST(MeasuredSet, ValuesAndConditionsAreRead) {
  const MeasuredSet set = ParseMeasuredSet(
      std::string(kHeader) + kTooth + "[conditions]\nspeed_mm_per_s = 3000\nbite_um = 7\n" + kValue, "set.toml", "set");
  ASSERT_EQ(set.values.size(), 1u);
  const MeasuredValue& value = set.values[0];
  EXPECT_EQ(value.quantity, "thrust_N");
  EXPECT_EQ(value.value, 5);
  EXPECT_EQ(value.sd, 1);
  EXPECT_FALSE(IsGiven(value.low));
  const MeasuredConditions at = JoinConditions(value.at, set.conditions);
  EXPECT_EQ(at.bite_um, 2);  // of the value, not of the set
  EXPECT_EQ(at.speed_mm_per_s, 3000);
  EXPECT_FALSE(IsGiven(at.rpm));
  EXPECT_EQ(ShowConditions(at), "2 um, 3000 mm/s");
}

struct Fault {
  const char* text;  // after the header
  const char* message;
};

TEST(MeasuredSet, EachFaultIsReportedAtItsPlace) {
  const Fault kFaults[] = {
      {"widht_mm = 1\n", "set.toml:8:1: unknown key \"widht_mm\" in the file; valid keys: title, "},
      {"[tool]\nkind = \"tooth\"\nwidth = 0.64\n",
       "set.toml:10:1: unknown key \"width\" in [tool]; the nearest valid key is \"width_mm\""},
      {"[tool]\nkind = \"tooth\"\n", "set.toml:8:2: [tool] has no width_mm"},
      {"[tool]\nkind = \"axe\"\n", "set.toml:9:1: kind = \"axe\" is unknown; it must be \"none\" or \"tooth\""},
      {"[tool]\nkind = \"tooth\"\nwidth_mm = -1\n",
       "set.toml:10:1: width_mm = -1 is below 0.05; valid range 0.05 to 10 mm"},
      {"[tool]\nkind = \"drill\"\ndiameter_mm = 3\npoint_deg = 118\n[[value]]\nquantity = \"cutting_N\"\nvalue = 1\n"
       "obtained = \"read\"\n",
       "set.toml:13:1: a tool of kind \"drill\" has no cutting_N"},
      {"[tool]\nkind = \"tooth\"\nwidth_mm = 1\n[[value]]\nquantity = \"thrust_N\"\nvalue = 1\nlow = 1\nhigh = 2\n"
       "obtained = \"read\"\n",
       "set.toml:13:1: give either value (and sd), or low and high"},
      {"[tool]\nkind = \"tooth\"\nwidth_mm = 1\n[[value]]\nquantity = \"thrust_N\"\nlow = 3\nhigh = 2\n"
       "obtained = \"read\"\n",
       "set.toml:13:1: low = 3 exceeds high = 2"},
      {"[tool]\nkind = \"tooth\"\nwidth_mm = 1\n[[value]]\nquantity = \"thrust_N\"\nvalue = 3\n",
       "set.toml:11:1: [[value]] has no obtained"},
      {"[tool]\nkind = \"tooth\"\nwidth_mm = 1\n[[trend]]\nquantity = \"thrust_N\"\nagainst = \"rpm\"\nsign = "
       "\"rises\"\n"
       "obtained = \"read\"\n",
       "set.toml:13:1: a tool of kind \"tooth\" does not depend on rpm; it depends on bite_um, speed_mm_per_s, "
       "density"},
      {"[tool]\nkind = \"tooth\"\nwidth_mm = 1\n[[trend]]\nquantity = \"thrust_N\"\nagainst = \"bite_um\"\n"
       "sign = \"rises\"\nobtained = \"read\"\n",
       "set.toml:13:1: without from and to, [conditions] must give bite_um"},
      {"[[value]]\nquantity = \"thrust_N\"\nvalue = 3\nobtained = \"read\"\n",
       "set.toml:1:1: values and trends need a [tool] whose kind is not \"none\""},
      {"[tool]\nkind = \"blade_feed\"\nwidth_mm = 1\n", "a tool of kind \"blade_feed\" needs bite_um, feed_mm_per_min"},
      {"[tool]\nkind = \"tooth\"\nwidth_mm = nan\n", "set.toml:10:1: width_mm = nan"},
      {"[tool]\nkind = \"tooth\"\nwidth_mm = 1\n[[trend]]\nquantity = \"thrust_N\"\nagainst = \"bite_um\"\n"
       "from = 1e-5\nto = 2\nsign = \"rises\"\nobtained = \"read\"\n",
       "set.toml:14:1: from = 1e-05 is below 0.01; valid range 0.01 to 2000 um"},
      {"[tool]\nkind = \"tooth\"\nwidth_mm = 1\n[[value]]\nquantity = \"thrust_N\"\nvalue = -1\nobtained = \"read\"\n",
       "set.toml:13:1: value = -1 is below 1e-09"},
      {"x = [\n", "set.toml:"},
  };
  for (const Fault& fault : kFaults) {
    EXPECT_THAT(MessageOfSet(std::string(kHeader) + fault.text), HasSubstr(fault.message)) << fault.text;
  }
  EXPECT_THAT(MessageOfSet("title = \"t\"\n"), HasSubstr("set.toml:1:1: the file has no citation"));
  std::string header = kHeader;
  header.replace(header.find("[]"), 2, "[\"edge_plus_chips\"]");
  EXPECT_THAT(MessageOfSet(header), HasSubstr("set.toml:7:15: calibrated: there is no force law \"edge_plus_chips\"; "
                                              "the nearest is \"edge_plus_chip\""));
}

using MeasuredSets = test::ResultFolderTest;

TEST_F(MeasuredSets, AFolderAddsSetsAndReplacesThem) {
  const std::vector<MeasuredSet> built_in = BuiltInSets();
  MakeFolder(folder_);
  WriteTextFile(folder_ + "/mine.toml", std::string(kHeader) + kTooth + kValue);
  WriteTextFile(folder_ + "/james_2012.toml", std::string(kHeader) + kTooth + kValue);
  const std::vector<MeasuredSet> sets = ReadSets(folder_);
  EXPECT_EQ(sets.size(), built_in.size() + 1);
  for (const MeasuredSet& set : sets) {
    const bool mine = set.name == "james_2012" || set.name == "mine";
    EXPECT_EQ(set.title == "t", mine) << set.name;
  }
  EXPECT_THAT(test::MessageOf([&] { ReadSets(folder_ + "/none"); }), HasSubstr("cannot read the folder"));
}

TEST(MeasuredSet, EveryBuiltInSetNamesItsSourceAndLicence) {
  const std::vector<MeasuredSet> sets = BuiltInSets();
  std::size_t files = 0;
  for (const auto& file : std::filesystem::directory_iterator(KERF_SOURCE_DIR "/volumes/measured")) {
    files += file.path().extension() == ".toml";
  }
  EXPECT_EQ(sets.size(), files);
  for (const MeasuredSet& set : sets) {
    EXPECT_FALSE(set.citation.empty()) << set.name;
    EXPECT_FALSE(set.licence.empty()) << set.name;
    EXPECT_FALSE(set.values.empty() && set.trends.empty() && set.remarks.empty()) << set.name;
    // kerf must say what it assumes.
    EXPECT_EQ(set.assumptions.empty(), set.tool.kind == kToolNone) << set.name;
  }
}

}  // namespace
}  // namespace kerf
