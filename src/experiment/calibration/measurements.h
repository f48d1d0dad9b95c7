// Measured forces on cutting teeth, read from a CSV file.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "experiment/calibration/law_model.h"
#include "kerf/describe.h"

namespace kerf {

/// One measured value of one component.
struct ForceObservation {
  ForceComponent component;
  double bite_mm;
  double width_mm;  // of all teeth that shared the force
  std::optional<double> speed_mm_per_s;
  double force_N;
  double sd_N;      // 0: not given; then it is not given for any value of this component
  std::size_t row;  // index of the row in the file
};

struct Measurements {
  std::vector<ForceObservation> observations;
  /// For each row, the group with which the bootstrap resamples it: its specimen, or, if the file names fewer than two
  /// specimens, the row itself.
  std::vector<std::size_t> group_of_row;
  std::size_t groups = 0;
  std::size_t specimens = 0;  // 0: the file has no column "specimen"

  std::size_t rows() const { return group_of_row.size(); }
};

/// A column that the file may have.
struct MeasurementColumn {
  const char* name;
  Range range;  // of its numbers; for the text column not used
  const char* meaning;
};
/// The columns, in the order of the documentation.
const std::vector<MeasurementColumn>& MeasurementColumns();

/// Parses a CSV file with the columns `bite_mm`, `width_mm`, at least one of force or torque, and any of the others. A
/// torque is converted to a cutting force. An empty force means that the row has none. Throws kerf::Error with file,
/// line and column at the first error. `file` is the name in messages.
Measurements ParseMeasurements(const std::string& text, const std::string& file);

}  // namespace kerf
