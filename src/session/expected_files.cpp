#include "session/expected_files.h"

#include <algorithm>

namespace kerf {
namespace {

constexpr double kLeastRowBytes = 100;  // of forces.csv: a tool at rest, in the air
constexpr double kLeastTickBytes = 2;   // of a recording
constexpr double kRoomBytesOfTick = 12;
constexpr double kRoomBytes = 1e6;
constexpr double kMostRoomBytes = 64e6;

}  // namespace

std::vector<ExpectedFile> ListExpectedFiles(const Scene& scene, double ticks, const std::string& folder,
                                            const std::string& record) {
  std::vector<ExpectedFile> files;
  // The recording first, as it is what can't be made again.
  if (!record.empty()) files.push_back({record, kLeastTickBytes * ticks});
  const double rows = ticks / std::max(scene.output.forces_every_ticks, 1);
  if (!folder.empty()) files.push_back({folder + "/forces.csv", kLeastRowBytes * rows});
  return files;
}

double CalcRoomForRecording(double ticks) {
  return std::min(kRoomBytes + kRoomBytesOfTick * ticks, kMostRoomBytes);
}

}  // namespace kerf
