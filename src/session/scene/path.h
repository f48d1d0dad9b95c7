// Path of the tool: its pose as a function of time.
#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "kerf/path.h"
#include "session/scene/scene.h"

namespace kerf {

/// A segment of a path. Times are path time: 0 at the start, simulated time only (lifting and placing the tool take no
/// time).
struct PathSegment {
  double start_s = 0;
  double end_s = 0;  // > start_s; the next segment's start_s
  /// True: the tool was placed at this segment's first pose; start a new Simulation there. False: it continues from the
  /// previous segment. True for the first segment.
  bool retract_before = true;
};

class Path {
 public:
  const std::vector<PathSegment>& segments() const { return segments_; }
  double duration_s() const { return segments_.empty() ? 0 : segments_.back().end_s; }
  double length_mm() const { return length_mm_; }  // path length of the tool's origin in all segments

  /// Returns the pose at path time `t_s`, clamped to the segment. Between knots the position is interpolated linearly
  /// and the orientation by slerp along the shorter arc. Cost O(log knots).
  Pose CalcPose(std::size_t segment, double t_s) const;
  /// Returns the number of ticks that cover the segment at `rate_hz`; tick k = 1..n ends at min(start_s + k / rate_hz,
  /// end_s).
  std::size_t CountTicks(std::size_t segment, double rate_hz) const;
  std::size_t CountTicks(double rate_hz) const;
  /// Returns the maximum speed of the tool's origin between two knots, mm/s.
  double CalcMaxSpeed() const;

 private:
  friend Path MakePath(const Scene& scene);
  void AddSegment(const std::vector<TimedPose>& knots, bool retract_before);

  std::vector<PathSegment> segments_;
  std::vector<std::vector<TimedPose>> knots_;  // per segment, in path time
  double length_mm_ = 0;
};

/// Steps through a path at a fixed rate.
class PathDriver {
 public:
  /// `path` must outlive this object.
  PathDriver(const Path& path, double rate_hz) : path_(path), rate_hz_(rate_hz) {}
  /// Returns the next step; none at the end of the path.
  std::optional<PathStep> Next();

 private:
  const Path& path_;
  double rate_hz_;
  std::size_t segment_ = 0;
  std::size_t tick_ = 0;   // number of ticks done in this segment
  std::size_t ticks_ = 0;  // number of ticks of this segment; 0: not begun
  double time_s_ = 0;
};

/// Returns the scene's path. The tool frame along a stroke: z = disc_normal; x = the feed direction projected into the
/// disc's plane. A stroke that does not retract keeps the x of the previous one. If the feed is along the normal
/// (sideways: no tooth bites, but the disc's sweep removes bone), x is the projection of the world axis that is
/// furthest from the normal.
Path MakePath(const Scene& scene);

}  // namespace kerf
