#include <nlohmann/json.hpp>

#include "experiment/study/study_file.h"
#include "target.h"

namespace kerf::fuzz {

KERF_FUZZ_TARGET(study_file) {
  StudySpec spec;
  if (!Accepts([&] { spec = ParseStudy(std::string(bytes), "/nowhere/fuzz.toml", {"entry", "slot", "mandible"}); }))
    return;
  // The description that a study keeps in its folder must be equal when it is read back.
  const std::string kept = SpecToJson(spec).dump();
  if (SpecToJson(SpecFromJson(nlohmann::ordered_json::parse(kept))).dump() != kept)
    Finding("the study's description changes when it is written and read back");
}

}  // namespace kerf::fuzz
