// A cut to measure, and the results of the measurement.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "base/core/percentiles.h"
#include "experiment/bench/measure.h"
#include "kerf/bone.h"
#include "kerf/coupled.h"
#include "kerf/effects.h"

namespace kerf {

/// The baseline with which the tick is compared in the same run.
enum class BenchBaseline { kNone, kOpenVdb, kDense };

struct BenchOptions {
  int ticks = 5000;  // rounded up to whole cuts if several are needed
  int core = 0;
  bool realtime = false;    // ticks and baselines run with real-time priority
  int baseline_ticks = 30;  // least number of ticks of each OpenVDB baseline, which are slow
  bool without_effects = false;
  std::function<void(const std::string& what, double fraction)> progress;
};

template <typename V>
void Describe(BenchOptions& p, V&& visit) {
  visit("ticks", p.ticks, Range{1, 1e7},
        "ticks measured of each case; a cut that is too short is repeated on new bones");
  DescribeCore(p.core, visit);
}

/// A straight cut in its own frame B, in which the bone's top is the plane z = 0 and z points out of the bone.
struct CutCase {
  std::string name;   // name by which the case is selected
  std::string title;  // description in one line
  Tool tool;
  double rpm = 7500;
  double feed_mm_per_s = 5;
  std::function<Bone()> make_bone;
  Pose X_WB;
  Pose X_BT_start;  // clear of the bone, except in MakeBuriedCut()
  Vec3 direction_B{1, 0, 0};
  double warm_up_mm = 0;   // length of the path until the tool is fully in the bone
  double measured_mm = 0;  // length of the measured path after that
  bool by_hand = false;    // soft coupling as with a device, and a trembling hand; otherwise a stiff coupling, with
                           // which the tool follows the path
  bool flat_top = true;    // false: the swept volume has no closed form
  double section_mm2 = 0;  // of the sweep across the direction, where it is the same all along; 0: as the tool's depth
  BenchBaseline baseline = BenchBaseline::kNone;
  bool dense_all = false;    // whether the whole bone is compared with the dense reference
  Vec3 dense_offset_B{0};    // if not the whole bone, a cube along the grid's axes is compared: offset of its centre
                             // from the tool's centre halfway through the measured ticks
  double dense_edge_mm = 0;  // edge of that cube; if 0, no cube is compared
  int spare_leaves = 4096;
  std::optional<EffectChoices> effects;  // none: those of CoupledParams
};

/// A figure with a limit.
struct BenchTarget {
  std::string what;
  std::string unit;
  double limit = 0;
  double measured = 0;
  bool at_least = false;  // otherwise the limit is an upper one
  bool met() const { return at_least ? measured >= limit : measured <= limit; }
};

/// A figure without a limit.
struct BenchFigure {
  std::string what;
  std::string unit;
  double value = 0;
};

// Additions, multiplications, comparisons, roots and the like, counted in the source: of floats, for a voxel that
// removal computes; and of doubles, for a sample of the bone.
inline constexpr double kDiscOperations = 41;
inline constexpr double kBallOperations = 34;
inline constexpr double kSampleOperations = 57;

struct BaselineTimes {
  std::string what;
  Percentiles times;
};

struct BenchResult {
  std::string name;
  std::string title;
  Percentiles times;                      // of all ticks, each timed as a whole; count 0 if nothing was timed
  Percentiles undisturbed;                // of the ticks in which the system did not interrupt the thread
  std::optional<BaselineTimes> baseline;  // measured between the ticks, or after them (BenchBaseline::kDense)
  std::vector<BenchFigure> figures;
  std::vector<BenchTarget> targets;
  std::vector<double> stages_us;  // means, by TickStage; measured in a separate pass
  std::uint64_t hash = 0;         // of the bone at the end; 0 if nothing was cut
  std::string note;

  /// Returns null if there is no such figure.
  const BenchFigure* Find(const std::string& figure) const;
  /// Returns the ratio of the baseline's median to this result's; 0 without a baseline.
  double TimesFaster() const { return baseline && times.p50_us > 0 ? baseline->times.p50_us / times.p50_us : 0; }
};

/// Times ticks one by one.
class TickTimer {
 public:
  /// Runs `work`, which is one tick, and records and returns its time.
  template <typename Work>
  WorkTime Time(Work&& work) {
    const WorkTime time = TimeWork(work);
    all_us_.push_back(time.us());
    if (time.undisturbed) undisturbed_us_.push_back(time.us());
    return time;
  }
  void Reserve(std::size_t ticks) {
    all_us_.reserve(ticks);
    undisturbed_us_.reserve(ticks);
  }
  /// Returns the percentiles of the times from the `from`th on.
  Percentiles CalcTimes(std::size_t from = 0) const {
    return CalcPercentiles({all_us_.begin() + static_cast<std::ptrdiff_t>(from), all_us_.end()});
  }
  Percentiles CalcUndisturbed() const { return CalcPercentiles(undisturbed_us_); }
  std::size_t size() const { return all_us_.size(); }

 private:
  std::vector<double> all_us_;
  std::vector<double> undisturbed_us_;
};

/// Moves the handle along the cut, with the tool coupled to it, and times every tick after the warm-up. Repeats this on
/// fresh bones until there are enough ticks. Throws Error if two passes produce different bones.
BenchResult RunCut(const CutCase& cut, const BenchOptions& options);

}  // namespace kerf
