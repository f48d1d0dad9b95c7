#include "bone/material/region_table.h"
#include "target.h"

namespace kerf::fuzz {

KERF_FUZZ_TARGET(region_table) {
  MaterialTable table;
  if (!Takes([&] { table = ParseRegionTable(std::string(bytes), "fuzz.csv"); })) return;
  const std::string text = FormatRegionTable(table);
  MaterialTable again;
  if (!Takes([&] { again = ParseRegionTable(text, "fuzz.csv"); })) Finding("the written table is refused");
  if (FormatRegionTable(again) != text) Finding("the written table reads back as another");
}

}  // namespace kerf::fuzz
