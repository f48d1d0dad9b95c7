// What `kerf loop` leaves behind: JSON, CSV, a report and two pictures.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <nlohmann/json.hpp>

#include "files/files.h"
#include "kerf/version.h"
#include "report/plot.h"
#include "session/run_loop.h"
#include "session/run_scene.h"

namespace kerf {
namespace {

using nlohmann::ordered_json;

constexpr const char* kFiles[] = {"report.md", "loop.json", "forces.csv", "lateness.png", "force.png", "scene.toml"};

ordered_json TimesJson(const LoopTimeSummary& t) {
  return {{"count", t.count},     {"p50_us", t.p50_us}, {"p99_us", t.p99_us},
          {"p999_us", t.p999_us}, {"max_us", t.max_us}, {"mean_us", t.mean_us}};
}

const char* ToString(LoopEnd end) {
  switch (end) {
    case LoopEnd::kNotYet:
      return "not yet";
    case LoopEnd::kAsked:
      return "asked";
    case LoopEnd::kDeviceFailed:
      return "device failed";
    case LoopEnd::kFailed:
      return "failed";
  }
  return "";
}

std::string Row(const LoopTimeSummary& t) {
  return fmt::format("| {} | {} | {:.1f} | {:.1f} | {:.1f} | {:.1f} |\n", t.name, t.count, t.p50_us, t.p99_us,
                     t.p999_us, t.max_us);
}

/// Bars as one outline; nothing where there are none, for a logarithmic axis.
PlotSeries Outline(const std::string& label, const std::vector<LoopBar>& bars) {
  PlotSeries series;
  series.label = label;
  constexpr double kNothing = 0.5;
  const auto add = [&](double x, double y) {
    series.x.push_back(std::max(x, 0.1));
    series.y.push_back(std::max(y, kNothing));
  };
  if (!bars.empty()) add(bars.front().lower_us, 0);
  for (const LoopBar& bar : bars) {
    const double count = static_cast<double>(bar.count);
    add(bar.lower_us, count);
    add(bar.upper_us, count);
  }
  if (!bars.empty()) add(bars.back().upper_us, 0);
  return series;
}

PlotSpec MakeLatenessPlot(const LoopSummary& s) {
  PlotSpec spec;
  spec.title = "How late ticks began, and how long they took";
  spec.caption = fmt::format("{} ticks at {:g} Hz, {} missed; {}", s.counts.ticks, s.rate_hz, s.counts.missed,
                             s.grants.fifo ? fmt::format("SCHED_FIFO {}", s.grants.priority) : "not SCHED_FIFO");
  spec.x.label = "time (us), eight bars to an octave";
  spec.x.log = true;
  spec.y.label = "ticks";
  spec.y.log = true;
  spec.y.lower = 0.5;
  spec.series = {Outline("lateness", s.lateness_bars), Outline("tick", s.tick_bars)};
  PlotSeries period;
  period.label = fmt::format("period, {:g} us", 1e6 / s.rate_hz);
  period.x = {1e6 / s.rate_hz, 1e6 / s.rate_hz};
  period.y = {0.5, std::max<double>(1, static_cast<double>(s.counts.ticks))};
  period.colour = Rgb8{120, 120, 120};
  period.dash = 6;
  spec.series.push_back(period);
  return spec;
}

PlotSpec MakeForcePlot(const LoopSummary& s) {
  PlotSpec spec;
  spec.title = "Force on the hand";
  spec.caption = fmt::format("{} held by {}; device force = {:.3g} x simulated, at most {:.3g} N a tick", s.device,
                             s.hand, s.force.scale, s.force.slew_bound_N);
  spec.x.label = "time (s)";
  spec.y.label = "force (N)";
  PlotSeries device;
  device.label = "on the device, largest";
  PlotSeries hand;
  hand.label = "in the simulation, largest";
  // No more points than pixels: the largest of each stretch, so that no spike is lost.
  const std::size_t stretch = std::max<std::size_t>(s.rows.size() / 1200, 1);
  for (std::size_t i = 0; i < s.rows.size(); i += stretch) {
    double of_device = 0;
    double of_hand = 0;
    for (std::size_t k = i; k < std::min(i + stretch, s.rows.size()); ++k) {
      of_device = std::max(of_device, glm::length(s.rows[k].f_device_N));
      of_hand = std::max(of_hand, glm::length(s.rows[k].f_hand_N));
    }
    device.x.push_back(s.rows[i].time_s);
    device.y.push_back(of_device);
    hand.x.push_back(s.rows[i].time_s);
    hand.y.push_back(of_hand);
  }
  spec.series = {device, hand};
  return spec;
}

std::string JoinTimes(const std::vector<LoopTimeSummary>& all) {
  std::string rows;
  for (const LoopTimeSummary& t : all) rows += Row(t);
  return rows;
}

}  // namespace

std::string FormatLoopJson(const Scene& scene, const LoopSummary& s) {
  ordered_json stages = ordered_json::object();
  for (const LoopTimeSummary& t : s.stages) stages[t.name] = TimesJson(t);
  ordered_json steps = ordered_json::array();
  for (const FidelityStep& step : s.fidelity_steps) {
    steps.push_back({{"time_s", step.time_s},
                     {"from", kerf::ToString(step.from)},
                     {"to", kerf::ToString(step.to)},
                     {"reason", kerf::ToString(step.reason)},
                     {"share_over_budget", step.share_over},
                     {"longest_us", step.longest_us}});
  }
  const auto bars = [](const std::vector<LoopBar>& all) {
    ordered_json list = ordered_json::array();
    for (const LoopBar& bar : all) list.push_back({bar.lower_us, bar.upper_us, bar.count});
    return list;
  };
  const ordered_json json = {
      {"kerf", VersionString()},
      {"scene", scene.name},
      {"seconds_asked", s.seconds},
      {"rate_hz", s.rate_hz},
      {"virtual_time", s.virtual_time},
      {"device", s.device},
      {"hand", s.hand},
      {"coupling",
       {{"stiffness_N_per_mm", s.coupling.stiffness_N_per_mm},
        {"damping_Ns_per_mm", s.coupling.damping_Ns_per_mm},
        {"lowered_for_device", s.coupling_lowered},
        {"device_bears_N_per_mm", s.limits.stiffness_N_per_mm},
        {"sampled_loop_holds_N_per_mm", s.limits.sampled_stiffness_N_per_mm},
        {"encoder_steps_allow_N_per_mm", s.limits.quantum_stiffness_N_per_mm}}},
      {"end", ToString(s.end)},
      {"failure", s.failure},
      {"granted",
       {{"sched_fifo", s.grants.fifo},
        {"priority", s.grants.priority},
        {"memory_locked", s.grants.locked},
        {"timer_slack_1_ns", s.grants.fine_timer},
        {"scheduling", s.grants.scheduling},
        {"memory", s.grants.memory}}},
      {"ticks",
       {{"count", s.counts.ticks},
        {"missed", s.counts.missed},
        {"longest_gap", s.counts.longest_gap},
        {"with_status", s.counts.status_ticks},
        {"simulated_s", s.simulated_s},
        {"wall_s", s.wall_s}}},
      {"tick", TimesJson(s.tick)},
      {"lateness", TimesJson(s.lateness)},
      {"stages", stages},
      {"watchdog_trips", s.watchdog_trips},
      {"ramps", s.counts.ramps},
      {"fidelity_steps", steps},
      {"fidelity_step_count", s.fidelity_step_count},
      {"force",
       {{"largest_N", s.force.largest_N},
        {"largest_step_N", s.force.largest_step_N},
        {"slew_bound_N", s.force.slew_bound_N},
        {"largest_simulated_N", s.force.largest_simulated_N},
        {"scale", s.force.scale},
        {"noise_above_20_Hz_mN", s.force.noise_above_20_Hz_mN},
        {"noise_above_20_Hz_while_cutting_mN", s.force.quiet_noise_mN},
        {"not_finite", s.counts.not_finite + s.device_counts.not_finite},
        {"bad_poses", s.counts.bad_poses}}},
      {"hand_strokes", s.strokes},
      {"hand_rounds", s.rounds},
      {"removed_mm3", s.removed_mm3},
      {"energy", {{"hand_J", s.hand_J}, {"spindle_J", s.spindle_J}, {"cut_J", s.cut_J}, {"friction_J", s.friction_J}}},
      {"published",
       {{"leaves", s.leaves_sent},
        {"copy_is_bit_identical", s.mirror_identical},
        {"log_rows_lost", s.counts.samples_lost}}},
      {"bone_hash", fmt::format("{:016x}", s.bone_hash)},
      {"force_hash", fmt::format("{:016x}", s.force_hash)},
      {"lateness_bars_us", bars(s.lateness_bars)},
      {"tick_bars_us", bars(s.tick_bars)}};
  return json.dump(2) + "\n";
}

std::string FormatLoopCsv(const LoopSummary& s) {
  std::string csv =
      "time_s,skipped,handle_x_mm,handle_y_mm,handle_z_mm,tool_x_mm,tool_y_mm,tool_z_mm,hand_x_N,hand_y_N,hand_z_N,"
      "device_x_N,device_y_N,device_z_N,cut_N,face_N,friction_N,thrust_sum_N,engaged_teeth,removed_mm3,tick_us,late_us,"
      "fidelity,status\n";
  csv.reserve(csv.size() + 200 * s.rows.size());
  for (const LoopRow& r : s.rows) {
    fmt::format_to(std::back_inserter(csv),
                   "{:.6f},{},{:.5f},{:.5f},{:.5f},{:.5f},{:.5f},{:.5f},{:.6g},{:.6g},{:.6g},{:.6g},{:.6g},{:.6g},"
                   "{:.6g},{:.6g},{:.6g},{:.6g},{:.5g},{:.6g},{:.1f},{:.1f},{},{}\n",
                   r.time_s, r.skipped, r.p_WC_mm.x, r.p_WC_mm.y, r.p_WC_mm.z, r.p_WT_mm.x, r.p_WT_mm.y, r.p_WT_mm.z,
                   r.f_hand_N.x, r.f_hand_N.y, r.f_hand_N.z, r.f_device_N.x, r.f_device_N.y, r.f_device_N.z, r.cut_N,
                   r.face_N, r.friction_N, r.thrust_N, r.engaged_teeth, r.removed_mm3, r.tick_us, r.late_us,
                   kerf::ToString(r.fidelity), r.status);
  }
  return csv;
}

std::string FormatLoopReport(const Scene& scene, const LoopSummary& s, bool pictures) {
  std::string text = fmt::format("# {}\n\n", scene.title.empty() ? scene.name : scene.title);
  text += fmt::format("`{}` in the hand {} on the device {}, {:.1f} s of it {} at {:g} Hz.\n\n", scene.name, s.hand,
                      s.device, s.simulated_s, s.virtual_time ? "without the clock" : "live", s.rate_hz);
  if (s.end != LoopEnd::kAsked) text += fmt::format("**The loop ended by itself: {}.**\n\n", s.failure);
  text += fmt::format("- {}\n- {}\n", s.grants.scheduling, s.grants.memory);
  text += fmt::format(
      "- Coupling {:.4g} N/mm{}; the device bears {:.4g} N/mm, a sampled loop with this hand holds {:.4g}, the "
      "encoder's steps allow {:.4g}.\n",
      s.coupling.stiffness_N_per_mm, s.coupling_lowered ? ", lowered to what the device bears" : "",
      s.limits.stiffness_N_per_mm, s.limits.sampled_stiffness_N_per_mm, s.limits.quantum_stiffness_N_per_mm);
  text += fmt::format(
      "- {} ticks; {} deadlines missed, at most {} in a row; the watchdog made the force zero {} times, and {} times "
      "it began again from zero.\n",
      s.counts.ticks, s.counts.missed, s.counts.longest_gap, s.watchdog_trips, s.counts.ramps);
  text += fmt::format("- Force that was not finite: {}. Handle poses that were none: {}. Ticks with a status: {}.\n",
                      s.counts.not_finite + s.device_counts.not_finite, s.counts.bad_poses, s.counts.status_ticks);
  text += fmt::format(
      "- Largest force on the device {:.3f} N, in the simulation {:.3f} N; largest step from tick to tick {:.4f} N, "
      "where {:.4g} N are allowed.\n",
      s.force.largest_N, s.force.largest_simulated_N, s.force.largest_step_N, s.force.slew_bound_N);
  text += fmt::format(
      "- Force above 20 Hz, RMS on the device: {:.2f} mN over all, {:.2f} mN in the middle one of the seconds that "
      "were cut through.\n",
      s.force.noise_above_20_Hz_mN, s.force.quiet_noise_mN);
  text +=
      fmt::format("- {} strokes, {} times through the path, {:.3f} mm3 removed.\n", s.strokes, s.rounds, s.removed_mm3);
  text += fmt::format(
      "- Energy: {:.4f} J from the hand, {:.4f} J from the spindle through friction; {:.4f} J into the cut, {:.4f} J "
      "into friction.\n",
      s.hand_J, s.spindle_J, s.cut_J, s.friction_J);
  text += fmt::format("- {} leaves were sent to readers; a copy of the bone made from them is {}.\n", s.leaves_sent,
                      s.mirror_identical ? "bit-identical to the bone" : "NOT the bone");
  text += "\n| us | ticks | p50 | p99 | p99.9 | max |\n| --- | --- | --- | --- | --- | --- |\n";
  text += Row(s.tick) + Row(s.lateness) + JoinTimes(s.stages);
  if (s.fidelity_step_count > 0) {
    text += "\n| time (s) | from | to | why | over budget | longest (us) |\n| --- | --- | --- | --- | --- | --- |\n";
    for (const FidelityStep& step : s.fidelity_steps) {
      text += fmt::format("| {:.3f} | {} | {} | {} | {:.0f} % | {:.0f} |\n", step.time_s, kerf::ToString(step.from),
                          kerf::ToString(step.to), kerf::ToString(step.reason), 100 * step.share_over, step.longest_us);
    }
    if (s.fidelity_step_count > static_cast<long>(s.fidelity_steps.size())) {
      text += fmt::format("\n{} steps in all.\n", s.fidelity_step_count);
    }
  }
  if (pictures) text += "\n![How late ticks began](lateness.png)\n\n![Force](force.png)\n";
  return text;
}

std::vector<std::string> WriteLoopReport(const Scene& scene, const LoopSummary& summary, const std::string& folder) {
  MakeFolder(folder);
  WriteTextFile(folder + "/scene.toml", ResolvedToml(scene));
  WriteTextFile(folder + "/forces.csv", FormatLoopCsv(summary));
  if (!summary.lateness_bars.empty()) WritePlot(MakeLatenessPlot(summary), folder + "/lateness.png");
  if (!summary.rows.empty()) WritePlot(MakeForcePlot(summary), folder + "/force.png");
  WriteTextFile(folder + "/report.md", FormatLoopReport(scene, summary, true));
  WriteTextFile(folder + "/loop.json", FormatLoopJson(scene, summary));
  return {std::begin(kFiles), std::end(kFiles)};
}

void CheckLoopInputsStay(const Scene& scene, const std::string& scene_file, const std::string& folder) {
  std::vector<std::string> outputs;
  for (const char* name : kFiles) outputs.push_back(fmt::format("{}/{}", folder, name));
  std::vector<std::string> inputs = ListInputs(scene, scene_file);
  inputs.push_back(scene.device.file);
  CheckInputsStay(inputs, outputs);
}

}  // namespace kerf
