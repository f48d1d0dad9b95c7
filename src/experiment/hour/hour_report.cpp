// Output of `kerf bench hour`: a table, a CSV and a diagram.
#include <fmt/format.h>

#include <cmath>
#include <functional>

#include "base/files/files.h"
#include "experiment/hour/hour.h"
#include "view/picture/image.h"
#include "view/plot/plot.h"

namespace kerf {
namespace {

using Figure = std::function<double(const HourMinute&)>;

PlotSeries MakeCurve(const Hour& hour, const std::string& label, const Figure& figure) {
  PlotSeries series;
  series.label = label;
  series.marker = 4;
  for (const HourMinute& m : hour.minutes) {
    series.x.push_back(m.minute);
    series.y.push_back(figure(m));
  }
  return series;
}

PlotSpec MakePanel(const std::string& title, const std::string& y) {
  PlotSpec spec;
  spec.width = 1280;
  spec.height = 330;
  spec.title = title;
  spec.x.label = "simulated time (min)";
  spec.y.label = y;
  return spec;
}

Image RenderHour(const Hour& hour) {
  const HourMinute worst = hour.CalcWorst();
  PlotSpec memory = MakePanel("Memory", "in use (MB)");
  memory.y.lower = 0;
  memory.y.upper = 1.25 * worst.resident_MB;
  memory.series = {MakeCurve(hour, "of the whole program", [](const HourMinute& m) { return m.resident_MB; }),
                   MakeCurve(hour, "of the heap, without leaves that were cut",
                             [](const HourMinute& m) { return m.CalcOtherHeap_MB(); })};
  PlotSpec times = MakePanel("Ticks that cut, by minute", "time of a tick (us)");
  times.y.lower = 0;
  times.series = {MakeCurve(hour, "p50", [](const HourMinute& m) { return m.tick_p50_us; }),
                  MakeCurve(hour, "p99", [](const HourMinute& m) { return m.tick_p99_us; })};
  PlotSpec volume = MakePanel("Removed bone", "volume (mm³)");
  volume.y.lower = 0;
  volume.y_right.label = "reported minus actual removal (1e-9 mm³)";
  volume.series = {MakeCurve(hour, "removed", [](const HourMinute& m) { return m.removed_mm3; }),
                   MakeCurve(hour, "error (right)", [](const HourMinute& m) { return 1e9 * m.removed_error_mm3; })};
  volume.series[1].right_axis = true;
  PlotSpec rest = MakePanel("At rest in the air, and the energy balance", "largest force (N)");
  rest.y.lower = -1;
  rest.y.upper = 1;
  rest.y_right.label = "energy unaccounted for (1e-9 J)";
  rest.series = {
      MakeCurve(hour, "force at rest", [](const HourMinute& m) { return std::max(m.rest_hand_N, m.rest_device_N); }),
      MakeCurve(hour, "energy (right)", [](const HourMinute& m) { return 1e9 * m.energy_error_J; })};
  rest.series[1].right_axis = true;
  Image image;
  for (const PlotSpec* spec : {&memory, &times, &volume, &rest}) AppendImage(RenderPlot(*spec), image);
  return image;
}

}  // namespace

const Columns<HourMinute>& HourColumns() {
  const char* const kRest =
      "number of ticks in which the tool had been in the air without contact for at least 0.3 s, and the maximum "
      "forces "
      "in them: in the simulation and on the device";
  static const Columns<HourMinute> kColumns{
      {"minute", "{}", "1, 2, ...", &HourMinute::minute},
      {"resident_MB", "{:.3f}", "memory of the program", &HourMinute::resident_MB},
      {"bone_MB", "{:.3f}", "memory of the bone", &HourMinute::bone_MB},
      {"heap_MB", "{:.3f}", "allocated on the heap", &HourMinute::heap_MB},
      {"own_MB", "{:.3f}", "of the heap, the bone without the leaves that it shares with its copy",
       &HourMinute::own_MB},
      {"simulation_MB", "{:.3f}", "of the heap, the simulation without the bone", &HourMinute::simulation_MB},
      {"tick_p50_us", "{:.3f}", "duration of the ticks that cut", &HourMinute::tick_p50_us},
      {"tick_p99_us", "{:.3f}", "duration of the ticks that cut", &HourMinute::tick_p99_us},
      {"cutting_share", "{:.4f}", "fraction of the ticks that cut", &HourMinute::cutting_share},
      {"engaged_teeth", "{:.3f}", "mean during cutting", &HourMinute::teeth},
      {"rest_ticks", "{}", kRest, &HourMinute::rest_ticks},
      {"rest_hand_N", "{:g}", kRest, &HourMinute::rest_hand_N},
      {"rest_device_N", "{:g}", kRest, &HourMinute::rest_device_N},
      {"removed_mm3", "{:.9g}", "exact volume removed since the start", &HourMinute::removed_mm3},
      {"removed_error_mm3", "{:.3g}", "difference of that volume from the volume that the bone lost",
       &HourMinute::removed_error_mm3},
      {"removed_by_ticks_mm3", "{:.9g}", "volume removed since the start, by occupancy of voxels",
       &HourMinute::removed_by_ticks_mm3},
      {"energy_J", "{:.9g}", "energy input since the start", &HourMinute::energy_J},
      {"energy_error_J", "{:.3g}", "difference of that energy from the sum of all sinks", &HourMinute::energy_error_J}};
  return kColumns;
}

namespace {

/// `markdown`: otherwise for a terminal.
std::string FormatHour(const Hour& hour, bool markdown) {
  const HourMinute worst = hour.CalcWorst();
  if (hour.minutes.empty()) return fmt::format("{} ticks: too few for a complete minute.\n", hour.loop.counts.ticks);
  const std::string text = fmt::format(
      "{} minutes of simulated time, {} ticks at {:g} Hz; {:.0f} % of the ticks cut, with {:.1f} teeth engaged; {:.0f} "
      "s "
      "of computation.\n\n",
      worst.minute, hour.loop.counts.ticks, hour.rate_hz, 100 * worst.cutting_share, worst.teeth, hour.loop.wall_s);
  TextTable table({"at the end of minute", "memory (MB)", "of that, bone (MB)", "cutting tick, p50 / p99 (us)",
                   "force at rest (N)", "removed (mm3)", "difference from the bone's loss (mm3)",
                   "removed by voxel occupancy (mm3)", "energy input (J)", "unaccounted for (J)"});
  const std::size_t n = hour.minutes.size();
  for (std::size_t i = 0; i < n; ++i) {
    const HourMinute& m = hour.minutes[i];
    if (i != 0 && i + 1 != n && m.minute % 10 != 0) continue;
    table.Add({m.minute, fmt::format("{:.2f}", m.resident_MB), fmt::format("{:.2f}", m.bone_MB),
               fmt::format("{:.1f} / {:.1f}", m.tick_p50_us, m.tick_p99_us),
               fmt::format("{:g}", std::max(m.rest_hand_N, m.rest_device_N)), fmt::format("{:.2f}", m.removed_mm3),
               fmt::format("{:.1e}", m.removed_error_mm3), fmt::format("{:.2f}", m.removed_by_ticks_mm3),
               fmt::format("{:.4f}", m.energy_J), fmt::format("{:.1e}", m.energy_error_J)});
  }
  const LoopCounts& counts = hour.loop.counts;
  return text + (markdown ? table.FormatMarkdown() : table.FormatTerminal()) +
         fmt::format(
             "\n- Memory: from the end of minute 2 on it grows by {:.2f} MB, with the leaves of 8 x 8 x 8 voxels that "
             "were cut (at most all leaves in the bone's bounding box): the bone and a reader's copy of it no longer "
             "share them, and the simulation has room for their old values. The rest of the heap varies by {:.2f} "
             "MB.\n- Ticks: the p50 of the last {} minutes is "
             "{:.3f} times that of the first.\n- Idle force: in {} ticks with the tool clear of the bone, at most {:g} "
             "N "
             "on the hand and {:g} N on the device.\n- Removed volume: off by at most {:.1e} mm3 of {:.1f} mm3. "
             "Energy: "
             "at most {:.1e} J of {:.2f} J unaccounted for.\n- Faults: {} ticks limited or faulty, {} not finite, {} "
             "log "
             "rows lost; a copy of the bone is {}.\n",
             hour.CalcMemoryGrowth_MB(), hour.CalcOtherGrowth_MB(), std::min<std::size_t>(kHourWindow_min, n / 2),
             hour.CalcTimeRatio(), worst.rest_ticks, worst.rest_hand_N, worst.rest_device_N,
             std::abs(worst.removed_error_mm3), worst.removed_mm3, std::abs(worst.energy_error_J), worst.energy_J,
             counts.status_ticks, counts.not_finite, counts.samples_lost,
             hour.loop.mirror_identical ? "bit-identical" : "NOT identical");
}

}  // namespace

std::string FormatHourTable(const Hour& hour) {
  return fmt::format("{}: {}", hour.scene, FormatHour(hour, false));
}

std::string FormatHourMarkdown(const Hour& hour, const std::string& machine, const std::string& figure) {
  return FormatHour(hour, true) + fmt::format("\n![An hour of sawing]({})\n\n{}\n", figure, machine);
}

void WriteHour(const Hour& hour, const std::string& folder) {
  FileBatch results(folder, "hour.csv");
  WriteTextFile(folder + "/hour.csv", FormatCsv(HourColumns(), hour.minutes));
  if (!hour.minutes.empty()) WritePng(RenderHour(hour), folder + "/hour.png");
  results.Commit();
}

}  // namespace kerf
