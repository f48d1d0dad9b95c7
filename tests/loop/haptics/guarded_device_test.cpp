// Tests that the force is zero after a trip until the loop starts its ramp, and that threads never use the device at
// the same time.
#include "loop/haptics/guarded_device.h"

#include <gtest/gtest.h>

#include <limits>
#include <thread>
#include <utility>

#include "loop/haptics/watchdog.h"
#include "made_up.h"

namespace kerf {
namespace {

using test::RecordingDevice;

TEST(GuardedDevice, HoldsZeroAfterATripUntilTheLoopHasTakenNote) {
  RecordingDevice inner;
  GuardedDevice device(inner);
  EXPECT_TRUE(device.Write({3, 0, 0}, Vec3{0}));
  EXPECT_EQ(inner.force_x_N, 3);
  EXPECT_TRUE(device.Trip());
  EXPECT_EQ(inner.force_x_N, 0);
  EXPECT_TRUE(device.Write({3, 0, 0}, Vec3{0}));  // by the tick in progress
  EXPECT_EQ(inner.force_x_N, 0);
  EXPECT_TRUE(device.TakeTripped());
  EXPECT_FALSE(device.TakeTripped());
  device.Write({0.1, 0, 0}, Vec3{0});
  EXPECT_EQ(inner.force_x_N, 0.1);
  EXPECT_EQ(device.counts().largest_step_N, 3);  // the first write; the trip and the writes after it do not count
}

/// Device in which the loop continues while it receives the trip's zero, as if in a separate thread.
class DeviceInATrip final : public Device {
 public:
  const DeviceProfile& profile() const override { return inner_.profile(); }
  bool Read(DeviceSample& sample) noexcept override { return inner_.Read(sample); }
  bool Write(const Vec3& f_H_W_N, const Vec3& tau_H_W_Nmm) noexcept override {
    if (std::exchange(trips_, false)) {
      taken_ = loop_->TakeTripped();
      loop_->Write({0.1, 0, 0}, Vec3{0});  // first value of its ramp
    }
    return inner_.Write(f_H_W_N, tau_H_W_Nmm);
  }
  bool Trip(GuardedDevice& loop) noexcept {
    loop_ = &loop;
    trips_ = true;
    return loop.Trip();
  }
  bool taken() const { return taken_; }

 private:
  RecordingDevice inner_;
  GuardedDevice* loop_ = nullptr;
  bool trips_ = false;
  bool taken_ = false;
};

TEST(GuardedDevice, RampThatBeganDuringATripRestarts) {
  DeviceInATrip inner;
  GuardedDevice device(inner);
  device.Write({0.1, 0, 0}, Vec3{0});
  EXPECT_TRUE(inner.Trip(device));
  EXPECT_TRUE(inner.taken());
  EXPECT_EQ(device.counts().skipped, 1U);
  // The ramp's first value never reached the device, so continuing with the second would be a double step.
  EXPECT_TRUE(device.TakeTripped());
  device.Write({0.1, 0, 0}, Vec3{0});
  EXPECT_EQ(device.counts().largest_step_N, 0.1);
}

TEST(GuardedDevice, WritesZeroForNonFiniteForces) {
  RecordingDevice inner;
  GuardedDevice device(inner);
  device.Write({3, 0, 0}, Vec3{0});
  device.Write({std::numeric_limits<double>::quiet_NaN(), 0, 0}, Vec3{0});
  EXPECT_EQ(inner.force_x_N, 0);
  device.Write({3, 0, 0}, {0, std::numeric_limits<double>::infinity(), 0});
  EXPECT_EQ(inner.force_x_N, 0);
  EXPECT_EQ(device.counts().not_finite, 2U);
}

TEST(GuardedDevice, GivesNoForceOnceClosed) {
  RecordingDevice inner;
  GuardedDevice device(inner);
  device.Write({3, 0, 0}, Vec3{0});
  device.Close();
  EXPECT_EQ(inner.force_x_N, 0);
  device.Write({3, 0, 0}, Vec3{0});
  EXPECT_EQ(inner.force_x_N, 0);
}

TEST(GuardedDevice, TwoThreadsAreNeverAtTheDeviceAtOnce) {
  RecordingDevice inner;
  GuardedDevice device(inner);
  std::atomic<bool> done{false};
  std::thread watchdog([&] {
    while (!done) {
      device.Trip();
      std::this_thread::yield();
    }
  });
  DeviceSample sample;
  for (int i = 0; i < 20'000; ++i) {
    device.Read(sample);
    device.Write({1, 0, 0}, Vec3{0});
    device.TakeTripped();
  }
  done = true;
  watchdog.join();
  EXPECT_EQ(inner.two_at_once, 0);
}

TEST(Watchdog, TripsOncePerStall) {
  RecordingDevice inner;
  GuardedDevice device(inner);
  Watchdog watchdog(device, 50);
  device.Write({3, 0, 0}, Vec3{0});
  EXPECT_FALSE(watchdog.Look(1050, 1000));
  EXPECT_EQ(inner.force_x_N, 3);
  EXPECT_TRUE(watchdog.Look(1051, 1000));
  EXPECT_EQ(inner.force_x_N, 0);
  EXPECT_FALSE(watchdog.Look(1061, 1000));
  EXPECT_FALSE(watchdog.Look(1101, 1100));  // the loop runs again
  device.TakeTripped();
  device.Write({3, 0, 0}, Vec3{0});
  EXPECT_TRUE(watchdog.Look(1200, 1100));
  EXPECT_EQ(inner.force_x_N, 0);
}

}  // namespace
}  // namespace kerf
