#include "base/files/markups.h"
#include "target.h"

namespace kerf::fuzz {

KERF_FUZZ_TARGET(markups) {
  const std::string text(bytes);
  Accepts([&] { ParseMarkups(text, "fuzz.mrk.json"); });
  Accepts([&] { ParseCurveMarkups(text, "fuzz.mrk.json"); });
  Accepts([&] { ParsePlaneMarkups(text, "fuzz.mrk.json"); });
  Accepts([&] { ParsePlaneMarkupList(text, "fuzz.mrk.json"); });
}

}  // namespace kerf::fuzz
