#include "device/devices/force_table.h"

#include <algorithm>

namespace kerf {

std::vector<ForceTableRow> CalcForceTable(const std::vector<DeviceProfile>& profiles, double expected_N) {
  CheckRange("expected_N", expected_N, kExpectedPeakRange_N);
  std::vector<ForceTableRow> table;
  for (const DeviceProfile& profile : profiles) {
    ForceTableRow row;
    row.profile = profile;
    row.scale = std::min(1.0, profile.peak_force_N / expected_N);
    row.largest_N = profile.peak_force_N / row.scale;
    row.masked_N = profile.friction_N / row.scale;
    row.lasting_N = std::min(profile.continuous_force_N, profile.peak_force_N) / row.scale;
    row.lasting_fraction = row.lasting_N / row.largest_N;
    row.range = row.masked_N > 0 ? row.largest_N / row.masked_N : 0;
    table.push_back(std::move(row));
  }
  return table;
}

}  // namespace kerf
