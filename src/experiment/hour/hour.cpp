#include "experiment/hour/hour.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "base/core/percentiles.h"
#include "base/files/memory.h"
#include "bone/grid/shared_leaves.h"

namespace kerf {
namespace {

double CalcMedian(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  return values[values.size() / 2];
}

class HourWatch {
 public:
  HourWatch(double rate_hz, double each_s, Hour& hour) : rate_hz_(rate_hz), hour_(hour) {
    ticks_per_minute_ = static_cast<std::uint64_t>(std::llround(each_s * rate_hz));
    cutting_us_.reserve(ticks_per_minute_);
  }

  void Take(double wall_us, const LoopTick& sample, CoupledSimulation& simulation) {
    const CoupledOutput& out = sample.coupled;
    if (ticks_ == 0) {
      // This tick is the first one, so the volume before it is the present volume plus the volume that it removed.
      hour_.volume_before_mm3 = simulation.UpdateBone().CalcVolume() + CalcRemoved(simulation);
    }
    ++ticks_;
    if (out.engaged_teeth > 0) {
      cutting_us_.push_back(static_cast<float>(wall_us));
      teeth_ += out.engaged_teeth;
    }
    at_rest_ = (out.status & kCoupledAsleep) != 0 ? at_rest_ + 1 : 0;
    if (at_rest_ > kHourSettling_s * rate_hz_) {
      ++now_.rest_ticks;
      now_.rest_hand_N = std::max(now_.rest_hand_N, glm::length(out.f_H_W_N));
      now_.rest_device_N = std::max(now_.rest_device_N, glm::length(sample.force.f_H_W_N));
    }
    now_.removed_by_ticks_mm3 += out.removed_mm3;
    now_.energy_J += 1e-3 * (out.hand_mJ + out.spindle_mJ);
    sinks_J_ += 1e-3 * (out.stored_mJ + out.cut_mJ + out.friction_mJ + out.damping_mJ + out.numerical_mJ);
    if (ticks_ % ticks_per_minute_ == 0) EndMinute(simulation);
  }

 private:
  static double CalcRemoved(CoupledSimulation& simulation) {
    double sum = 0;
    for (const double mm3 : simulation.CalcRemovedByRegion()) sum += mm3;
    return sum;
  }
  void EndMinute(CoupledSimulation& simulation) {
    now_.minute = static_cast<int>(ticks_ / ticks_per_minute_);
    const auto cutting = static_cast<double>(cutting_us_.size());
    now_.cutting_share = cutting / static_cast<double>(ticks_per_minute_);
    now_.teeth = cutting > 0 ? teeth_ / cutting : 0;
    now_.tick_p50_us = static_cast<double>(CalcPercentile(cutting_us_, 0.5));
    now_.tick_p99_us = static_cast<double>(CalcPercentile(cutting_us_, 0.99));
    now_.removed_mm3 = CalcRemoved(simulation);
    now_.removed_error_mm3 = now_.removed_mm3 - (hour_.volume_before_mm3 - simulation.UpdateBone().CalcVolume());
    now_.energy_error_J = now_.energy_J - sinks_J_;
    const Bone& bone = simulation.UpdateBone();
    now_.bone_MB = 1e-6 * static_cast<double>(bone.CalcMemoryBytes());
    now_.own_MB = 1e-6 * static_cast<double>(CalcOwnBytes(bone));
    now_.simulation_MB = 1e-6 * static_cast<double>(simulation.CalcMemoryBytes());
    now_.heap_MB = 1e-6 * static_cast<double>(ReadHeapBytes());
    now_.resident_MB = 1e-6 * static_cast<double>(ReadResidentBytes());
    hour_.minutes.push_back(now_);
    now_.rest_ticks = 0;
    now_.rest_hand_N = now_.rest_device_N = 0;
    cutting_us_.clear();
    teeth_ = 0;
  }

  double rate_hz_;
  std::uint64_t ticks_per_minute_;
  Hour& hour_;
  HourMinute now_;
  std::vector<float> cutting_us_;
  double teeth_ = 0;
  double sinks_J_ = 0;
  std::uint64_t ticks_ = 0;
  double at_rest_ = 0;  // number of ticks
};

/// Returns the maximum minus the minimum after the warm-up.
template <typename Figure>
double CalcSpread(const std::vector<HourMinute>& minutes, const Figure& figure) {
  if (minutes.size() <= kHourWarmUp_min) return 0;
  double lowest = figure(minutes[kHourWarmUp_min]);
  double highest = lowest;
  for (std::size_t i = kHourWarmUp_min; i < minutes.size(); ++i) {
    lowest = std::min(lowest, figure(minutes[i]));
    highest = std::max(highest, figure(minutes[i]));
  }
  return highest - lowest;
}

/// Replaces `worst` with the value if the value is further from 0.
void UpdateWorst(double value, double& worst) {
  if (std::abs(value) > std::abs(worst)) worst = value;
}

}  // namespace

Hour RunHour(const Scene& scene, const HourOptions& options,
             const std::function<void(const std::string&, double)>& progress) {
  CheckParameters(options);
  Hour hour;
  hour.scene = scene.name;
  hour.rate_hz = scene.loop.rate_hz;
  hour.minutes.reserve(static_cast<std::size_t>(60 * options.minutes / options.each_s) + 1);
  HourWatch watch(scene.loop.rate_hz, options.each_s, hour);
  LoopOptions loop;
  loop.seconds = 60 * options.minutes;
  loop.virtual_time = true;
  loop.output.log = options.folder.empty() ? LoopLog::kNone : LoopLog::kFolder;
  loop.output.folder = options.folder;
  loop.stop = options.stop;
  loop.watchers.watch_tick = [&watch](double wall_us, const LoopTick& tick, CoupledSimulation& simulation) {
    watch.Take(wall_us, tick, simulation);
  };
  hour.loop = RunLoop(scene, loop, progress);
  return hour;
}

double Hour::CalcMemoryGrowth_MB() const {
  return CalcSpread(minutes, [](const HourMinute& m) { return m.resident_MB; });
}

double Hour::CalcOtherGrowth_MB() const {
  return CalcSpread(minutes, [](const HourMinute& m) { return m.CalcOtherHeap_MB(); });
}

double Hour::CalcTimeRatio() const {
  const std::size_t window = std::min<std::size_t>(kHourWindow_min, minutes.size() / 2);
  if (window == 0) return 1;
  std::vector<double> first;
  std::vector<double> last;
  for (std::size_t i = 0; i < window; ++i) {
    first.push_back(minutes[i].tick_p50_us);
    last.push_back(minutes[minutes.size() - 1 - i].tick_p50_us);
  }
  return CalcMedian(last) / CalcMedian(first);
}

HourMinute Hour::CalcWorst() const {
  HourMinute worst;
  worst.minute = static_cast<int>(minutes.size());
  for (const HourMinute& m : minutes) {
    UpdateWorst(m.resident_MB, worst.resident_MB);
    UpdateWorst(m.tick_p50_us, worst.tick_p50_us);
    UpdateWorst(m.tick_p99_us, worst.tick_p99_us);
    UpdateWorst(m.rest_hand_N, worst.rest_hand_N);
    UpdateWorst(m.rest_device_N, worst.rest_device_N);
    UpdateWorst(m.removed_mm3, worst.removed_mm3);
    UpdateWorst(m.removed_error_mm3, worst.removed_error_mm3);
    UpdateWorst(m.removed_by_ticks_mm3, worst.removed_by_ticks_mm3);
    UpdateWorst(m.energy_J, worst.energy_J);
    UpdateWorst(m.energy_error_J, worst.energy_error_J);
    worst.rest_ticks += m.rest_ticks;
    worst.cutting_share += m.cutting_share / static_cast<double>(minutes.size());
    worst.teeth += m.teeth / static_cast<double>(minutes.size());
  }
  return worst;
}

}  // namespace kerf
