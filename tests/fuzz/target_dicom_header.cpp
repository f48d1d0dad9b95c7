#include <sstream>

#include "base/core/printable.h"
#include "bone/import/dicom_charset.h"
#include "bone/import/dicom_header.h"
#include "target.h"

namespace kerf::fuzz {

KERF_FUZZ_TARGET(dicom_header) {
  std::istringstream in{std::string(bytes)};
  Accepts([&] { CheckDicomHeader(in, "fuzz.dcm"); });
  // As a text: the character sets, a zero byte, the text.
  const std::size_t sets = bytes.find('\0');
  if (sets == std::string_view::npos) return;
  const std::string decoded = DecodeDicomText(bytes.substr(sets + 1), bytes.substr(0, sets));
  if (Printable(decoded) != decoded) Finding("a text is not printable");
}

}  // namespace kerf::fuzz
