// Whether the rows of a history are what was kept, and which of them are of one recording.
#pragma once

#include <string>
#include <vector>

#include "practise/history.h"

namespace kerf {

/// SHA-256, as hexadecimal digits. Against accidents and changes by hand; who recomputes them all leaves no trace.
struct RowSums {
  std::string own;    // of what the row holds
  std::string chain;  // of that and of the chain up to the row before it
};
RowSums CalcRowSums(const Attempt& row, const std::string& chain_before);

/// Fills Attempt::doubles of those with the same steps, or of the same file where the steps are not known.
void FindDoubles(std::vector<Attempt>& attempts);

}  // namespace kerf
