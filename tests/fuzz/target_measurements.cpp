#include "experiment/calibration/measurements.h"

#include "target.h"

namespace kerf::fuzz {

KERF_FUZZ_TARGET(measurements) {
  Measurements data;
  if (!Accepts([&] { data = ParseMeasurements(std::string(bytes), "fuzz.csv"); })) return;
  if (data.observations.empty()) Finding("data without a value are accepted");
  for (const ForceObservation& o : data.observations) {
    if (!(o.force_N >= 0 && o.bite_mm > 0 && o.width_mm > 0 && o.row < data.rows())) Finding("a value is not valid");
  }
  for (const std::size_t group : data.group_of_row) {
    if (group >= data.groups) Finding("a row is in no group");
  }
}

}  // namespace kerf::fuzz
