// A long run, recorded minute by minute: whether memory grows, whether anything drifts, whether sums stay exact, and
// whether ticks are as fast as at the start.
#pragma once

#include <atomic>
#include <functional>
#include <string>
#include <vector>

#include "base/table/table.h"
#include "session/run/run_loop.h"
#include "session/scene/scene.h"

namespace kerf {

/// The tick times of this many minutes at the start and at the end are compared. In a shorter run, the two halves are
/// compared.
inline constexpr int kHourWindow_min = 10;
/// After this time, all memory that is allocated only once, at its first use, has been allocated.
inline constexpr int kHourWarmUp_min = 1;

/// Figures at the end of a minute of simulated time, or of another interval (HourOptions::each_s).
struct HourMinute {
  int minute = 0;            // 1, 2, ...
  double resident_MB = 0;    // of the program; memory that is free but cached is not counted
  double heap_MB = 0;        // allocated on the heap and not freed
  double bone_MB = 0;        // of the bone
  double own_MB = 0;         // of the bone, without the leaves that it shares with its copy outside the loop
  double simulation_MB = 0;  // allocated by the simulation, without the bone
  double tick_p50_us = 0;    // of the ticks that cut; whole ticks, including the simulated hand and device
  double tick_p99_us = 0;
  double cutting_share = 0;  // fraction of the ticks that cut
  double teeth = 0;          // engaged, mean during cutting
  // Maxima while the tool rests in air without contact, starting kHourSettling_s after it has left the bone.
  std::size_t rest_ticks = 0;
  double rest_hand_N = 0;    // in the simulation
  double rest_device_N = 0;  // on the device
  // Since the start:
  double removed_mm3 = 0;           // exact, of the level set, accumulated by the ticks
  double removed_error_mm3 = 0;     // difference from the bone's actual loss
  double removed_by_ticks_mm3 = 0;  // sum of the volumes that the ticks report, by occupancy of voxels
  double energy_J = 0;              // from hand and spindle
  double energy_error_J = 0;        // difference from the sum of all energy sinks

  /// Returns the part of the heap that does not grow by cutting. What does is the bone, its copy outside the loop,
  /// which grows by as much, and the simulation, which has room for the old values of each leaf that was cut.
  double CalcOtherHeap_MB() const { return heap_MB - 2 * own_MB - simulation_MB; }
};
inline constexpr double kHourSettling_s = 0.3;

struct Hour {
  std::string scene;
  double rate_hz = 0;
  double volume_before_mm3 = 0;
  std::vector<HourMinute> minutes;
  LoopSummary loop;

  /// These return the maximum minus the minimum after the first kHourWarmUp_min, MB: CalcMemoryGrowth_MB() of all
  /// memory in use, CalcOtherGrowth_MB() of the part of the heap that does not grow by cutting.
  double CalcMemoryGrowth_MB() const;
  double CalcOtherGrowth_MB() const;
  /// Returns the median of the p50 of the last minutes divided by that of the first ones, or 1 for fewer than 2
  /// minutes.
  double CalcTimeRatio() const;
  /// Returns the value of each figure that is furthest from 0, except for rest_ticks (the sum) and cutting_share and
  /// teeth (the means). `minute` is the number of minutes.
  HourMinute CalcWorst() const;
};

struct HourOptions {
  double minutes = 60;
  double each_s = 60;
  std::string folder;  // folder for the loop's log, written during the run; if empty, no log
  const std::atomic<bool>* stop = nullptr;
};

template <typename V>
void Describe(HourOptions& p, V&& visit) {
  visit("minutes", p.minutes, Range{0.1, 600}, "duration in simulated minutes");
  visit("each_s", p.each_s, Range{1, 60}, "interval between the figures");
}

/// Runs the scene with its hand as fast as possible, not in real time. Throws Error if the scene cannot run.
Hour RunHour(const Scene& scene, const HourOptions& options,
             const std::function<void(const std::string&, double)>& progress);

/// Describes the columns of hour.csv.
const Columns<HourMinute>& HourColumns();
std::string FormatHourTable(const Hour& hour);
/// `machine` is a phrase that describes the machine; `figure` is the path of the image.
std::string FormatHourMarkdown(const Hour& hour, const std::string& machine, const std::string& figure);
/// Writes hour.csv and hour.png. Throws Error if a file cannot be written.
void WriteHour(const Hour& hour, const std::string& folder);

}  // namespace kerf
