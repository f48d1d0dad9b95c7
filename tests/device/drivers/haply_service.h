// A substitute for Haply's Inverse Service: a WebSocket on loopback that speaks its JSON.
#pragma once

#include <atomic>
#include <cstdint>
#include <mutex>
#include <string>
#include <thread>

#include "kerf/geometry.h"

namespace kerf::test {

class HaplyService {
 public:
  enum class Mood {
    kGood,      // one state per force
    kGarbage,   // invalid JSON
    kStrange,   // valid JSON of a different form
    kNoDevice,  // empty lists
    kSlow,      // each state is 60 ms late
    kSilent,
    kClosing,     // ends the connection at the next force
    kShortHello,  // one meaningless text, then the same as kGood
    kNoGrip,      // the same as kGood, but the list of grips is empty
    kDeaf,        // sends states continuously and reads nothing
    kWithheld     // does not send its state until the mood changes
  };

  /// A `port` of 0 means any free port. Throws std::runtime_error if the service cannot listen there.
  explicit HaplyService(Mood mood = Mood::kGood, bool with_grip = true, std::uint16_t port = 0);
  ~HaplyService();
  HaplyService(const HaplyService&) = delete;
  HaplyService& operator=(const HaplyService&) = delete;

  std::uint16_t port() const { return port_; }
  void SetMood(Mood mood) { mood_ = mood; }
  void Put(const Vec3& p_H_m) {
    std::lock_guard lock(mutex_);
    p_H_m_ = p_H_m;
  }
  /// From now on the cursor is displaced by 1 mm per N, so that a state shows which force it answers.
  void MoveWithForce() { moves_with_force_ = true; }
  Vec3 force_N() const {
    std::lock_guard lock(mutex_);
    return force_N_;
  }
  int forces() const { return forces_; }      // number of messages received
  int reported() const { return reported_; }  // number of messages sent

 private:
  void Serve();
  std::string MakeState() const;

  std::atomic<Mood> mood_;
  bool with_grip_;
  mutable std::mutex mutex_;
  Vec3 p_H_m_{0.01, -0.12, 0.2};
  Vec3 force_N_{0};
  std::atomic<int> forces_{0};
  std::atomic<int> reported_{0};
  std::atomic<bool> moves_with_force_{false};
  std::atomic<bool> stop_{false};
  std::atomic<int> connection_{-1};
  std::uint16_t port_ = 0;
  int listening_ = -1;
  std::thread thread_;
};

}  // namespace kerf::test
