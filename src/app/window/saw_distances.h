// Distances of the saw to structures and to the plan: values, gauge and alarms.
#pragma once

#include <chrono>
#include <future>
#include <memory>
#include <vector>

#include "app/window/plan_document.h"
#include "session/score/columns.h"
#include "session/score/region_distance.h"

namespace kerf {

class SawDistances {
 public:
  SawDistances(ViewerApp& viewer, const PlanDocument& document) : viewer_(viewer), document_(document) {}

  /// Sets the bone before the cuts. The distance to its nerve canal is available some seconds later.
  void SetBone(const std::shared_ptr<const Bone>& before);
  /// Forgets the bone.
  void Reset();
  /// Called once per frame.
  void Update();
  void Fill(HudState& hud) const;
  /// Returns true if the saw reaches into the bone as it was before the cuts, such as in a kerf.
  bool IsInBone() const;
  /// Sounds the alarms of a turning saw that touches bone.
  void SoundAlarms() const;
  /// Adds the alarms of the nerve canal, of marked structures, and of a saw that cuts teeth or beside the selected
  /// plane.
  void AddAlarms(std::vector<AlarmOverlay>& alarms) const;
  /// Waits until no work is left, but not longer than `until`. Returns false if some is left.
  bool WaitUntil(std::chrono::steady_clock::time_point until) const;

 private:
  ViewerApp& viewer_;
  const PlanDocument& document_;
  std::future<std::unique_ptr<RegionDistance>> making_nerve_;
  std::vector<std::future<std::unique_ptr<RegionDistance>>> unused_;  // of earlier bones; end by themselves
  std::unique_ptr<RegionDistance> nerve_;
  std::unique_ptr<PhiSampler> sampler_;
};

}  // namespace kerf
