#include "device/drivers/bridge_driver.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <glm/geometric.hpp>
#include <random>

#include "base/core/vectors.h"
#include "kerf/error.h"

namespace kerf {
namespace {

using Clock = std::chrono::steady_clock;

int MillisecondsUntil(Clock::time_point end) {
  return static_cast<int>(std::chrono::ceil<std::chrono::milliseconds>(end - Clock::now()).count());
}

double PositiveOrZero(double x) {
  return std::isfinite(x) && x > 0 ? std::min(x, 1e6) : 0;
}

std::string DescribeRefusal(const BridgeRefusal& refusal, const std::string& where) {
  const std::string words = refusal.text.empty() ? std::string() : fmt::format(" (it says: {})", refusal.text);
  switch (refusal.reason) {
    case BridgeReason::kVersion:
      return fmt::format(
          "the bridge at {} uses version {} of the protocol, but kerf uses version {}; rebuild the bridge with "
          "tools/bridge/kerf_bridge.c from this version of kerf{}",
          where, refusal.version, kBridgeVersion, words);
    case BridgeReason::kBusy:
      return fmt::format("the bridge at {} is in use by another program; end that program, or wait two seconds{}",
                         where, words);
    case BridgeReason::kNoDevice:
      return fmt::format(
          "the bridge at {} finds no device; check that it is plugged in and that its maker's software finds it{}",
          where, words);
    case BridgeReason::kNoSession:
      break;
  }
  return fmt::format("the bridge at {} refused to start; restart it{}", where, words);
}

}  // namespace

BridgeDriver::BridgeDriver(const BridgeOptions& options) : options_(options) {
  CheckParameters(options, "bridge");
  if (!IsLoopbackAddress(options.address) && !options.allow_remote) {
    throw Error(
        fmt::format("{} is not this machine (127.x.x.x); packets to a bridge are neither encrypted nor signed, so "
                    "another machine must be allowed explicitly (--bridge-elsewhere)",
                    options.address));
  }
  profile_.name = "bridge";
  profile_.source = "behind a bridge; unknown until the bridge answers";
  traits_.timeout_ms = options.timeout_ms;
  link_ = std::make_unique<UdpLink>(options.address, options.port);
}

BridgeHeader BridgeDriver::NextHeader() noexcept {
  BridgeHeader header;
  header.session = session_;
  header.sequence = ++sequence_;
  const Clock::time_point now = Clock::now();
  sent_at_[header.sequence % sent_at_.size()] = now;
  header.time_ns =
      static_cast<std::uint64_t>(std::chrono::duration_cast<std::chrono::nanoseconds>(now.time_since_epoch()).count());
  return header;
}

bool BridgeDriver::IsPrompt(std::uint32_t answer_to) const noexcept {
  const std::uint32_t behind = sequence_ - answer_to;
  if (behind == 0) return true;  // the round waits at most timeout_ms for it
  // After a wrap-around, a sequence number that was never sent is also far behind, or its send time is the clock's
  // origin.
  if (behind >= sent_at_.size()) return false;
  return Clock::now() - sent_at_[answer_to % sent_at_.size()] <= std::chrono::milliseconds(options_.max_age_ms);
}

void BridgeDriver::TakeDescription(const BridgeDescription& description) {
  const auto known = [](double figure, double otherwise) { return figure > 0 ? figure : otherwise; };
  const DeviceProfile usual;
  profile_ = usual;
  profile_.name = description.name;
  profile_.degrees_of_freedom = description.driven == 6 ? 6 : 3;
  profile_.peak_force_N = description.driven > 0 ? description.peak_force_N : 0;
  profile_.continuous_force_N = std::min(description.continuous_force_N, profile_.peak_force_N);
  profile_.peak_torque_Nmm = description.driven == 6 ? description.peak_torque_Nmm : 0;
  profile_.continuous_torque_Nmm = std::min(description.continuous_torque_Nmm, profile_.peak_torque_Nmm);
  profile_.max_stiffness_N_per_mm = known(description.max_stiffness_N_per_mm, 0.3);
  profile_.max_damping_Ns_per_mm = known(description.max_damping_Ns_per_mm, 0.002);
  profile_.resolution_mm = known(description.resolution_mm, usual.resolution_mm);
  profile_.workspace_radius_mm = known(description.workspace_radius_mm, usual.workspace_radius_mm);
  profile_.source = fmt::format("as reported by the bridge at {}:{}", options_.address, options_.port);
  traits_.makes_force = profile_.peak_force_N > 0;
  traits_.senses_orientation = description.senses_orientation;
  traits_.homes = description.homes;
  traits_.homing = description.homes ? "move the handle as the bridge program instructs" : "";
  traits_.rate_hz = std::clamp(known(description.rate_hz, 1000), 50.0, 1000.0);
  traits_.buttons.clear();
  for (int i = 0; i < description.buttons; ++i) traits_.buttons.push_back(fmt::format("button {}", i + 1));
}

void BridgeDriver::Start(const std::function<bool(const std::string& doing, double fraction)>& show) {
  const std::string where = fmt::format("{}:{}", options_.address, options_.port);
  Stop();
  // A new socket contains no packets from an earlier session.
  link_ = std::make_unique<UdpLink>(options_.address, options_.port);
  std::random_device random;
  session_ = random();
  sequence_ = 0;
  sent_at_.fill({});
  const Clock::time_point begin = Clock::now();
  const std::chrono::milliseconds max_wait(options_.start_timeout_ms);
  int refused = 0;
  std::uint16_t other_version = 0;
  constexpr int kNoReader = 4;  // number of refusals after which it is assumed that no program listens
  while (Clock::now() < begin + max_wait && refused < kNoReader) {
    const double fraction = std::chrono::duration<double>(Clock::now() - begin) / max_wait;
    if (show && !show(fmt::format("connecting to the bridge at {}", where), std::min(fraction, 1.0))) {
      throw Error("starting the device was cancelled");
    }
    link_->Send(WriteBridgeHello(NextHeader()));
    const Clock::time_point next = std::min(Clock::now() + std::chrono::milliseconds(100), begin + max_wait);
    int left_ms = MillisecondsUntil(next);
    do {  // at least once, so that packets that have already arrived are read
      std::array<std::uint8_t, 2 * kBridgeBytes> bytes;
      std::size_t count = 0;
      const UdpEnd end = link_->Receive(bytes, std::max(left_ms, 0), count);
      if (end == UdpEnd::kRefused) {
        ++refused;
        continue;
      }
      if (end != UdpEnd::kOk || count > bytes.size()) continue;
      const auto packet = std::span<const std::uint8_t>(bytes).first(count);
      const std::optional<BridgeHeader> header = ReadBridgeHeader(packet);
      if (!header || header->session != session_) {
        ++bad_packets_;
        continue;
      }
      if (const auto refusal = ReadBridgeRefusal(packet)) throw Error(DescribeRefusal(*refusal, where));
      if (header->version != kBridgeVersion) other_version = header->version;
      if (const auto description = ReadBridgeDescription(packet)) {
        heard_sequence_ = header->sequence;
        TakeDescription(*description);
        running_ = true;
        if (show) show("ready", 1);
        return;
      }
    } while ((left_ms = MillisecondsUntil(next)) > 0);
  }
  if (other_version != 0) {
    throw Error(
        fmt::format("the bridge at {} uses version {} of the protocol, but kerf uses version {}; rebuild the bridge "
                    "with tools/bridge/kerf_bridge.c from this version of kerf",
                    where, other_version, kBridgeVersion));
  }
  throw Error(refused > 0 ? fmt::format("no bridge program is listening at {}; start it first (docs/bridge.md)", where)
                          : fmt::format("the bridge at {} gave no valid answer within {:.1f} s; check that it is "
                                        "running and that the program is a bridge",
                                        where, 1e-3 * options_.start_timeout_ms));
}

RoundEnd BridgeDriver::Exchange(const DriverCommand& command, DriverSample& sample) noexcept {
  if (!running_) return RoundEnd::kGone;
  BridgeCommand out;
  out.f_D_N = LimitLength(command.f_D_N, profile_.peak_force_N);
  out.tau_D_Nmm = LimitLength(command.tau_D_Nmm, profile_.peak_torque_Nmm);
  const bool placed = glm::length(command.p_D_mm) <= 1e6;  // false for NaN
  out.p_D_mm = placed ? command.p_D_mm : Vec3{0};
  out.stiffness_N_per_mm =
      placed ? std::min(PositiveOrZero(command.stiffness_N_per_mm), profile_.max_stiffness_N_per_mm) : 0;
  out.damping_Ns_per_mm = std::min(PositiveOrZero(command.damping_Ns_per_mm), profile_.max_damping_Ns_per_mm);
  out.valid_ms = options_.valid_ms;
  out.engaged = command.engaged || out.f_D_N != Vec3{0} || out.tau_D_Nmm != Vec3{0};
  const BridgeHeader header = NextHeader();
  const Clock::time_point end = Clock::now() + std::chrono::milliseconds(options_.timeout_ms);
  if (link_->Send(WriteBridgeCommand(header, out)) == UdpEnd::kRefused) {
    running_ = false;
    return RoundEnd::kGone;
  }
  // Wait for the answer to this command. A newer state that answers a recent command is also accepted.
  bool has_news = false;
  bool has_bad = false;
  for (int left_ms = options_.timeout_ms; left_ms > 0; left_ms = MillisecondsUntil(end)) {
    std::array<std::uint8_t, 2 * kBridgeBytes> bytes;
    std::size_t count = 0;
    const UdpEnd got = link_->Receive(bytes, left_ms, count);
    if (got == UdpEnd::kTimeout) continue;  // timeout, or interrupted by a signal
    if (got == UdpEnd::kRefused) {
      running_ = false;
      return RoundEnd::kGone;
    }
    if (got == UdpEnd::kFailed) return RoundEnd::kBadAnswer;
    const auto packet = std::span<const std::uint8_t>(bytes).first(std::min(count, bytes.size()));
    const std::optional<BridgeHeader> answer = ReadBridgeHeader(packet);
    if (!answer || answer->session != session_) {
      ++bad_packets_;
      has_bad = true;
      continue;
    }
    if (answer->kind == BridgeKind::kRefusal) {
      running_ = false;  // the bridge was restarted or has lost its device
      return RoundEnd::kGone;
    }
    if (answer->kind == BridgeKind::kDescription) continue;  // a second answer to the hello
    const std::optional<BridgeState> state = ReadBridgeState(packet);
    if (!state || !IsAfter(answer->sequence, heard_sequence_)) {
      ++bad_packets_;
      has_bad = true;
      continue;
    }
    heard_sequence_ = answer->sequence;
    if (!IsPrompt(answer->answer_to)) {
      ++late_states_;
      continue;
    }
    sample = DriverSample{};
    sample.X_DH = state->X_DH;
    if (!traits_.senses_orientation) sample.X_DH.R_AB = Quat{1, 0, 0, 0};
    sample.homed = state->homed && state->ready;
    sample.buttons = state->buttons;
    actual_f_D_N_ = state->actual_f_D_N;
    has_news = true;
    if (answer->answer_to == header.sequence) break;
  }
  if (has_news) return RoundEnd::kSample;
  return has_bad ? RoundEnd::kBadAnswer : RoundEnd::kNoAnswer;
}

void BridgeDriver::Stop() noexcept {
  if (!running_) return;
  running_ = false;
  // The command is sent twice, since packets may be lost. If both are lost, the bridge sets the force to zero when the
  // last command expires.
  for (int i = 0; i < 2; ++i) {
    link_->Send(WriteBridgeCommand(NextHeader(), BridgeCommand{}));
    link_->Send(WriteBridgeBye(NextHeader()));
  }
}

}  // namespace kerf
