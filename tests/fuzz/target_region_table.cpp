#include "bone/material/region_table.h"
#include "target.h"

namespace kerf::fuzz {

KERF_FUZZ_TARGET(region_table) {
  MaterialTable table;
  if (!Accepts([&] { table = ParseRegionTable(std::string(bytes), "fuzz.csv"); })) return;
  const std::string text = FormatRegionTable(table);
  MaterialTable again;
  if (!Accepts([&] { again = ParseRegionTable(text, "fuzz.csv"); })) Finding("the written table is refused");
  if (FormatRegionTable(again) != text) Finding("the table changes when it is written and read back");
}

}  // namespace kerf::fuzz
