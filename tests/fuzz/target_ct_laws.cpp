#include "bone/material/ct_law_table.h"
#include "target.h"

namespace kerf::fuzz {

KERF_FUZZ_TARGET(ct_laws) {
  const std::string text(bytes);
  Accepts([&] { ParseCalibration(text); });
  std::vector<CtLaw> laws;
  if (!Accepts([&] { laws = ParseCtLaws(text, "fuzz.csv"); })) return;
  for (const CtLaw& law : laws) Accepts([&] { WithCalibration(law, ""); });
  const std::string written = FormatCtLaws(laws);
  std::vector<CtLaw> again;
  if (!Accepts([&] { again = ParseCtLaws(written, "fuzz.csv"); })) Finding("the written laws are refused");
  if (FormatCtLaws(again) != written) Finding("the laws change when they are written and read back");
}

}  // namespace kerf::fuzz
