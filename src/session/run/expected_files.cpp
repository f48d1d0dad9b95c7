#include "session/run/expected_files.h"

#include <fmt/format.h>

#include <algorithm>

namespace kerf {
namespace {

constexpr double kMinRowBytes = 100;  // of forces.csv: a tool at rest in air
constexpr double kMinTickBytes = 2;   // of a recording
constexpr double kRoomBytesPerTick = 12;
constexpr double kRoomBytes = 1e6;
constexpr double kMaxRoomBytes = 64e6;

}  // namespace

std::vector<ExpectedFile> ListExpectedFiles(const Scene& scene, double ticks, const std::string& folder,
                                            const std::string& record) {
  std::vector<ExpectedFile> files;
  // The recording comes first because it cannot be reproduced.
  if (!record.empty()) files.push_back({record, kMinTickBytes * ticks});
  const double rows = ticks / std::max(scene.output.forces_every_ticks, 1);
  if (!folder.empty()) files.push_back({folder + "/forces.csv", kMinRowBytes * rows});
  return files;
}

std::string DescribeLackForLoop(const Scene& scene, double ticks, const std::string& folder,
                                const std::string& record) {
  if (!record.empty()) {
    const std::string lack = DescribeLackOfSpace(ListExpectedFiles(scene, ticks, "", record));
    if (!lack.empty()) return lack + "; the loop would end early, with its recording";
  }
  if (folder.empty()) return "";
  std::vector<ExpectedFile> files = ListExpectedFiles(scene, ticks, folder, record);
  std::string kept = "the loop itself continues";
  if (!record.empty()) {
    files.erase(files.begin());
    const double room = CalcRoomForRecording(ticks);  // includes the recording's own bytes
    files.back().bytes += room;
    kept =
        fmt::format("{:.1f} MB of it remain free for the recording; the loop and its recording continue", 1e-6 * room);
  }
  const std::string lack = DescribeLackOfSpace(files);
  return lack.empty() ? "" : fmt::format("{}; {} without this table", lack, kept);
}

double CalcRoomForRecording(double ticks) {
  return std::min(kRoomBytes + kRoomBytesPerTick * ticks, kMaxRoomBytes);
}

}  // namespace kerf
