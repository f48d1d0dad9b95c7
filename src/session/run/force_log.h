// forces.csv of `kerf loop`, a row for a tick: as text, as it comes into a file, and as the curve of a plot.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>

#include "base/core/thinned.h"
#include "base/files/files.h"
#include "kerf/coupled.h"
#include "kerf/geometry.h"

namespace kerf {

/// A row of forces.csv.
struct LoopRow {
  double time_s = 0;
  int skipped = 0;
  Vec3 p_WC_mm{0};  // handle: the coupling's point as the device tells it
  Vec3 p_WT_mm{0};  // tool
  Vec3 f_hand_N{0};
  Vec3 f_device_N{0};
  float cut_N = 0;  // on the tool, and the next two: magnitudes
  float face_N = 0;
  float friction_N = 0;
  float thrust_N = 0;
  float engaged_teeth = 0;
  float removed_mm3 = 0;  // in the tick
  float tick_us = 0;
  float late_us = 0;
  Fidelity fidelity = Fidelity::kFull;
  std::uint32_t status = 0;
};

/// The first line; `effects`: the columns of the effects, each behind a comma.
std::string FormatForceHeader(const std::string& effects);
/// Adds a line; `effects` as above.
void AppendForceRow(const LoopRow& row, const std::string& effects, std::string& csv);

/// The largest of a stretch of rows.
struct ForcePoint {
  double time_s = 0;  // where it begins
  double device_N = 0;
  double hand_N = 0;
  static ForcePoint Merge(const ForcePoint& a, const ForcePoint& b);
};
/// However long the loop: no spike is lost, and up to so many rows each is itself.
inline constexpr std::size_t kMostForcePoints = 20'000;
using ForceCurve = Thinned<ForcePoint, kMostForcePoints>;
ForcePoint MakeForcePoint(const LoopRow& row);

/// forces.csv, written as the rows come: its memory does not grow with the run. One thread. A disk that is full does
/// not stop the hand: what was written goes, which gives its room to the recording, and Commit() says so.
class ForceLog {
 public:
  /// The temporary stands beside `path`. `keep_free_bytes`: what it leaves free on the disk. Throws Error when it can't
  /// be made.
  ForceLog(const std::string& path, const std::string& effects, double keep_free_bytes = 0);
  void Take(const LoopRow& row, std::span<const double> channels);
  /// All rows are there: the file gets its name. Throws Error, also for what went wrong before. Once.
  void Commit();
  const std::string& path() const { return path_; }

 private:
  void Write();

  std::string path_;
  std::optional<GrowingFile> file_;  // none after a failure
  double keep_free_bytes_;
  std::string waiting_;
  std::string failure_;  // a sentence; empty when all went well
};

}  // namespace kerf
