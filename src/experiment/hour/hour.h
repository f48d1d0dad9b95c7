// A long run looked at minute by minute: does memory grow, does anything drift, do sums stay exact, are ticks as fast
// as at the start?
#pragma once

#include <atomic>
#include <functional>
#include <string>
#include <vector>

#include "session/run/run_loop.h"
#include "session/scene/scene.h"

namespace kerf {

/// Of the first and the last of so many minutes the ticks' times are compared; shorter runs are halved.
inline constexpr int kHourWindow_min = 10;
/// Memory that is asked for once, at first use, has been by then.
inline constexpr int kHourWarmUp_min = 1;

/// A minute of simulated time, or HourOptions::each_s, as it ended.
struct HourMinute {
  int minute = 0;          // 1, 2, ...
  double resident_MB = 0;  // of the program; what is free but kept is not counted
  double heap_MB = 0;      // asked of the heap and not given back
  double bone_MB = 0;      // of the bone: it grows by 2 kB for each leaf of pure bone that is cut into
  double tick_p50_us = 0;  // of the ticks that cut; whole ticks, with the simulated hand and device
  double tick_p99_us = 0;
  double cutting_share = 0;  // of the ticks
  double teeth = 0;          // engaged, mean while it cuts
  // Largest while the tool rests clear in the air, from kHourSettling_s after it came off on.
  std::size_t rest_ticks = 0;
  double rest_hand_N = 0;    // in the simulation
  double rest_device_N = 0;  // on the device
  // Since the start:
  double removed_mm3 = 0;           // exact, of the level set, as the ticks' account has it
  double removed_error_mm3 = 0;     // that, less what the bone has lost
  double removed_by_ticks_mm3 = 0;  // sum of what each tick tells, by occupancy of voxels
  double energy_J = 0;              // by hand and spindle
  double energy_error_J = 0;        // that, less all that it went into
};
inline constexpr double kHourSettling_s = 0.3;

struct Hour {
  std::string scene;
  double rate_hz = 0;
  double volume_before_mm3 = 0;
  std::vector<HourMinute> minutes;
  LoopSummary loop;

  /// After the first kHourWarmUp_min the largest less the smallest, MB: of what is in use, and of that without what the
  /// bone grew by, which a reader's copy has too (the simulation's own leaves were set aside before).
  double CalcMemoryGrowth_MB() const;
  double CalcOtherGrowth_MB() const;
  /// The same of the heap without the bone, which does not depend on what the system does with the program's pages.
  double CalcHeapGrowth_MB() const;
  /// Median of the last minutes' p50 over that of the first ones'; 1 for fewer than 2 minutes.
  double CalcTimeRatio() const;
  HourMinute CalcWorst() const;  // of each figure the one furthest from 0; `minute` is how many there are
};

struct HourOptions {
  double minutes = 60;  // of simulated time, 0.1 to 600
  double each_s = 60;   // a figure each, 1 to 60
  std::string folder;   // where the loop's log goes as it comes; "": nowhere
  const std::atomic<bool>* stop = nullptr;
};

/// Runs the scene in its hand without the clock. Throws Error.
Hour RunHour(const Scene& scene, const HourOptions& options,
             const std::function<void(const std::string&, double)>& progress);

std::string FormatHourCsv(const Hour& hour);
std::string FormatHourTable(const Hour& hour);
/// `machine`: a phrase; `figure`: the picture's address.
std::string FormatHourMarkdown(const Hour& hour, const std::string& machine, const std::string& figure);
/// hour.csv and hour.png. Throws Error.
void WriteHour(const Hour& hour, const std::string& folder);

}  // namespace kerf
