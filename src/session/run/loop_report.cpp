// Results of `kerf loop`: JSON, CSV, a report and two pictures.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <functional>
#include <iterator>
#include <nlohmann/json.hpp>
#include <span>

#include "base/files/files.h"
#include "base/files/markdown_text.h"
#include "base/table/table_json.h"
#include "bone/vdb/bonefile.h"
#include "cut/force/measured.h"
#include "kerf/error.h"
#include "kerf/version.h"
#include "session/run/results_folder.h"
#include "session/run/run_loop.h"
#include "session/run/run_pictures.h"
#include "session/run/run_scene.h"
#include "session/run/summary_json.h"
#include "session/run/write_pieces.h"
#include "view/plot/plot.h"

namespace kerf {
namespace {

using nlohmann::ordered_json;

constexpr double kHighestRate_Hz = 4000;  // maximum of [loop] rate_hz

/// All files that a loop may write, except the pieces.
constexpr const char* kFiles[] = {"report.md",  "loop.json", "forces.csv",   "lateness.png", "force.png",
                                  "scene.toml", "bone.vdb",  "before.png",   "after.png",    "cut.png",
                                  "apart.png",  "heat.png",  "fragments.png"};

/// The removed volume is computed from the level set and from the occupancy; both values are reported if they differ by
/// more than this fraction.
constexpr double kVolumeTolerance = 0.02;

ordered_json TimesJson(const PartTimes& t) {
  return {{"count", t.count},     {"p50_us", t.p50_us}, {"p99_us", t.p99_us},
          {"p999_us", t.p999_us}, {"max_us", t.max_us}, {"mean_us", t.mean_us}};
}

const char* ToString(LoopEnd end) {
  switch (end) {
    case LoopEnd::kNotYet:
      return "not yet";
    case LoopEnd::kRequested:
      return "asked";
    case LoopEnd::kDeviceFailed:
      return "device failed";
    case LoopEnd::kFailed:
      return "failed";
  }
  return "";
}

/// Returns the bars as one outline; empty bars are drawn at the lower limit of the logarithmic axis.
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
  spec.title = "Lateness and duration of the ticks";
  spec.caption = fmt::format("{} ticks at {:g} Hz, {} missed; {}", s.counts.ticks, s.rate_hz, s.counts.missed,
                             s.grants.fifo ? fmt::format("SCHED_FIFO {}", s.grants.priority) : "not SCHED_FIFO");
  spec.x.label = "time (us); bars: eighths of an octave";
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

PlotSpec MakeLoopForcePlot(const LoopSummary& s) {
  PlotSpec spec;
  spec.title = "Force on the hand";
  spec.caption = fmt::format("{}; device force = {:.3g} x simulated; slew limit {:.3g} N a tick",
                             DescribeDeviceAndHand(s), s.force.scale, s.force.slew_bound_N);
  spec.x.label = "time (s)";
  spec.y.label = "force (N)";
  PlotSeries device;
  PlotSeries hand;
  // Plot at most one point per pixel, the maximum of each interval, so that no spike is lost.
  const std::vector<ForcePoint>& points = s.force_curve.points();
  const std::size_t stretch = std::max<std::size_t>(points.size() / 1200, 1);
  // The points of the curve are themselves maxima of several ticks in a long run.
  const std::size_t ticks = stretch * s.force_curve.each();
  const std::string maximum =
      ticks > 1 ? fmt::format(", maximum of each {:g} ms", 1000 * static_cast<double>(ticks) / s.rate_hz) : "";
  device.label = "on the device" + maximum;
  hand.label = "in the simulation" + maximum;
  for (std::size_t i = 0; i < points.size(); i += stretch) {
    ForcePoint largest = points[i];
    for (std::size_t k = i; k < std::min(i + stretch, points.size()); ++k) {
      largest = ForcePoint::Merge(largest, points[k]);
    }
    device.x.push_back(largest.time_s);
    device.y.push_back(largest.device_N);
    hand.x.push_back(largest.time_s);
    hand.y.push_back(largest.hand_N);
  }
  spec.series = {device, hand};
  return spec;
}

/// Writes results one by one. A failure, typically a full disk, does not prevent the others.
class ResultWriter {
 public:
  /// `name`: a file name, or a description of several files.
  void Write(const std::string& name, const std::function<void()>& write) {
    try {
      write();
    } catch (const Error& e) {
      if (lost_.empty()) first_ = e.what();
      lost_.push_back(name);
    }
  }
  bool HasLost(const std::string& name) const { return std::find(lost_.begin(), lost_.end(), name) != lost_.end(); }
  /// Throws kerf::Error with the reason of the first failure, the names of the other lost results, and `then`.
  void ThrowIfLost(const std::string& then) const {
    if (lost_.empty()) return;
    // The message contains the first name, unless that describes several files.
    const bool is_named = first_.find(lost_.front()) != std::string::npos;
    const std::span<const std::string> others = std::span(lost_).subspan(is_named ? 1 : 0);
    const std::string also = others.empty() ? "" : fmt::format("; also lost: {}", fmt::join(others, ", "));
    throw Error(first_ + also + then);
  }

 private:
  std::string first_;
  std::vector<std::string> lost_;
};

/// Completes the logs written during the run, or writes those kept in memory.
void WriteLogs(LoopSummary& summary, const std::string& folder, ResultWriter& results) {
  std::vector<std::string>& files = summary.files;
  results.Write("forces.csv", [&] {
    if (summary.force_log) {
      summary.force_log->Commit();
    } else {
      WriteTextFile(folder + "/forces.csv", FormatLoopCsv(summary));
    }
    files.emplace_back("forces.csv");
  });
  results.Write("the sounds", [&] {
    for (const std::string& name : summary.effect_files.WriteSounds(folder)) files.push_back(name);
  });
}

}  // namespace

std::string DescribeDeviceAndHand(const LoopSummary& s) {
  return s.hand.empty() ? s.device : fmt::format("{} in the hand {}", s.device, s.hand);
}

std::string DescribeDeviceFigures(const LoopSummary& s) {
  std::string text;
  for (const auto& [name, figure] : s.device_figures) {
    std::string words = name;
    std::replace(words.begin(), words.end(), '_', ' ');
    text += fmt::format("{}{} {:.5g}", text.empty() ? "" : ", ", words, figure);
  }
  return text;
}

std::string DescribeRemoved(const LoopSummary& s) {
  const double tolerance_mm3 = kVolumeTolerance * std::max(s.removed_mm3, s.removed_by_occupancy_mm3);
  if (std::abs(s.removed_mm3 - s.removed_by_occupancy_mm3) <= tolerance_mm3)
    return fmt::format("{:.3f} mm3", s.removed_mm3);
  if (s.undo && s.undo->restores > 0) {
    return fmt::format(
        "{:.3f} mm3 of the bone are gone at the end; the ticks removed {:.3f} mm3, including what was "
        "undone",
        s.removed_mm3, s.removed_by_occupancy_mm3);
  }
  return fmt::format(
      "{:.3f} mm3 by the bone's surface (exact), {:.3f} mm3 by the occupancy of voxels (the sum of the ticks and of "
      "forces.csv; with coarse voxels the two differ)",
      s.removed_mm3, s.removed_by_occupancy_mm3);
}

std::string DescribeStrokes(const LoopSummary& s) {
  return s.strokes == 0 ? "" : fmt::format("{} stroke{} begun", s.strokes, s.strokes == 1 ? "" : "s");
}

std::string DescribePieces(const LoopSummary& s) {
  std::string text = s.pieces.size() == 1 ? "one piece" : fmt::format("{} pieces", s.pieces.size());
  for (std::size_t i = 0; i < s.pieces.size(); ++i) {
    text += fmt::format("{}{:.3g} cm3", i == 0 ? ": " : ", ", s.pieces[i].volume_mm3 / 1000);
    if (s.pieces[i].place != PieceFate::kHeld) text += fmt::format(" ({})", ToString(s.pieces[i].place));
  }
  return text + DescribeCrumbs(s.piece_counts);
}

std::string DescribeEnergy(const LoopSummary& s) {
  return fmt::format(
      "{:.4f} J from the hand + {:.4f} from the spindle, which pulls the tool along = {:.4f} into the cut + {:.4f} "
      "friction + {:.4f} in springs + "
      "{:.4f} damping + {:.4f} lost to the time step ({:.2g} % of the input)",
      s.hand_J, s.spindle_J, s.cut_J, s.friction_J, s.stored_J, s.damping_J, s.numerical_J,
      100 * CalcNumericalFraction(s));
}

double CalcNumericalFraction(const LoopSummary& s) {
  const double put_in_J = std::max(s.hand_J, 0.0) + std::max(s.spindle_J, 0.0);
  return put_in_J > 0 ? s.numerical_J / put_in_J : 0;
}

void AddLoopWarnings(LoopSummary& s, int spare_leaves) {
  if (!s.touched && !s.starts_in_bone) s.warnings.emplace_back("the tool touched no bone");
  if (const double fraction = CalcNumericalFraction(s); fraction > 0.1) {
    s.warnings.push_back(
        fmt::format("{:.0f} % of the input energy was lost to the time step at {:g} Hz: the tool yields too far in a "
                    "tick; set {}more [simulation] substeps",
                    100 * fraction, s.rate_hz, s.rate_hz < kHighestRate_Hz ? "a higher rate, or " : ""));
  }
  if (s.leaves_used_up_s) {
    s.warnings.push_back(
        fmt::format("the {} blocks of voxels set aside for cutting were used up after {:.1f} s: until there were "
                    "more, uncut bone stopped the tool; move it more slowly, or use larger voxels",
                    spare_leaves, *s.leaves_used_up_s));
  }
  if (s.metal_touched_s) {
    s.warnings.push_back(fmt::format(
        "the turning tool touched metal, first after {:.1f} s; a bone saw does not cut metal", *s.metal_touched_s));
  }
  if (s.starts_in_bone) {
    s.warnings.emplace_back("the tool was set down inside the bone; the bone inside it was removed at once");
  }
}

std::string DescribeNoise(const LoopSummary& s) {
  return fmt::format(
      "{:.2f} mN over the whole run; {}", s.force.noise_above_20_Hz_mN,
      s.force.cutting_noise_mN
          ? fmt::format("{:.2f} mN in the worst second of uninterrupted cutting", *s.force.cutting_noise_mN)
          : std::string("while cutting: n/a, no whole second of uninterrupted cutting"));
}

std::string FormatLoopJson(const Scene& scene, const LoopSummary& s) {
  ordered_json stages = ordered_json::object();
  for (const PartTimes& t : s.stages) stages[t.name] = TimesJson(t);
  ordered_json steps = ordered_json::array();
  for (const FidelityStep& step : s.fidelity_steps) {
    steps.push_back({{"time_s", step.time_s},
                     {"from", kerf::ToString(step.from)},
                     {"to", kerf::ToString(step.to)},
                     {"reason", kerf::ToString(step.reason)},
                     {"share_over_budget", step.fraction_over},
                     {"longest_us", step.longest_us}});
  }
  // In virtual time, durations are meaningless and left out.
  const auto times = [&s](const PartTimes& t) { return s.virtual_time ? ordered_json() : TimesJson(t); };
  const FittedCoupling& fitted = s.setup.fitted;
  ordered_json pieces = ordered_json::array();
  for (const PieceSummary& piece : s.pieces) pieces.push_back(PieceJson(piece));
  const auto bars = [&s](const std::vector<LoopBar>& all) {
    if (s.virtual_time) return ordered_json();
    ordered_json list = ordered_json::array();
    for (const LoopBar& bar : all) list.push_back({bar.lower_us, bar.upper_us, bar.count});
    return list;
  };
  ordered_json device_figures;
  for (const auto& [name, figure] : s.device_figures) device_figures[name] = figure;
  ordered_json json = {
      {"kerf", VersionString()},
      {"scene", scene.name},
      {"seconds_asked", s.seconds},
      {"rate_hz", s.rate_hz},
      {"virtual_time", s.virtual_time},
      {"device", s.device},
      {"served", device_figures},
      {"hand", s.hand.empty() ? nlohmann::ordered_json(nullptr) : nlohmann::ordered_json(s.hand)},
      {"coupling",
       {{"asked_stiffness_N_per_mm", s.setup.asked_stiffness_N_per_mm},
        {"stiffness_N_per_mm", fitted.coupling.stiffness_N_per_mm},
        {"damping_Ns_per_mm", fitted.coupling.damping_Ns_per_mm},
        {"lowered_for_device", fitted.lowered.by_device},
        {"lowered_for_loop", fitted.lowered.by_loop},
        {"torsion_Nmm_per_rad", fitted.coupling.torsion_Nmm_per_rad},
        {"torsion_lowered_for_loop", fitted.lowered.torsion_by_loop},
        {"device_bears_N_per_mm", NumberJson(fitted.limits.stiffness_N_per_mm)},
        {"sampled_loop_holds_N_per_mm", NumberJson(fitted.limits.sampled_stiffness_N_per_mm)},
        {"share_of_sampled_loop", kSampledFraction},
        {"encoder_steps_allow_N_per_mm",
         s.setup.profile.friction_N > 0 ? NumberJson(fitted.limits.quantum_stiffness_N_per_mm) : ordered_json()}}},
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
      {"tick", times(s.tick)},
      {"lateness", times(s.lateness)},
      {"stages", s.virtual_time ? ordered_json() : stages},
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
        {"noise_above_20_Hz_while_cutting_mN", OrNull(s.force.cutting_noise_mN)},
        {"not_finite", s.counts.not_finite + s.device_counts.not_finite},
        {"bad_poses", s.counts.bad_poses}}},
      {"hand_strokes", s.strokes},
      {"hand_rounds", s.passes},
      {"volume_before_mm3", s.volume_before_mm3},
      {"volume_after_mm3", s.volume_after_mm3},
      {"removed_mm3", s.removed_mm3},
      {"removed_by_occupancy_mm3", s.removed_by_occupancy_mm3},
      {"energy",
       {{"hand_J", s.hand_J},
        {"spindle_J", s.spindle_J},
        {"stored_J", s.stored_J},
        {"cut_J", s.cut_J},
        {"friction_J", s.friction_J},
        {"damping_J", s.damping_J},
        {"numerical_J", s.numerical_J},
        {"numerical_share_of_input", CalcNumericalFraction(s)}}},
      {"pieces", pieces},
      {"dust", DustJson(s.piece_counts)},
      {"published",
       {{"leaves", s.leaves_sent},
        {"copy_is_bit_identical", s.mirror_identical},
        {"log_rows_lost", s.counts.samples_lost}}},
      {"bone_hash", fmt::format("{:016x}", s.bone_hash)},
      {"force_hash", fmt::format("{:016x}", s.force_hash)},
      {"lateness_bars_us", bars(s.lateness_bars)},
      {"tick_bars_us", bars(s.tick_bars)},
      {"warnings", s.warnings},
      {"files", s.files}};
  if (HaveFiles(s.pieces)) json["surface_error_mm"] = s.surface_error_mm;
  json["force"]["law"] = scene.force.name();
  json["force"]["accuracy"] = DescribeAccuracy(scene.force, MakeTool(scene));
  json["force"]["blades"] = DescribeBlades(scene.force, MakeTool(scene));
  if (s.cutting) json["cutting"] = CuttingJson(*s.cutting);
  if (s.recorded) {
    json["recording"] = {{"file", s.recorded->path},
                         {"bytes", s.recorded->bytes},
                         {"ticks", s.recorded->steps},
                         {"failure", s.recorded->failure}};
  }
  if (s.undo) {
    json["undo"] = {{"restores", s.undo->restores}, {"checkpoints", s.undo->checkpoints}, {"kept_MB", s.undo->kept_MB}};
    if (!s.virtual_time) json["undo"]["longest_ms"] = s.undo->longest_ms;
  }
  if (s.costs) json["costs"] = CostsJson(*s.costs);
  if (!s.effects.empty()) json["effects"] = EffectsJson(s.effects);
  if (s.heat) json["heat"] = HeatJson(*s.heat);
  if (s.fragments) json["fragments"] = FragmentsJson(*s.fragments, !s.virtual_time);
  return DumpJson(json);
}

std::string FormatLoopCsv(const LoopSummary& s) {
  std::string csv = FormatForceHeader(s.effects.Header());
  csv.reserve(csv.size() + 200 * s.rows.size());
  for (std::size_t i = 0; i < s.rows.size(); ++i) AppendForceRow(s.rows[i], s.effects.Row(i), csv);
  return csv;
}

std::string FormatLoopReport(const Scene& scene, const LoopSummary& s, bool pictures) {
  std::string text = fmt::format("# {}\n\n", EscapeMarkdown(scene.TitleOrName()));
  text += fmt::format("{} with {}, {:.1f} s {} at {:g} Hz.\n\n", MarkdownCode(scene.name),
                      EscapeMarkdown(DescribeDeviceAndHand(s)), s.simulated_s,
                      s.virtual_time ? "in virtual time" : "live", s.rate_hz);
  if (s.end != LoopEnd::kRequested) text += fmt::format("**The loop ended early: {}.**\n\n", EscapeMarkdown(s.failure));
  for (const std::string& warning : s.warnings) text += fmt::format("**Warning: {}.**\n\n", EscapeMarkdown(warning));
  if (!s.virtual_time) text += fmt::format("- {}\n- {}\n", s.grants.scheduling, s.grants.memory);
  text += fmt::format("- Coupling: {}. Limits: {}.\n", EscapeMarkdown(DescribeCoupling(s.setup)),
                      EscapeMarkdown(DescribeLimits(s.setup)));
  text += fmt::format(
      "- {} ticks; {} deadlines missed, at most {} in a row; the watchdog set the force to zero {} times, and the "
      "force ramped up again {} times.\n",
      s.counts.ticks, s.counts.missed, s.counts.longest_gap, s.watchdog_trips, s.counts.ramps);
  text += fmt::format(
      "- Non-finite forces: {}. Invalid handle poses: {}. Ticks limited or faulty: {} (bits of the "
      "status column).\n",
      s.counts.not_finite + s.device_counts.not_finite, s.counts.bad_poses, s.counts.status_ticks);
  if (!s.device_figures.empty())
    text += fmt::format("- Reported by the device: {}.\n", EscapeMarkdown(DescribeDeviceFigures(s)));
  text += fmt::format(
      "- Largest force on the device {:.3f} N, in the simulation {:.3f} N; largest step from tick to tick {:.4f} N, "
      "where the slew limit is {:.4g} N a tick.\n",
      s.force.largest_N, s.force.largest_simulated_N, s.force.largest_step_N, s.force.slew_bound_N);
  text += fmt::format("- Force law {}.\n", DescribeLaw(scene));
  if (s.cutting) text += fmt::format("- Cutting: {}.\n", DescribeCuttingEnergy(*s.cutting));
  text += fmt::format("- Noise of the device's force (above 20 Hz, RMS): {}.\n", DescribeNoise(s));
  const std::string strokes = DescribeStrokes(s);
  if (!strokes.empty()) text += fmt::format("- {}, {} times through the path.\n", strokes, s.passes);
  text += fmt::format("- {} removed.\n", DescribeRemoved(s));
  text += fmt::format("- The bone is {}.\n", DescribePieces(s));
  text += fmt::format("- Energy: {}.\n", DescribeEnergy(s));
  for (const std::string& effect : DescribeEffects(s.effects))
    text += fmt::format("- Effect: {}.\n", EscapeMarkdown(effect));
  if (s.heat) text += fmt::format("- Heat: {}.\n", DescribeHeat(*s.heat));
  if (s.fragments) text += fmt::format("- Fragments: {}.\n", DescribeFragments(*s.fragments));
  text += fmt::format("- {} leaves were sent to readers; a copy of the bone made from them is {}.\n", s.leaves_sent,
                      s.mirror_identical ? "bit-identical to it" : "NOT identical to it");
  if (!s.virtual_time) {
    TextTable table({"us", "ticks", "p50", "p99", "p99.9", "max"});
    std::vector<PartTimes> all{s.tick, s.lateness};
    all.insert(all.end(), s.stages.begin(), s.stages.end());
    const auto us = [](double time_us) { return fmt::format("{:.1f}", time_us); };
    for (const PartTimes& t : all)
      table.Add({t.name, t.count, us(t.p50_us), us(t.p99_us), us(t.p999_us), us(t.max_us)});
    text += "\n" + table.FormatMarkdown();
  }
  if (s.fidelity_step_count > 0) {
    TextTable table({"time (s)", "from", "to", "reason", "over budget", "longest (us)"});
    for (const FidelityStep& step : s.fidelity_steps) {
      table.Add({fmt::format("{:.3f}", step.time_s), kerf::ToString(step.from), kerf::ToString(step.to),
                 kerf::ToString(step.reason), fmt::format("{:.0f} %", 100 * step.fraction_over),
                 fmt::format("{:.0f}", step.longest_us)});
    }
    text += "\n" + table.FormatMarkdown();
    if (s.fidelity_step_count > static_cast<long>(s.fidelity_steps.size())) {
      text += fmt::format("\n{} steps in total.\n", s.fidelity_step_count);
    }
  }
  if (!pictures) return text;
  for (const auto& [file, what] : {std::pair{"before.png", "Before the cut"},
                                   {"after.png", "After the cut"},
                                   {"cut.png", "The cut in close-up"},
                                   {"apart.png", "The pieces moved apart"},
                                   {"fragments.png", "The pieces moved apart"},
                                   {"structures.png", "Structures that must not be cut, and the blade's distance"},
                                   {"guide.png", "The guide, and the path of the tool's centre"},
                                   {"deviation.png", "Distance from the plan"},
                                   {"heat.png", "Temperature around the kerf, at the end"},
                                   {"force.png", "Force"},
                                   {"lateness.png", "Lateness of the ticks"}}) {
    if (std::find(s.files.begin(), s.files.end(), file) == s.files.end()) continue;
    text += fmt::format("\n![{}]({})\n", what, file);
  }
  return text;
}

namespace {

/// Writes the bone, its pieces and their pictures.
void WriteBoneResults(const Scene& scene, LoopSummary& summary, const std::string& folder,
                      const std::function<void(const std::string&, double)>& progress, double surface_error_mm,
                      ResultWriter& results) {
  std::vector<std::string>& files = summary.files;
  const auto show = [&progress](const char* stage) {
    return [&progress, stage](double fraction) {
      if (progress) progress(stage, fraction);
    };
  };
  const std::string title = scene.TitleOrName();
  const auto write_one = [&](const std::string& name, const std::function<void(const std::string&)>& write) {
    results.Write(name, [&] {
      write(folder + "/" + name);
      files.push_back(name);
    });
  };
  if (scene.output.bone) write_one("bone.vdb", [&](const std::string& path) { WriteBone(summary.after, path); });
  const std::span<const PieceOut> out = summary.fragments ? summary.fragments->out : std::span<const PieceOut>{};
  summary.surface_error_mm = surface_error_mm;
  const ResultSink sink = [&results](const std::string& name, const std::function<void()>& write) {
    results.Write(name, write);
  };
  const std::vector<ResultPiece> pieces = ListPieces(summary.piece_bones, summary.piece_volumes_mm3, out);
  const std::vector<PieceSurface> surfaces = WritePieces(scene, summary.piece_bones, pieces, surface_error_mm, folder,
                                                         show("writing the pieces"), summary.pieces, sink);
  for (const PieceSummary& piece : summary.pieces) {
    if (!piece.file.empty()) files.push_back(piece.file);
  }
  if (!AreDrawn(scene, summary.warnings)) return;
  if (!summary.moments.empty()) {
    RunPictures pictures{scene,          summary.moments,
                         summary.before, summary.volume_before_mm3,
                         summary.after,  [&] { return DrawnPieces{surfaces, &summary.dust}; },
                         folder,         false};
    pictures.apart = !summary.fragments;  // fragments.png shows them
    pictures.out = out;
    pictures.sink = sink;
    for (const std::string& name : WriteRunPictures(pictures, show("drawing the pictures"), summary.warnings))
      files.push_back(name);
  }
  if (summary.heat && summary.heat->section.columns > 0) {
    write_one("heat.png", [&](const std::string& path) { WriteHeatPicture(*summary.heat, title, path); });
  }
  results.Write("the pictures of the effects", [&] {
    for (const std::string& name :
         summary.effect_files.WritePictures(folder, title, summary.after, MakeTool(scene), IsOfPatient(scene))) {
      files.push_back(name);
    }
  });
  if (summary.fragments) {
    results.Write("fragments.png", [&] {
      const bool drawn = WriteFragmentsPicture(*summary.fragments, summary.piece_bones, IsOfPatient(scene), title,
                                               folder + "/fragments.png");
      if (drawn) files.emplace_back("fragments.png");
    });
  }
}

}  // namespace

void WriteLoopReport(const Scene& scene, LoopSummary& summary, const std::string& folder,
                     const std::function<void(const std::string&, double)>& progress, double surface_error_mm) {
  MakeFolder(folder);
  const std::vector<std::string> earlier = ReadEarlierResults(folder, "loop.json");
  FileBatch batch(folder, "loop.json");
  std::vector<std::string>& files = summary.files;
  files = {"report.md", "loop.json"};
  ResultWriter results;
  const auto write_one = [&](const std::string& name, const std::function<void(const std::string&)>& write) {
    results.Write(name, [&] {
      write(folder + "/" + name);
      files.push_back(name);
    });
  };
  // First write the data that were collected while the loop ran.
  WriteLogs(summary, folder, results);
  write_one("scene.toml", [&](const std::string& path) { WriteTextFile(path, ResolvedToml(scene)); });
  const bool can_draw = FindLackOfPictures().empty();
  if (can_draw && !summary.virtual_time && !summary.lateness_bars.empty()) {
    write_one("lateness.png", [&](const std::string& path) { WritePlot(MakeLatenessPlot(summary), path); });
  }
  if (can_draw && !summary.force_curve.points().empty()) {
    write_one("force.png", [&](const std::string& path) { WritePlot(MakeLoopForcePlot(summary), path); });
  }
  // `before` is empty unless the bones were kept; `after` may be empty even if they were.
  if (!summary.before.empty()) WriteBoneResults(scene, summary, folder, progress, surface_error_mm, results);
  results.Write("report.md", [&] { WriteTextFile(folder + "/report.md", FormatLoopReport(scene, summary, true)); });
  results.Write("loop.json", [&] { WriteTextFile(folder + "/loop.json", FormatLoopJson(scene, summary)); });
  const bool has_list = !results.HasLost("loop.json");
  if (has_list) results.Write("loop.json", [&] { batch.Commit(earlier); });
  results.ThrowIfLost(has_list || batch.ReplacesNothing()
                          ? ""
                          : fmt::format("; {} keeps the results of an earlier session, and none of this one", folder));
}

void CheckLoopInputsNotOverwritten(const Scene& scene, const std::string& scene_file, const std::string& folder) {
  std::vector<std::string> outputs;
  for (const char* name : kFiles) outputs.push_back(fmt::format("{}/{}", folder, name));
  for (const std::string& name : EffectFiles::Names()) outputs.push_back(fmt::format("{}/{}", folder, name));
  for (const std::string& name : ReadEarlierResults(folder, "loop.json")) {
    outputs.push_back(fmt::format("{}/{}", folder, name));
  }
  std::vector<std::string> inputs = ListInputs(scene, scene_file);
  inputs.push_back(scene.device.file);
  for (const std::string& name : ListPieceFiles(folder, inputs)) outputs.push_back(name);
  CheckInputsNotOverwritten(inputs, outputs);
}

}  // namespace kerf
