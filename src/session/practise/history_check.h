// Whether the rows of a history are what was kept, and which of them are of one recording.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "session/practise/history.h"

namespace kerf {

/// SHA-256, as hexadecimal digits. Against accidents and changes by hand; who recomputes them all leaves no trace.
struct RowSums {
  std::string own;    // of what the row holds
  std::string chain;  // of that and of the chain up to the row before it
};
RowSums CalcRowSums(const Attempt& row, const std::string& chain_before);

/// Fills Attempt::doubles and more_doubles. Attempts that have the file, the steps or the beginning in common are of
/// one group, also by way of a third one.
void FindDoubles(std::vector<Attempt>& attempts);

/// The measures of the attempt's sheet, an object of objects; empty where the text is not such a sheet, or is too long
/// or too deeply nested for one.
nlohmann::ordered_json ParseMeasures(const Attempt& attempt);
/// Of what ParseMeasures() gives.
std::optional<double> FindValue(const nlohmann::ordered_json& measures, const std::string& key);

}  // namespace kerf
