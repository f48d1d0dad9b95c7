#include "base/files/catalogue.h"
#include "target.h"

namespace kerf::fuzz {

/// A compiled catalogue, then, after a line of '=', a text to be translated.
KERF_FUZZ_TARGET(catalogue) {
  static const MemoryFolder folder;
  const std::size_t end = bytes.rfind("\n=\n");
  const std::string path = folder.Write("kerf.mo", bytes.substr(0, end));
  Accepts([&] {
    const Catalogue catalogue(path);
    const std::string text(end == std::string_view::npos ? "a text" : bytes.substr(end + 3));
    catalogue.Translate(text);
    if (catalogue.point().size() != 1) Finding("a decimal separator that is no character");
  });
}

}  // namespace kerf::fuzz
