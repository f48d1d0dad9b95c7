#include "session/run/loop_handle.h"

#include <cmath>

#include "session/run/run_loop.h"

namespace kerf {
namespace {

// The recorded poses are rounded to a lattice with steps of 4e-9 mm.
constexpr double kSamePlace_mm = 1e-6;
constexpr double kSameTurn = 1e-12;  // 1 minus the cosine of half the angle

}  // namespace

LoopHandle::LoopHandle(const Scene& scene, const LoopDriver& driver, const LoopSetup& setup, const Path& path,
                       const Vec3& p_TC_mm, double felt_stiffness_N_per_mm)
    : driver_(driver), recorded_(setup.profile), guarded_(recorded_) {
  if (is_real()) return;
  SimulatedDeviceOptions options;
  options.p_TC_mm = p_TC_mm;
  options.delay_ticks = scene.device.delay_ticks;
  recorded_.set_device(simulated_.emplace(setup.profile, setup.hand, path.CalcPose(0, 0), options));
  if (driver.make_hand) {
    other_hand_ = driver.make_hand(*simulated_, setup, p_TC_mm, felt_stiffness_N_per_mm);
  } else {
    motion_.emplace(*simulated_, path, scene.hand, p_TC_mm, felt_stiffness_N_per_mm);
  }
}

void LoopHandle::Connect(const Pose& X_WT, const CouplingParams& coupling, double force_scale) {
  if (is_real()) recorded_.set_device(driver_.device.begin(X_WT, coupling, force_scale));
}

void LoopHandle::EndReplay(const LoopTick& last) {
  DeviceSample own;
  if (!motion_ || last.number == 0 || !simulated_->Read(own)) return;
  // The scene's hand has moved along in the replay. If the recording is of another hand, it is elsewhere now.
  follows_path_ = glm::distance(own.X_WH.p_AB, last.X_WH.p_AB) < kSamePlace_mm &&
                  std::abs(glm::dot(own.X_WH.R_AB, last.X_WH.R_AB)) > 1 - kSameTurn;
}

void LoopHandle::TakeOver(const LoopTick& last) {
  guarded_.Trip();
  if (follows_path_) return;
  motion_->JoinFrom(last.X_WH);
  follows_path_ = true;
}

void LoopHandle::Summarize(LoopSummary& s) const {
  if (driver_.device.figures) s.device_figures = driver_.device.figures();
  const ForceCounts& counts = guarded_.counts();
  s.device_counts = counts;
  s.force.largest_N = counts.largest_N;
  s.force.largest_step_N = counts.largest_step_N;
  if (!motion_ || !follows_path_) return;
  s.passes = motion_->passes();
  s.strokes = motion_->strokes();
}

}  // namespace kerf
