#include "base/table/table.h"

#include <gtest/gtest.h>

#include <array>
#include <limits>

#include "base/core/csv.h"
#include "base/table/run_info.h"
#include "base/table/table_json.h"
#include "kerf/version.h"

namespace kerf {
namespace {

struct Tooth {
  int number = 0;
  std::string name;
  double force_N = 0;
  std::optional<double> bite_um;
  bool sharp = false;
  std::array<double, 2> p_mm{};
};

const Columns<Tooth>& ToothColumns() {
  static const Columns<Tooth> kColumns =
      JoinColumns<Tooth>({{{"number", "{}", "number of the tooth", &Tooth::number},
                           {"name", "{}", "name, as in a|b", &Tooth::name},
                           {"force_N", "{:.2f}", "force, and bite", &Tooth::force_N},
                           {"bite_um", "{}", "force, and bite", &Tooth::bite_um},
                           {"sharp", "{}", "true if it is sharp", [](const Tooth& t) { return t.sharp; }}},
                          PartsOf<Tooth>("tip_{}_mm", "xy", "{:g}", "its tip", &Tooth::p_mm)});
  return kColumns;
}

const std::vector<Tooth> kTeeth{{1, "=first, \"A\"", 1.005, 30.5, true, {1, 2.5}},
                                {-2, "plain", -7, {}, false, {0, 3}}};

TEST(Table, CsvHasAHeaderAndFormattedValues) {
  EXPECT_EQ(FormatCsv(ToothColumns(), kTeeth),
            "number,name,force_N,bite_um,sharp,tip_x_mm,tip_y_mm\n"
            "1,\"'=first, \"\"A\"\"\",1.00,30.5,true,1,2.5\n"
            "-2,plain,-7.00,,false,0,3\n");
  EXPECT_EQ(CsvHeader(ToothColumns()) + "\n", FormatCsv(ToothColumns(), {}));
}

TEST(Table, CsvReadsBack) {
  std::vector<std::string> names;
  ReadCsv(FormatCsv(ToothColumns(), kTeeth), "a.csv", NamesOf(ToothColumns()),
          [&](const std::vector<std::string>& fields, const CsvPlace&) { names.push_back(fields[1]); });
  EXPECT_EQ(names, (std::vector<std::string>{"=first, \"A\"", "plain"}));
}

TEST(Table, ATextWithItsOwnFormatIsWrittenAsTheFormatSays) {
  const Columns<Tooth> quoted{{"name", "\"{}\"", "", &Tooth::name}};
  EXPECT_EQ(FormatCsv(quoted, {kTeeth[1]}), "name\n\"plain\"\n");
}

TEST(Table, JsonKeepsOrderAndRoundsAsTheFormatSays) {
  std::vector<Tooth> teeth = kTeeth;
  teeth[1].force_N = std::numeric_limits<double>::infinity();
  EXPECT_EQ(RowsJson(ToothColumns(), teeth).dump(),
            R"([{"number":1,"name":"=first, \"A\"","force_N":1.0,"bite_um":30.5,"sharp":true,"tip_x_mm":1.0,)"
            R"("tip_y_mm":2.5},{"number":-2,"name":"plain","force_N":null,"bite_um":null,"sharp":false,"tip_x_mm":0.0,)"
            R"("tip_y_mm":3.0}])");
  EXPECT_EQ(RowsJson(ToothColumns(), {}).dump(), "[]");
}

TEST(Table, DescriptionJoinsNeighboursOfTheSameMeaning) {
  EXPECT_EQ(DescribeColumns(ToothColumns()),
            "| column | meaning |\n|---|---|\n"
            "| `number` | number of the tooth |\n"
            "| `name` | name, as in a\\|b |\n"
            "| `force_N`, `bite_um` | force, and bite |\n"
            "| `sharp` | true if it is sharp |\n"
            "| `tip_x_mm`, `tip_y_mm` | its tip |\n");
}

TEST(Table, ATextTableIsAlignedOnATerminal) {
  TextTable table({"case", "p50 (us)", "bone"});
  table.Add({"disc", 12.5, "`0a`"});
  table.Add({"a longer one", "-"});
  EXPECT_EQ(table.FormatTerminal("  "),
            "  case          p50 (us)  bone\n"
            "  disc              12.5    0a\n"
            "  a longer one         -\n");
  EXPECT_EQ(table.FormatMarkdown(),
            "| case | p50 (us) | bone |\n|---|---|---|\n| disc | 12.5 | `0a` |\n| a longer one | - | |\n");
}

TEST(Table, MeasuredNumbersInJson) {
  EXPECT_EQ(RoundedJson(1234567.8).dump(), "1234570.0");
  EXPECT_EQ(RoundedJson(0.123456789, 3).dump(), "0.123");
  EXPECT_TRUE(RoundedJson(std::numeric_limits<double>::quiet_NaN()).is_null());
  EXPECT_TRUE(OrNull(std::optional<int>()).is_null());
  EXPECT_EQ(TimesJson({3, 1, 2, 3, 4.00000049}).dump(),
            R"({"ticks":3,"p50_us":1.0,"p99_us":2.0,"p999_us":3.0,"max_us":4.0})");
  EXPECT_EQ(DumpJson({{"a", "\xff"}}), "{\n  \"a\": \"\xEF\xBF\xBD\"\n}\n");
}

TEST(RunInfo, OneSentenceAndOneObjectDescribeTheRun) {
  RunInfo run;
  run.cpu = "a processor";
  run.cores = 1;
  run.load = 0.25;
  const std::string commit = std::string("; commit ") + CommitString();
  EXPECT_EQ(DescribeRun(run), "a processor, 1 core; load 0.2 before the run" + commit);
  run.cores = 2;
  run.core = 1;
  run.realtime = true;
  run.vector_width = "AVX2";
  EXPECT_EQ(DescribeRun(run),
            "a processor, 2 cores, core 1 with real-time priority, AVX2; load 0.2 before the run" + commit);
  EXPECT_EQ(RunJson(run)["machine"].dump(),
            R"({"cpu":"a processor","cores":2,"load_before":0.25,"core":1,"realtime":true,"vector_width":"AVX2"})");
  EXPECT_EQ(RunJson({})["machine"]["core"], nullptr);
  EXPECT_GT(ReadRunInfo().cores, 0);
}

}  // namespace
}  // namespace kerf
