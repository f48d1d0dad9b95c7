// A cut to measure, and what was measured.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "experiment/bench/measure.h"
#include "kerf/bone.h"
#include "kerf/coupled.h"

namespace kerf {

/// What the tick is compared with in the same run.
enum class BenchBaseline { kNone, kOpenVdb, kDense };

struct BenchOptions {
  int ticks = 5000;  // so many are measured, 1 to 10^7; rounded up to whole cuts where it takes more than one
  int core = 0;
  bool realtime = false;    // ticks and baselines go before other programs
  int baseline_ticks = 30;  // of OpenVDB, which takes its time
  bool without_effects = false;
  std::function<void(const std::string& what, double fraction)> progress;
};

/// A straight cut in a frame B of its own, in which the bone's top is the plane z = 0 and z points out of it.
struct CutCase {
  std::string name;   // to choose it by
  std::string title;  // what is done, in a line
  Tool tool;
  double rpm = 7500;
  double feed_mm_per_s = 5;
  std::function<Bone()> make_bone;
  Pose X_WB;
  Pose X_BT_start;  // clear of the bone
  Vec3 direction_B{1, 0, 0};
  double warm_up_mm = 0;   // of the way, until the tool is in the bone as far as it gets
  double measured_mm = 0;  // of the way, from there on
  bool by_hand = false;    // a device's soft coupling, and a hand that trembles; else the tool is led stiffly
  bool flat_top = true;    // false: how much the tool sweeps has no closed form
  BenchBaseline baseline = BenchBaseline::kNone;
  bool dense_all = false;    // compare the whole bone with the dense reference
  Vec3 dense_offset_B{0};    // or else a cube along the grid's axes: from the tool's middle, half way through the
                             // measured ticks, to that of the cube
  double dense_edge_mm = 0;  // of that cube; 0: nothing is compared
  int spare_leaves = 4096;
};

/// A figure with a limit.
struct BenchTarget {
  std::string what;
  std::string unit;
  double limit = 0;
  double measured = 0;
  bool at_least = false;  // else at most
  bool met() const { return at_least ? measured >= limit : measured <= limit; }
};

/// A figure without one.
struct BenchFigure {
  std::string what;
  std::string unit;
  double value = 0;
};

struct BaselineTimes {
  std::string what;
  Percentiles times;
};

struct BenchResult {
  std::string name;
  std::string title;
  Percentiles times;                      // of whole ticks, none left out; count 0 when nothing was timed
  Percentiles undisturbed;                // of those in which the system did not take the core away
  std::optional<BaselineTimes> baseline;  // of the same run
  std::vector<BenchFigure> figures;
  std::vector<BenchTarget> targets;
  std::vector<double> stages_us;  // means, by TickStage; measured in a pass of their own
  std::uint64_t hash = 0;         // of the bone at the end; 0 when nothing was cut
  std::string note;

  /// Null when there is none.
  const BenchFigure* Find(const std::string& figure) const;
};

/// Times ticks, one after the other.
class TickTimer {
 public:
  /// The times of `work`, which is one tick, are kept.
  template <typename Work>
  void Time(Work&& work) {
    const long interruptions = CountInterruptions();
    const std::int64_t start = ReadClock_ns();
    work();
    const std::int64_t end = ReadClock_ns();
    all_us_.push_back(1e-3 * static_cast<double>(end - start));
    if (CountInterruptions() == interruptions) undisturbed_us_.push_back(all_us_.back());
  }
  void Reserve(std::size_t ticks) {
    all_us_.reserve(ticks);
    undisturbed_us_.reserve(ticks);
  }
  /// Into times and undisturbed.
  void Finish(BenchResult& result) const {
    result.times = CalcPercentiles(all_us_);
    result.undisturbed = CalcPercentiles(undisturbed_us_);
  }

 private:
  std::vector<double> all_us_;
  std::vector<double> undisturbed_us_;
};

/// Leads the handle along the cut, the tool tied to it by a stiff coupling, and times every tick of it from the end of
/// the warm-up on; anew on a fresh bone until there are enough ticks. Throws Error when two passes differ.
BenchResult RunCut(const CutCase& cut, const BenchOptions& options);

}  // namespace kerf
