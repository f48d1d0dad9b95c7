#include "device/drivers/wooden_config.h"

#include <fmt/format.h>

#include <cmath>

#include "base/files/files.h"
#include "base/toml/faults.h"
#include "base/toml/table_reader.h"
#include "base/toml/toml_document.h"
#include "device/devices/hid/wooden_driver.h"
#include "device/devices/hid/wooden_kinematics.h"

namespace kerf {
namespace {

constexpr std::size_t kMaxConfigBytes = 64 << 10;

void CheckEach(TableReader& reader, const char* key, const Vec3& values, double min_size) {
  for (int i = 0; i < 3; ++i) {
    if (std::abs(values[i]) >= min_size) continue;
    reader.Fault(key, fmt::format("{}[{}] = {} is too close to 0; it must be {} or more, or {} or less", key, i,
                                  values[i], min_size, -min_size));
  }
}

}  // namespace

WoodenParams ParseWoodenConfig(const std::string& text, const std::string& file) {
  const TomlNode root = ParseToml(text, file);
  Faults faults(file);
  TableReader reader(root, "the file", faults);
  WoodenParams params;
  Describe(params, reader);
  reader.Finish();
  CheckEach(reader, "counts_per_turn", params.counts_per_turn, 1);
  CheckEach(reader, "gear", params.gear, 0.1);
  for (int i = 0; i < 3; ++i) {
    const double counts = std::abs(params.counts_per_turn[i] * params.gear[i]);
    if (counts <= kWoodenMaxCountsPerTurn) continue;
    reader.Fault("gear", fmt::format("gear[{}] gives {:.0f} counts per turn of the joint with counts_per_turn; it must "
                                     "give at most {:.0f}, because counts in the reports have 16 bits",
                                     i, counts, kWoodenMaxCountsPerTurn));
  }
  if (faults.empty() && !FindWoodenAngles(params, Vec3{0})) {
    reader.Fault("middle_mm", "the arm can't reach middle_mm; check base_mm, upper_arm_mm and forearm_mm");
  }
  faults.ThrowIfAny();
  return params;
}

WoodenParams ReadWoodenConfig(const std::string& path) {
  return ParseWoodenConfig(ReadTextFile(path, kMaxConfigBytes), path);
}

}  // namespace kerf
