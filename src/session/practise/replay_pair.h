// An attempt beside the expert's: the motion of both tools, for showing them together.
#pragma once

#include <atomic>
#include <memory>
#include <mutex>
#include <span>
#include <string>
#include <vector>

#include "loop/haptics/loop_body.h"
#include "session/scene/scene.h"
#include "session/score/columns.h"

namespace kerf {

/// Pose of the tool at a time.
struct TrackPoint {
  double time_s = 0;
  Pose X_WT;
  bool contact = false;
  double rpm = 0;
};

/// Time between the points of a track.
inline constexpr double kTrackStep_s = 0.02;

/// Motion of a tool, one point per kTrackStep_s.
class ToolTrack {
 public:
  /// Takes the ticks of a session in order.
  void Take(const LoopTick& tick);
  bool empty() const { return points_.empty(); }
  double duration_s() const { return points_.empty() ? 0 : points_.back().time_s; }
  std::span<const TrackPoint> points() const { return points_; }
  /// Returns the point at a time, interpolated; before the first and after the last point, that point. Must not be
  /// empty.
  TrackPoint Calc(double time_s) const;
  /// Returns the time of the untrimmed track at which this one begins.
  double begins_s() const { return begins_s_; }
  /// Returns the track from shortly before the first contact until shortly after the last one, with times from 0; the
  /// whole track if there was no contact.
  ToolTrack Trim() const;

 private:
  std::vector<TrackPoint> points_;
  bool contact_ = false;
  double begins_s_ = 0;
};

/// Depth of a tool over time.
struct DepthPoint {
  double time_s = 0;
  double depth_mm = 0;  // below the surface
};

/// An attempt and an expert's attempt at the same exercise. Both begin at time 0, shortly before they touch the bone.
struct ReplayPair {
  ToolTrack student;
  ToolTrack expert;
  // Path of the tool's lowest point while it touches bone.
  std::vector<Vec3> student_line_W;
  std::vector<Vec3> expert_line_W;
  // Only where the tool is above or in the wanted cut.
  std::vector<DepthPoint> student_depth;
  std::vector<DepthPoint> expert_depth;

  double duration_s() const { return std::max(student.duration_s(), expert.duration_s()); }
};

/// `gauges`: of the exercise's cuts, at least one. A point of a track belongs to the cut that FindNearestGauge() gives.
ReplayPair MakeReplayPair(const ToolTrack& student, const ToolTrack& expert, std::span<const DepthGauge> gauges);

/// Does the exercise as the synthetic expert, in virtual time. The same scene gives the same track. Takes the time that
/// the bone needs and about as long as the cut; `stop` (optional) ends it with an Error.
ToolTrack MakeExpertTrack(const Scene& scene, const std::atomic<bool>* stop = nullptr);

/// Tracks of the expert that were made before, by exercise and level. Thread-safe.
class ExpertTracks {
 public:
  /// Returns the track of the scene's exercise; makes it at the first call. Other calls for the same or another
  /// exercise wait for this. Throws kerf::Error as MakeExpertTrack() does.
  std::shared_ptr<const ToolTrack> Get(const Scene& scene, const std::atomic<bool>* stop = nullptr);

 private:
  struct Entry {
    std::string scene;
    int level = 0;
    std::shared_ptr<const ToolTrack> track;
  };
  std::mutex mutex_;
  std::vector<Entry> entries_;
};

}  // namespace kerf
