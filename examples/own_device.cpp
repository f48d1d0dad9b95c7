// Moves the saw with a device of one's own: here a handle that is led down into the bone and up again. A real device
// would talk to its hardware in Read() and Write().
//
//   own_device SCENE
#include <algorithm>
#include <cstdio>
#include <glm/geometric.hpp>
#include <kerf/error.h>
#include <kerf/run.h>

namespace {

class LedHandle final : public kerf::Device {
 public:
  explicit LedHandle(const kerf::Pose& X_start) : X_(X_start), start_mm_(X_start.p_AB.z) {
    profile_.name = "led_handle";
    profile_.peak_force_N = 20;
  }
  const kerf::DeviceProfile& profile() const override { return profile_; }
  void Elapse(double dt_s) noexcept override { time_s_ += dt_s; }
  bool Read(kerf::DeviceSample& sample) noexcept override {
    const double depth_mm = std::max(0.0, 6 * std::min(time_s_, 4 - time_s_));  // 6 mm/s down, then up
    X_.p_AB.z = start_mm_ - depth_mm;
    sample.X_WH = X_;
    return true;
  }
  bool Write(const kerf::Vec3& f_H_W_N, const kerf::Vec3&) noexcept override {
    peak_N_ = std::max(peak_N_, glm::length(f_H_W_N));
    return true;
  }
  double peak_N() const { return peak_N_; }

 private:
  kerf::DeviceProfile profile_;
  kerf::Pose X_;
  double start_mm_;
  double time_s_ = 0;
  double peak_N_ = 0;
};

}  // namespace

int main(int argc, char** argv) try {
  if (argc != 2) {
    std::fprintf(stderr, "usage: own_device SCENE\n");
    return 2;
  }
  const kerf::SceneFile scene = kerf::SceneFile::Read(argv[1]);
  LedHandle handle(scene.ListPathSteps().front().X_WT);
  kerf::HandRunOptions options;
  options.seconds = 4;
  options.device = &handle;
  const kerf::HandRun run = kerf::RunInHand(scene, options);
  std::printf("%zu ticks, removed %.4f mm3, peak force on the device %.6g N\n", run.ticks.size(), run.removed_mm3,
              handle.peak_N());
} catch (const kerf::Error& e) {
  std::fprintf(stderr, "%s\n", e.what());
  return 1;
}
