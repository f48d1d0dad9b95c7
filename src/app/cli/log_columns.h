// The columns of `kerf log --csv`.
#pragma once

#include <cstdint>

#include "base/table/table.h"
#include "loop/record/recording.h"

namespace kerf::cli {

/// A recorded state, of which there are a hundred per second, and the step in which it was recorded.
struct LogStateRow {
  const RecordedState& state;
  const RecordedStep& step;
};
const Columns<LogStateRow>& LogStateColumns();

/// The inputs of a tick, with `--ticks`.
struct LogTickRow {
  std::uint64_t number = 0;
  double time_s = 0;
  const RecordedStep& step;
};
const Columns<LogTickRow>& LogTickColumns();

}  // namespace kerf::cli
