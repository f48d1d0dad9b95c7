// Records as JSON. Numbers are the same bit for bit after writing and reading; hashes have 16 hexadecimal digits.
#pragma once

#include <cstdint>
#include <nlohmann/json.hpp>
#include <string>

#include "experiment/study/records.h"

namespace kerf {

std::string_view ToString(CaseState state);  // "done", "failed", "omitted"

// These throw Error or nlohmann::json::exception for invalid input.
Holding HoldingFromString(const std::string& text);
CaseState StateFromString(const std::string& text);
std::uint64_t HashFromText(const std::string& text);

nlohmann::ordered_json ToJson(const ErrorFigures& errors);
nlohmann::ordered_json ToJson(const CostFigures& costs);
nlohmann::ordered_json ToJson(const ReferenceRecord& reference);
nlohmann::ordered_json ToJson(const RunInfo& machine);
ErrorFigures ErrorsFromJson(const nlohmann::ordered_json& json);
CostFigures CostsFromJson(const nlohmann::ordered_json& json);
ReferenceRecord ReferenceFromJson(const nlohmann::ordered_json& json);
RunInfo MachineFromJson(const nlohmann::ordered_json& json);

}  // namespace kerf
