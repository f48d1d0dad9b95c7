#include "base/files/markups.h"
#include "target.h"

namespace kerf::fuzz {

KERF_FUZZ_TARGET(markups) {
  const std::string text(bytes);
  Accepts([&] { ParseMarkups(text, "fuzz.mrk.json"); });
  Accepts([&] { ParseCurveMarkups(text, "fuzz.mrk.json"); });
  Accepts([&] { ParsePlaneMarkups(text, "fuzz.mrk.json"); });
  Accepts([&] { ParsePlaneMarkupList(text, "fuzz.mrk.json"); });
  std::vector<TubeMarkup> curves;
  if (Accepts([&] { curves = ParseTubeMarkups(text, "fuzz.mrk.json"); })) {
    if (ParseTubeMarkups(FormatTubeMarkups(curves), "again.mrk.json").size() != curves.size()) {
      Finding("curves that are written are not all read back");
    }
  }
}

}  // namespace kerf::fuzz
