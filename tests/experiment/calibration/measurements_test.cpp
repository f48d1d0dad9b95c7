// Reading of measured forces: values, and the message of each mistake.
#include "experiment/calibration/measurements.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "support/message_of.h"

namespace kerf {
namespace {

TEST(Measurements, AreReadInAnyOrderOfColumns) {
  const Measurements data = ParseMeasurements(
      "# a comment\n"
      "thrust_N,specimen,width_mm,bite_mm,cutting_N,speed_mm_per_s\n"
      "7.5,A,0.64,0.0025,,2000\n"
      "8,\"B, left\",0.5,0.004,5,3000\n"
      ",A,0.5,0.004,5.5,3000\n",
      "data.csv");
  EXPECT_EQ(data.rows(), 3u);
  EXPECT_EQ(data.specimens, 2u);
  EXPECT_EQ(data.groups, 2u);
  EXPECT_EQ(data.group_of_row, (std::vector<std::size_t>{0, 1, 0}));
  ASSERT_EQ(data.observations.size(), 4u);
  EXPECT_EQ(data.observations[0].force_N, 7.5);
  EXPECT_EQ(data.observations[0].width_mm, 0.64);
  EXPECT_EQ(data.observations[2].component, ForceComponent::kCutting);
  EXPECT_EQ(data.observations[2].force_N, 5);
  EXPECT_EQ(*data.observations[3].speed_mm_per_s, 3000);
}

TEST(Measurements, TorqueIsDividedByTheRadiusAndTheWidthIsThatOfAllTeeth) {
  const Measurements data = ParseMeasurements(
      "bite_mm,width_mm,teeth,torque_N_mm,torque_sd_N_mm,radius_mm\n0.06,1.6,2,24,3,0.8\n", "data.csv");
  EXPECT_EQ(data.observations[0].component, ForceComponent::kCutting);
  EXPECT_DOUBLE_EQ(data.observations[0].force_N, 30);
  EXPECT_DOUBLE_EQ(data.observations[0].sd_N, 3.75);
  EXPECT_DOUBLE_EQ(data.observations[0].width_mm, 3.2);
}

TEST(Measurements, OneSpecimenIsResampledByRows) {
  const Measurements data =
      ParseMeasurements("bite_mm,width_mm,thrust_N,specimen\n0.003,1,5,A\n0.004,1,6,A\n", "data.csv");
  EXPECT_EQ(data.specimens, 1u);
  EXPECT_EQ(data.groups, 2u);
  EXPECT_EQ(data.group_of_row, (std::vector<std::size_t>{0, 1}));
}

struct Mistake {
  const char* text;
  const char* message;
};

class MeasurementMistake : public ::testing::TestWithParam<Mistake> {};

TEST_P(MeasurementMistake, IsReportedWithItsPlace) {
  EXPECT_EQ(test::MessageOf([&] { ParseMeasurements(GetParam().text, "data.csv"); }), GetParam().message);
}

INSTANTIATE_TEST_SUITE_P(
    All, MeasurementMistake,
    ::testing::Values(
        Mistake{"", "data.csv: no header; it needs bite_mm, width_mm and a force"},
        Mistake{"# only this\n", "data.csv: no header; it needs bite_mm, width_mm and a force"},
        Mistake{"bite_mm,width_mm,thrust_N\n", "data.csv: no rows below the header"},
        Mistake{"bite_mm,width_mm,thrust_N\n0.004,0.64,0\n0.005,0.64,0\n", "data.csv: all forces are 0"},
        Mistake{"\nbite,width_mm,thrust_N\n", "data.csv:2: unknown column \"bite\"; did you mean \"bite_mm\"?"},
        Mistake{"bite_mm,width_mm,thrust_kN\n", "data.csv:1: unknown column \"thrust_kN\"; did you mean \"thrust_N\"?"},
        Mistake{"bite_mm,width_mm,colour_of_bone\n",
                "data.csv:1: unknown column \"colour_of_bone\"; the columns are bite_mm, width_mm, teeth, "
                "speed_mm_per_s, thrust_N, thrust_sd_N, cutting_N, cutting_sd_N, torque_N_mm, torque_sd_N_mm, "
                "radius_mm, specimen"},
        Mistake{"bite_mm,bite_mm,width_mm,thrust_N\n0.01,0.01,1,5\n", "data.csv:1: column \"bite_mm\" is given twice"},
        Mistake{"width_mm,thrust_N\n1,5\n", "data.csv:1: column \"bite_mm\" is missing"},
        Mistake{"bite_mm,width_mm\n0.01,1\n",
                "data.csv:1: no measured force; give a column thrust_N, cutting_N or torque_N_mm"},
        Mistake{"bite_mm,width_mm,torque_N_mm\n0.01,1,5\n",
                "data.csv:1: column \"radius_mm\" is missing; a torque needs the radius at which the force acts"},
        Mistake{"bite_mm,width_mm,thrust_sd_N,cutting_N\n0.01,1,5,5\n",
                "data.csv:1: column \"thrust_N\" is missing; \"thrust_sd_N\" is its standard deviation"},
        Mistake{"bite_mm,width_mm,cutting_N,cutting_sd_N,torque_N_mm,radius_mm\n0.01,1,5,1,,2\n",
                "data.csv:1: standard deviations are given for only one of cutting_N and torque_N_mm"},
        Mistake{"bite_mm,width_mm,thrust_N\n0.01,1,5\n0.01,1,-5\n",
                "data.csv:3: thrust_N = -5 is below 0; valid range 0 to 100000 N"},
        Mistake{"bite_mm,width_mm,thrust_N\n0.01,1,nan\n", "data.csv:2: thrust_N = \"nan\" is not a number"},
        Mistake{"bite_mm,width_mm,thrust_N\n2.5,1,5\n",
                "data.csv:2: bite_mm = 2.5 is above 1; valid range 1e-06 to 1 mm"},
        Mistake{"bite_mm,width_mm,thrust_N\n,1,5\n", "data.csv:2: bite_mm is empty"},
        Mistake{"bite_mm,width_mm,thrust_N\n0.01,1,\n", "data.csv:2: the row has no force and no torque"},
        Mistake{"bite_mm,width_mm,thrust_N,thrust_sd_N\n0.01,1,5,\n", "data.csv:2: thrust_sd_N is empty"},
        Mistake{"bite_mm,width_mm,thrust_N,thrust_sd_N\n0.01,1,5,0\n",
                "data.csv:2: thrust_sd_N = 0 is below 1e-09; valid range 1e-09 to 100000 N"},
        Mistake{"bite_mm,width_mm,thrust_N,thrust_sd_N,cutting_N\n0.01,1,,1,5\n",
                "data.csv:2: thrust_sd_N is given without thrust_N"},
        Mistake{"bite_mm,width_mm,thrust_N,specimen\n0.01,1,5,\n", "data.csv:2: specimen is empty"},
        Mistake{"bite_mm,width_mm,thrust_N\n0.01,1\n",
                "data.csv:2: 2 fields instead of 3; a field with a comma must be in double quotes"}));

}  // namespace
}  // namespace kerf
