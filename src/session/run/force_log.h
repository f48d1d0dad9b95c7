// forces.csv of `kerf loop`, with one row per tick: formats the rows, writes them during the loop, and reduces them to
// a curve for a plot.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>

#include "base/core/thinned.h"
#include "base/files/files.h"
#include "base/table/table.h"
#include "kerf/coupled.h"
#include "kerf/geometry.h"
#include "loop/haptics/loop_body.h"

namespace kerf {

/// A row of forces.csv: a quarter of a LoopTick, since with LoopLog::kMemory the rows of the whole loop are kept.
struct LoopRow {
  double time_s = 0;
  std::uint32_t skipped = 0;
  Vec3 p_WC_mm{0};  // handle: the coupling's point as reported by the device
  Vec3 p_WT_mm{0};  // tool
  Vec3 f_hand_N{0};
  Vec3 f_device_N{0};
  float cut_N = 0;  // magnitude of the cutting force on the tool; likewise the next two
  float face_N = 0;
  float friction_N = 0;
  float thrust_N = 0;
  float engaged_teeth = 0;
  float removed_mm3 = 0;  // in this tick
  float tick_us = 0;
  float late_us = 0;
  Fidelity fidelity = Fidelity::kFull;
  std::uint32_t status = 0;
};

const Columns<LoopRow>& LoopColumns();
/// `p_TC_mm`: the coupling's point in the tool frame. `removed_mm3`: volume removed since the previous row.
LoopRow MakeLoopRow(const LoopTick& tick, const Vec3& p_TC_mm, double removed_mm3);
/// Returns the header line. `effects`: columns of the effects, each preceded by a comma.
std::string FormatForceHeader(const std::string& effects);
/// Appends a line to `csv`; `effects` as above.
void AppendForceRow(const LoopRow& row, const std::string& effects, std::string& csv);

/// Maxima over an interval of rows.
struct ForcePoint {
  double time_s = 0;  // start of the interval
  double device_N = 0;
  double hand_N = 0;
  static ForcePoint Merge(const ForcePoint& a, const ForcePoint& b);
};
/// Maximum number of points of the curve, however long the loop. No spike is lost. If there are at most this many rows,
/// each has its own point.
inline constexpr std::size_t kMaxForcePoints = 20'000;
using ForceCurve = Thinned<ForcePoint, kMaxForcePoints>;
ForcePoint MakeForcePoint(const LoopRow& row);

/// Writes forces.csv during the loop, so that memory does not grow with the run. For one thread. A full disk does not
/// stop the loop: the partial file is deleted, which leaves its space to the recording, and Commit() reports the error.
class ForceLog {
 public:
  /// The temporary file is in the folder of `path`. `keep_free_bytes`: disk space to leave free. Throws kerf::Error if
  /// the file cannot be created.
  ForceLog(const std::string& path, const std::string& effects, double keep_free_bytes = 0);
  void Take(const LoopRow& row, std::span<const double> channels);
  /// Completes the file and renames it to its final name. Throws kerf::Error if this or an earlier step failed. Call
  /// once.
  void Commit();
  const std::string& path() const { return path_; }

 private:
  void Write();

  std::string path_;
  std::optional<GrowingFile> file_;  // none after a failure
  double keep_free_bytes_;
  std::string waiting_;
  std::string failure_;  // one sentence; empty if no error occurred
};

}  // namespace kerf
