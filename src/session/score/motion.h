// Measures of the tool's motion, from the ticks of a recording.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "kerf/bone.h"
#include "kerf/tool.h"
#include "session/score/columns.h"
#include "session/score/measures.h"
#include "session/score/region_distance.h"

namespace kerf {

/// Data of a tick for the measures.
struct MotionTick {
  double time_s = 0;  // at its end, since the start
  double dt_s = 0;    // duration
  Pose X_WT;
  double force_N = 0;                          // on the hand, magnitude
  bool contact = false;                        // the tool touches bone
  bool turns = true;                           // the spindle rotates
  std::array<std::uint64_t, 4> regions_cut{};  // as in CoupledOutput
};

/// Processes ticks one by one and keeps one for every 4 ms.
class MotionMeter {
 public:
  explicit MotionMeter(double force_limit_N) : force_limit_N_(force_limit_N) {}

  void Take(const MotionTick& tick);
  /// Sets the sheet's measures of force, time and motion. `gauges`: of the wanted cuts, for the measures along the
  /// line and of the plunge; empty: there are none, or they are holes. `nerve` (may be null or empty): for the distance
  /// to the nerve and the breaches. `nerve_regions`: the regions of the nerve.
  void Finish(const Tool& tool, std::span<const DepthGauge> gauges, const RegionDistance* nerve,
              const std::array<bool, 256>& nerve_regions, ScoreSheet& sheet) const;
  /// Returns the pose in which the tip of a drill was deepest in each hole: that one which it was nearest to; none: it
  /// never was. Only poses count in which the turning drill touched bone with its axis in the bone `before` the cut and
  /// along the hole, and those in which it was in the hole that it had drilled so, for example beyond the far side.
  std::vector<std::optional<Pose>> FindDeepest(const Bone& before, const std::vector<WantedCut>& holes) const;
  /// Returns how much the axis of a bur leaned to the side in each cut along a line, about the line, with
  /// the sign of PlaneError::roll_deg: the mean over the places of the line of the lean in the pose in which the
  /// turning tool touched bone with its tip deepest there. Only places at least half as deep as wanted count. None:
  /// there are no such places, or the tool is no solid of revolution. `gauges`: of all cuts.
  std::vector<std::optional<double>> FindLeans_deg(std::span<const DepthGauge> gauges) const;
  /// Time at which the attempt began: the tool moved, or the spindle started to turn; none: not yet.
  const std::optional<double>& begun_s() const { return begun_s_; }

 private:
  struct Row {
    double time_s;
    Pose X_WT;
    bool contact;
    bool turns;
    double force_N;
  };
  void FindBeginning(const MotionTick& tick);
  void MeasureForces(ScoreSheet& sheet) const;
  void MeasureMotion(ScoreSheet& sheet) const;
  void MeasureLine(std::span<const DepthGauge> gauges, ScoreSheet& sheet) const;
  void MeasureFeedAlong(const WantedCut& cut, ScoreSheet& sheet) const;
  void MeasurePlunge(const DepthGauge& gauge, ScoreSheet& sheet) const;
  void MeasureNerve(const Tool& tool, const RegionDistance& nerve, ScoreSheet& sheet) const;

  double force_limit_N_;
  std::vector<Row> rows_;
  Row row_{};
  bool any_ = false;
  double next_s_ = 0;
  double end_s_ = 0;
  std::optional<double> begun_s_;
  std::optional<Pose> X_first_;            // pose of the first tick
  std::optional<double> turning_since_s_;  // while the spindle turns
  double contact_s_ = 0;
  double force_sum_ = 0;   // over the time in contact, N s
  double force2_sum_ = 0;  // N^2 s
  double force_peak_N_ = 0;
  double force_over_s_ = 0;
  int strokes_ = 0;
  double left_s_ = -1e9;  // time of the last contact
  /// Cuts in one region: their number, and the time of the last one.
  struct Cuts {
    int count = 0;
    double last_s = -1e9;
  };
  std::array<Cuts, 256> cuts_{};
};

}  // namespace kerf
