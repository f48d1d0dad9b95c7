#include "base/files/markups.h"
#include "target.h"

namespace kerf::fuzz {

KERF_FUZZ_TARGET(markups) {
  const std::string text(bytes);
  Takes([&] { ParseMarkups(text, "fuzz.mrk.json"); });
  Takes([&] { ParseCurveMarkups(text, "fuzz.mrk.json"); });
  Takes([&] { ParsePlaneMarkups(text, "fuzz.mrk.json"); });
  Takes([&] { ParsePlaneMarkupList(text, "fuzz.mrk.json"); });
}

}  // namespace kerf::fuzz
