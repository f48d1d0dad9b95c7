#include "session/run/expected_files.h"

#include <fmt/format.h>

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

std::string DescribeLackForLoop(const Scene& scene, double ticks, const std::string& folder,
                                const std::string& record) {
  if (!record.empty()) {
    const std::string lack = DescribeLackOfSpace(ListExpectedFiles(scene, ticks, "", record));
    if (!lack.empty()) return lack + "; the loop would end with its recording, before its time";
  }
  if (folder.empty()) return "";
  std::vector<ExpectedFile> files = ListExpectedFiles(scene, ticks, folder, record);
  std::string kept = "the loop itself goes on";
  if (!record.empty()) {
    files.erase(files.begin());
    const double room = CalcRoomForRecording(ticks);  // the recording's own bytes among it
    files.back().bytes += room;
    kept = fmt::format("{:.1f} MB of it stay free for the recording; the loop and its recording go on", 1e-6 * room);
  }
  const std::string lack = DescribeLackOfSpace(files);
  return lack.empty() ? "" : fmt::format("{}; {} without this table", lack, kept);
}

double CalcRoomForRecording(double ticks) {
  return std::min(kRoomBytes + kRoomBytesOfTick * ticks, kMostRoomBytes);
}

}  // namespace kerf
