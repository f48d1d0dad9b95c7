#include "experiment/study/study_file.h"
#include "target.h"

namespace kerf::fuzz {

KERF_FUZZ_TARGET(study_json) {
  Accepts([&] { SpecFromJson(std::string(bytes)); });
}

}  // namespace kerf::fuzz
