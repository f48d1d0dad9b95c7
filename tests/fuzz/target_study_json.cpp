#include "base/files/json_text.h"
#include "experiment/study/study_file.h"
#include "target.h"

namespace kerf::fuzz {

KERF_FUZZ_TARGET(study_json) {
  Accepts([&] {
    const std::string text(bytes);
    CheckJsonDepth(text, "it");
    SpecFromJson(nlohmann::ordered_json::parse(text, nullptr, false));
  });
}

}  // namespace kerf::fuzz
