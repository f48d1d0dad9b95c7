#include "bone/material/ct_law_table.h"
#include "target.h"

namespace kerf::fuzz {

KERF_FUZZ_TARGET(ct_laws) {
  const std::string text(bytes);
  Takes([&] { ParseCalibration(text); });
  std::vector<CtLaw> laws;
  if (!Takes([&] { laws = ParseCtLaws(text, "fuzz.csv"); })) return;
  for (const CtLaw& law : laws) Takes([&] { WithCalibration(law, ""); });
  const std::string written = FormatCtLaws(laws);
  std::vector<CtLaw> again;
  if (!Takes([&] { again = ParseCtLaws(written, "fuzz.csv"); })) Finding("the written laws are refused");
  if (FormatCtLaws(again) != written) Finding("the written laws read back as others");
}

}  // namespace kerf::fuzz
