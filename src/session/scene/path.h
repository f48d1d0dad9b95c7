// The path of the tool: a pose for each moment.
#pragma once

#include <cstddef>
#include <vector>

#include "session/scene/scene.h"

namespace kerf {

/// A stretch of a path. Times are path time: 0 at the beginning, simulated time only (lifting and setting down take
/// none).
struct PathSegment {
  double start_s = 0;
  double end_s = 0;  // > start_s; the next segment's start_s
  /// True: the tool was set down at this segment's first pose; start a new Simulation there. False: it goes on from the
  /// segment before. The first segment's is true.
  bool retract_before = true;
};

class Path {
 public:
  const std::vector<PathSegment>& segments() const { return segments_; }
  double duration_s() const { return segments_.empty() ? 0 : segments_.back().end_s; }
  double length_mm() const { return length_mm_; }  // travelled by the disc's centre in all segments

  /// The pose at path time `t_s`, clamped to the segment: position linear, orientation slerp on the shorter arc between
  /// knots. Cost O(log knots).
  Pose CalcPose(std::size_t segment, double t_s) const;
  /// Ticks that cover the segment at `rate_hz`; tick k = 1..n ends at min(start_s + k / rate_hz, end_s).
  std::size_t CountTicks(std::size_t segment, double rate_hz) const;
  std::size_t CountTicks(double rate_hz) const;
  /// Highest speed of the disc's centre between two knots, mm/s.
  double CalcTopSpeed() const;

 private:
  friend Path MakePath(const Scene& scene);
  void AddSegment(const std::vector<TimedPose>& knots, bool retract_before);

  std::vector<PathSegment> segments_;
  std::vector<std::vector<TimedPose>> knots_;  // by segment, path time
  double length_mm_ = 0;
};

/// The scene's path. The tool frame along a stroke: z = disc_normal; x = the feed direction projected into the disc's
/// plane; a stroke that does not retract keeps the x of the one before. When the feed is along the normal (sideways: no
/// tooth bites, but the disc's sweep removes bone), x is the world axis that is furthest from the normal, projected.
Path MakePath(const Scene& scene);

}  // namespace kerf
