// The far side of a bridge, built on the client in C: a handle in a hand that does not move, and a record of the force
// on it.
#pragma once

#include <arpa/inet.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <atomic>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <mutex>
#include <random>
#include <stdexcept>
#include <string>
#include <thread>

#include "kerf_bridge.h"

namespace kerf::test {

/// A device that reports itself as an omega_3. Its behaviour depends only on the received commands, not on the clock.
class FarSide {
 public:
  static constexpr double kPeak_N = 12;
  static constexpr double kStep_mm = 0.002;  // motion of a handle that is lowered, per command

  struct Felt {
    std::uint64_t commands = 0;
    std::uint64_t engaged = 0;  // commands among these with the tool in the hand
    double now_N = 0;
    double largest_N = 0;
    double lowered_mm = 0;
  };

  /// The handle trembles along x: after each command it is at noise_mm to the right or to the left.
  explicit FarSide(double noise_mm = 0) : noise_mm_(noise_mm) {
    socket_ = socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0);
    sockaddr_in at{};
    at.sin_family = AF_INET;
    at.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    socklen_t size = sizeof at;
    if (bind(socket_, reinterpret_cast<const sockaddr*>(&at), sizeof at) != 0 ||
        getsockname(socket_, reinterpret_cast<sockaddr*>(&at), &size) != 0) {
      throw std::runtime_error("no socket");
    }
    port_ = ntohs(at.sin_port);
    kerf_bridge_description description{};
    description.name = "omega_3";
    description.peak_force_n = static_cast<float>(kPeak_N);
    description.continuous_force_n = description.peak_force_n;
    description.max_stiffness_n_per_mm = 5;
    description.max_damping_ns_per_mm = 0.03f;
    description.workspace_radius_mm = 75;
    description.resolution_mm = 0.01f;
    description.rate_hz = 1000;
    description.driven = 3;
    description.buttons = 2;
    kerf_bridge_begin(&bridge_, &description);
    thread_ = std::thread([this] { Serve(); });
  }
  ~FarSide() {
    stop_ = true;
    thread_.join();
    close(socket_);
  }
  FarSide(const FarSide&) = delete;
  FarSide& operator=(const FarSide&) = delete;

  std::string where() const { return "127.0.0.1:" + std::to_string(port_); }
  Felt felt() const {
    const std::lock_guard lock(mutex_);
    return felt_;
  }
  /// Returns the state after everything received by now has been processed.
  Felt FeltByNow() const {
    const std::uint64_t begun = turns_ + 2;  // one iteration may have begun before
    while (turns_ < begun) std::this_thread::sleep_for(std::chrono::milliseconds(1));
    return felt();
  }
  void ForgetLargest() {
    const std::lock_guard lock(mutex_);
    felt_.largest_N = 0;
  }
  /// Lowers the handle by `distance_mm` while the tool is in the hand.
  void Lower(double distance_mm) {
    const std::lock_guard lock(mutex_);
    wanted_mm_ = felt_.lowered_mm + distance_mm;
  }
  void Press(std::uint32_t buttons) { buttons_ = buttons; }
  /// If mute, the device executes commands but does not answer, and the handle stops.
  void SetMute(bool mute) {
    const std::lock_guard lock(mutex_);
    mute_ = mute;
    wanted_mm_ = felt_.lowered_mm;
  }

 private:
  static std::uint64_t Now_ns() {
    return static_cast<std::uint64_t>(std::chrono::steady_clock::now().time_since_epoch().count());
  }

  void Serve() {
    while (!stop_) {
      pollfd waiting{.fd = socket_, .events = POLLIN, .revents = 0};
      poll(&waiting, 1, 1);
      const std::lock_guard lock(mutex_);
      std::array<unsigned char, 2 * KERF_BRIDGE_BYTES> packet{};
      sockaddr_in from{};
      socklen_t size = sizeof from;
      ssize_t got = 0;
      while ((got = recvfrom(socket_, packet.data(), packet.size(), MSG_DONTWAIT, reinterpret_cast<sockaddr*>(&from),
                             &size)) > 0) {
        Take(packet.data(), static_cast<std::size_t>(got), from);
      }
      Feel();
      ++turns_;
    }
  }

  void Take(const unsigned char* packet, std::size_t count, const sockaddr_in& from) {
    const std::uint64_t client = std::uint64_t{from.sin_addr.s_addr} << 16 | from.sin_port;
    state_.position_mm[0] = static_cast<float>(draw_() % 2 == 0 ? noise_mm_ : -noise_mm_);
    state_.position_mm[1] = static_cast<float>(-felt_.lowered_mm);
    state_.orientation_wxyz[0] = 1;
    state_.buttons = buttons_;
    state_.homed = 1;
    state_.ready = 1;
    const std::uint64_t now_ns = Now_ns();
    kerf_bridge_set_state(&bridge_, &state_, now_ns);
    kerf_bridge_command command{};
    if (kerf_bridge_read_command(packet, count, &command) != 0) {
      ++felt_.commands;
      if (command.engaged != 0) {
        ++felt_.engaged;
        if (!mute_) felt_.lowered_mm = std::fmin(wanted_mm_, felt_.lowered_mm + kStep_mm);
      }
    }
    std::array<unsigned char, KERF_BRIDGE_BYTES> reply{};
    const std::size_t bytes = kerf_bridge_take(&bridge_, packet, count, client, now_ns, reply.data());
    if (bytes > 0 && !mute_) {
      sendto(socket_, reply.data(), bytes, 0, reinterpret_cast<const sockaddr*>(&from), sizeof from);
    }
    Feel();
  }

  void Feel() {
    constexpr std::array<float, 3> kStill{};
    std::array<float, 3> force_N{};
    std::array<float, 3> torque_Nmm{};
    kerf_bridge_force(&bridge_, Now_ns(), state_.position_mm, kStill.data(), force_N.data(), torque_Nmm.data());
    felt_.now_N = std::hypot(double{force_N[0]}, double{force_N[1]}, double{force_N[2]});
    felt_.largest_N = std::fmax(felt_.largest_N, felt_.now_N);
  }

  double noise_mm_;
  int socket_ = -1;
  std::uint16_t port_ = 0;
  std::atomic<bool> stop_{false};
  std::atomic<std::uint32_t> buttons_{0};
  std::atomic<std::uint64_t> turns_{0};
  mutable std::mutex mutex_;  // protects everything below
  kerf_bridge bridge_{};
  kerf_bridge_state state_{};
  Felt felt_;
  bool mute_ = false;
  double wanted_mm_ = 0;
  std::minstd_rand draw_;
  std::thread thread_;
};

}  // namespace kerf::test
