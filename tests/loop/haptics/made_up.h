// A fake body and a fake device for the tests of the loop.
#pragma once

#include <atomic>
#include <functional>
#include <map>
#include <random>
#include <vector>

#include "loop/haptics/guarded_device.h"
#include "loop/haptics/haptic_loop.h"

namespace kerf::test {

/// Device that records its inputs; any thread may read them.
class RecordingDevice : public Device {
 public:
  const DeviceProfile& profile() const override { return profile_; }
  bool Read(DeviceSample& sample) noexcept override {
    Enter();
    sample.X_WH.p_AB = {position_mm.load(), 0, 0};
    Leave();
    return !fails.load();
  }
  bool Write(const Vec3& f_H_W_N, const Vec3&) noexcept override {
    Enter();
    force_x_N.store(f_H_W_N.x);
    writes.fetch_add(1);
    Leave();
    return !fails.load();
  }

  std::atomic<double> position_mm{0};
  std::atomic<bool> fails{false};
  std::atomic<double> force_x_N{0};
  std::atomic<long> writes{0};
  std::atomic<long> two_at_once{0};  // calls that overlapped with another one

 private:
  void Enter() {
    if (inside_.fetch_add(1) > 0) two_at_once.fetch_add(1);
  }
  void Leave() { inside_.fetch_sub(1); }
  DeviceProfile profile_;
  std::atomic<int> inside_{0};
};

/// Body whose force ramps up by 0.1 N per tick to 5 N and which makes random changes to its leaves. Calls `during` in
/// each tick.
class FakeBody : public LoopBody {
 public:
  explicit FakeBody(GuardedDevice& device) : device_(device) {}

  bool Tick(double dt_s, TickObserver& observer, LoopTick& tick) override {
    dt.push_back_if_room(dt_s);
    DeviceSample sample;
    observer.Enter(TickStage::kAccept);
    if (!device_.Read(sample)) return false;
    force_N_ = std::min(force_N_ + 0.1, 5.0);
    if (during) during();
    observer.Enter(TickStage::kRemove);
    if (leaf_count > 0) ChangeLeaves();
    observer.Enter(TickStage::kEnd);
    tick = {};
    tick.X_WH = sample.X_WH;
    tick.force.f_H_W_N = Vec3{force_N_, 0, 0};
    return device_.Write(tick.force.f_H_W_N, Vec3{0});
  }
  void RampIn() override {
    force_N_ = 0;
    ramps.fetch_add(1);
  }
  void SetFidelity(Fidelity to) override { fidelity.store(to); }
  int changed_count() const override { return static_cast<int>(changed_.size()); }
  ChangedLeaf changed(int i) const override {
    const int leaf = changed_[static_cast<std::size_t>(i)];
    const float* const values = leaves[static_cast<std::size_t>(leaf)].data();
    return {IndexOf(leaf), values, values};
  }
  void ClearChanged(int first) override {
    const auto end = changed_.begin() + first;
    for (auto leaf = changed_.begin(); leaf != end; ++leaf) marked_[static_cast<std::size_t>(*leaf)] = false;
    changed_.erase(changed_.begin(), end);
  }

  void MakeLeaves(int count) {
    leaf_count = count;
    leaves.assign(static_cast<std::size_t>(count), {});
    marked_.assign(static_cast<std::size_t>(count), false);
    changed_.reserve(static_cast<std::size_t>(count));
  }
  static std::array<int, 3> IndexOf(int leaf) { return {leaf % 7 - 3, leaf / 7, -leaf}; }

  /// Fixed-size log without allocation.
  struct Log {
    std::array<double, 4096> values{};
    std::size_t count = 0;
    void push_back_if_room(double v) {
      if (count < values.size()) values[count++] = v;
    }
  };
  Log dt;
  std::function<void()> during;
  std::atomic<long> ramps{0};
  std::atomic<Fidelity> fidelity{Fidelity::kFull};
  int leaf_count = 0;
  int changes_per_tick = 3;
  std::vector<std::array<float, 512>> leaves;

 private:
  void ChangeLeaves() {
    for (int k = 0; k < changes_per_tick; ++k) {
      const auto leaf = static_cast<std::size_t>(random_() % static_cast<unsigned>(leaf_count));
      leaves[leaf][random_() % 512] += 1;
      if (marked_[leaf]) continue;
      marked_[leaf] = true;
      changed_.push_back(static_cast<int>(leaf));
    }
  }

  GuardedDevice& device_;
  double force_N_ = 0;
  std::mt19937 random_{1};
  std::vector<bool> marked_;
  std::vector<int> changed_;
};

}  // namespace kerf::test
