// Checks that the rows of a history are unchanged, and finds attempts with the same recording.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "session/practise/history.h"

namespace kerf {

/// Checksums of a row: SHA-256 in hexadecimal digits. They reveal accidental and manual changes, but not changes after
/// which all checksums were recomputed.
struct RowSums {
  std::string own;    // of the row's contents
  std::string chain;  // of `own` and of the chain up to the previous row
};
RowSums CalcRowSums(const Attempt& row, const std::string& chain_before);

/// Sets Attempt::duplicates and more_duplicates. Attempts with the same file, steps or beginning form a group, and
/// groups with a common attempt are merged.
void FindDuplicates(std::vector<Attempt>& attempts);

/// Returns the measures of the attempt's sheet, an object of objects; empty if the text is not such a sheet, or is too
/// long or too deeply nested.
nlohmann::ordered_json ParseMeasures(const Attempt& attempt);
/// Returns a value from the result of ParseMeasures().
std::optional<double> FindValue(const nlohmann::ordered_json& measures, const std::string& key);

}  // namespace kerf
