#include <sstream>

#include "bone/import/dicom_header.h"
#include "target.h"

namespace kerf::fuzz {

KERF_FUZZ_TARGET(dicom_header) {
  std::istringstream in{std::string(bytes)};
  Accepts([&] { CheckDicomHeader(in, "fuzz.dcm"); });
}

}  // namespace kerf::fuzz
