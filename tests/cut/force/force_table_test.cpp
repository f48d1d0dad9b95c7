// The table of the law `tabulated`: interpolation and refusals.
#include <gtest/gtest.h>

#include <memory>
#include <string>

#include "kerf/force.h"
#include "support/message_of.h"
#include "support/saw.h"
#include "support/tooth_cut.h"

namespace kerf {
namespace {

const std::string kHeader = "tissue,bite_um,thrust_N_per_mm,cutting_N_per_mm,source\n";

ForceTable Parse(const std::string& rows) {
  return ParseForceTable(kHeader + rows, "t.csv");
}
std::string Refusal(const std::string& rows) {
  return test::MessageOf([&] { Parse(rows); }, "accepted");
}

TEST(ForceTable, ForcesAreLinearBetweenRowsFromZeroAndBeyond) {
  ForceLaw law("tabulated");
  law.SetTable(
      std::make_shared<const ForceTable>(Parse("cortical,2,8,6,test\ncortical,4,10,5,test\ncortical,8,11,4,test\n")));
  const ToothForce force = MakeToothForce(law, kSaw);
  const double w = kSaw.thickness_mm;
  for (const auto& [um, thrust, cutting] :
       {std::tuple{1.0, 4.0, 3.0}, std::tuple{2.0, 8.0, 6.0}, std::tuple{3.0, 9.0, 5.5}, std::tuple{8.0, 11.0, 4.0},
        std::tuple{16.0, 13.0, 2.0}, std::tuple{32.0, 17.0, 0.0}}) {
    EXPECT_NEAR(force(1e-3 * um, Cortical(1)), w * thrust, 1e-12) << um;
    EXPECT_NEAR(force.Cutting(1e-3 * um, Cortical(1)), w * cutting, 1e-12) << um;  // never below 0
  }
  // A mixture of tissues; the table has no cancellous bone, which then counts as no force.
  ToothCut half = Cortical(1);
  half.tissue = {0.5, 0.5};
  EXPECT_NEAR(force(3e-3, half), 0.5 * w * 9, 1e-12);
  law.Set("scale", 3);
  EXPECT_NEAR(MakeToothForce(law, kSaw)(3e-3, Cortical(1)), 3 * w * 9, 1e-12);
  // The smallest ratio is that of the changes from the second row to the third, 1 / 1.
  EXPECT_NEAR(force.least_thrust_per_cutting, 1, 1e-12);
}

TEST(ForceTable, FaultsNameTheLine) {
  EXPECT_EQ(Refusal("cortical,2,8,6,test\ncortical,4,10,5,test\n"), "accepted");
  EXPECT_EQ(Refusal("cortikal,2,8,6,test\n"),
            "t.csv:2: tissue = \"cortikal\" is unknown; it must be \"cortical\" or \"cancellous\" or \"tooth\" or "
            "\"canal\" or \"other\"");
  EXPECT_EQ(Refusal("cortical,2,8,6,test\ncortical,2,9,6,test\n"),
            "t.csv:3: the bites of cortical must increase from row to row, by at least 1 %");
  EXPECT_EQ(Refusal("cortical,2,8,6,test\ncortical,4,7.9,6,test\n"),
            "t.csv:3: the thrust in cortical falls as the bite grows; a tool in a hand would have no unique motion");
  EXPECT_EQ(Refusal("cortical,2,-8,6,test\n"),
            "t.csv:2: thrust_N_per_mm = -8 is below 0; valid range 0 to 1000000 N/mm");
  EXPECT_EQ(Refusal("cortical,0,8,6,test\n"), "t.csv:2: bite_um = 0 is below 0.001; valid range 0.001 to 1000 um");
  EXPECT_EQ(Refusal("cortical,2,8,6,\n"), "t.csv:2: the source is empty; state where the numbers come from");
  EXPECT_EQ(Refusal("cortical,2,8,6,test\n"), "t.csv: there is one row for cortical; at least two bites are needed");
  EXPECT_EQ(Refusal(""), "t.csv: there are no rows");
  EXPECT_EQ(test::MessageOf([] { ForceLaw("hertz_chip").SetTable(nullptr); }),
            "the force law hertz_chip reads no table");
}

}  // namespace
}  // namespace kerf
