// Motion of a tool's edge by its drive, and the bite of its teeth: of a stroke or swing along the edge. A turning edge
// needs none of it, because its teeth pass each place at equal times.
#pragma once

#include <array>
#include <cstddef>
#include <numbers>
#include <span>

#include "cut/tool/edge_motion.h"
#include "kerf/tool.h"

namespace kerf {

/// Motion of the edge over a part of a tick.
struct DriveStep {
  SlideRange range;
  double middle_mm = 0;          // displacement in the middle of the time
  double speed_mm_per_s = 0;     // mean speed of the teeth along the edge
  double velocity_mm_per_s = 0;  // mean velocity along the edge, towards y of T if positive
  bool is_mean = false;          // of whole periods: the edge moves both ways
};

/// A part of a step. Bites are relative to the mean bite over the time of the step.
struct BitePart {
  double share = 1;      // of the time of the step
  double bite = 1;       // mean over the time of the part
  double way_share = 1;  // of the way of the teeth in the step
  double way_bite = 1;   // mean over the way in the part
};

/// Bites of a tooth in a step with a steady feed.
struct StrokeBites {
  static constexpr int kPartsPerPeriod = 32;
  double passes_per_s = 0;  // 1 / mean time since a place was last passed by a tooth; the bite is speed / passes_per_s
  int count = 0;
  std::array<BitePart, kPartsPerPeriod / 2 + 6> parts;  // divided where the bite jumps
  std::span<const BitePart> span() const { return std::span(parts).first(static_cast<std::size_t>(count)); }
};

/// Returns the smallest number of teeth that pass a place in a second, so that the feed divided by it is the largest
/// bite of a tooth. For a stroke this is just before a tooth reaches the turning point of the tooth in front.
double CalcLeastPassRate(const Tool& tool, double rpm);

/// Displacement of a stroke: s = stroke / 2 sin(phase). A place that a tooth passes was last passed by the same tooth
/// on the stroke before, or on this one by the tooth in front of it, one pitch ahead. With tau the time since the turn
/// after which the tooth came to s, and s measured from that turn, the time since then is
///   2 tau(s) for s < pitch, and tau(s) - tau(s - pitch) from there on.
/// The bite of the tooth is the feed in this time. It is zero right after each turn, and bite times way over a stroke
/// is pitch times the feed of half a period: the teeth take off what the feed brings. If the stroke is shorter than the
/// pitch, there are places between the teeth that none passes, and the sum is less.
class Drive {
 public:
  explicit Drive(const Tool& tool);

  /// False for an edge that turns; then no other function may be called.
  bool strokes() const { return amplitude_mm_ > 0; }
  /// Mean number of teeth that pass a place in a period, a real number.
  double passes_per_period() const { return 4 * amplitude_mm_ / pitch_mm_; }
  /// Returns how often a place is passed in a second, on the way of the teeth: the feed divided by it is the mean bite
  /// over their way. Of a stroke shorter than the pitch, this is of the places that a tooth passes.
  double CalcPassRate(double rpm) const;

  double CalcDisplacement(double phase_rad) const;
  /// Returns the least and the largest displacement from a phase on, over `advance_rad` >= 0: exact.
  SlideRange CalcRange(double phase_rad, double advance_rad) const;
  /// Returns the way of the edge over the same part, mm.
  double CalcWay(double phase_rad, double advance_rad) const;
  /// Returns the mean time since a place was last passed over the same part, as a phase, rad; above 0 for an advance
  /// above 0. Integrated by Gauss's rule, with a relative error below 1e-6 if the pitch is at least 2 % of the stroke.
  double CalcMeanSincePassed(double phase_rad, double advance_rad) const;

  /// Returns the mean over the way of the edge / the mean over the time, both of the time since a place was last
  /// passed. A tooth is fast where its bite is large, so that its work is more than mean force times mean speed. Closed
  /// form.
  double CalcWayBite(double phase_rad, double advance_rad) const;

  /// Returns the longest time since a place was last passed, as a phase, rad.
  double longest_since_passed_rad() const { return 2 * first_pitch_rad_; }

  /// Returns the motion over `time_s` > 0 from a phase on, at `rpm` double strokes a minute. If the period is shorter
  /// than two ticks, the motion is the mean over a whole period: all of the stroke is swept, and the edge is in its
  /// middle.
  DriveStep CalcStep(double phase_rad, double rpm, double time_s, double tick_s) const;
  /// Returns the bites over the same time.
  StrokeBites CalcBites(double phase_rad, double rpm, double time_s, double tick_s) const;
  /// Returns the phase after `time_s`, 0 to 2 pi. Strokes have no direction: the sign of `rpm` has no effect.
  static double Advance(double phase_rad, double rpm, double time_s);

 private:
  double IntegrateSincePassed(double from_rad, double to_rad) const;
  double IntegrateAlongWay(double from_rad, double to_rad) const;

  double amplitude_mm_;  // half the stroke
  double pitch_mm_;
  double first_pitch_rad_ = 0;      // phase from a turn until the edge has moved by the pitch; pi if it never does
  double per_half_period_ = 0;      // integral over half a period, rad^2
  double way_per_half_period_ = 0;  // integral over its way, mm rad
};

}  // namespace kerf
