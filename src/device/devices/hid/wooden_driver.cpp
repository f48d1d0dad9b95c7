#include "device/devices/hid/wooden_driver.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>

#include "base/core/vectors.h"
#include "device/devices/hid/hid_report.h"
#include "device/devices/profiles.h"
#include "kerf/error.h"

namespace kerf {
namespace {

constexpr int kTransfer_ms = 5;  // per transfer; a round has at most three
constexpr int kTimeout_ms = 3 * kTransfer_ms;
constexpr std::size_t kEndpointBytes = 64;  // packet size of the endpoint

std::uint16_t GetWord(std::span<const std::uint8_t> bytes, std::size_t at) {
  return static_cast<std::uint16_t>(bytes[at] | bytes[at + 1] << 8);
}

void PutWord(std::span<std::uint8_t> bytes, std::size_t at, std::uint16_t word) {
  bytes[at] = static_cast<std::uint8_t>(word & 0xff);
  bytes[at + 1] = static_cast<std::uint8_t>(word >> 8);
}

/// Describes the zero pose for the user.
std::string DescribeZero(const WoodenParams& params) {
  const std::string pose = fmt::format(
      "base at {:.0f} degrees, upper arm {:.0f} degrees from upright, forearm {:.0f} degrees from hanging straight "
      "down",
      params.zero_deg.x, params.zero_deg.y, params.zero_deg.z);
  return fmt::format(
      "the arm must have been in its zero pose ({}) when it was plugged in{}; otherwise unplug it, hold it in that "
      "pose, and plug it in",
      pose, params.zero_at_start ? ", or when the session began" : "");
}

}  // namespace

bool ReadWoodenReport(std::span<const std::uint8_t> bytes, WoodenReport& report) {
  if (bytes.size() != kWoodenReportBytes) return false;
  for (std::size_t i = 0; i < report.counts.size(); ++i) {
    report.counts[i] = static_cast<std::int16_t>(GetWord(bytes, 2 * i));
  }
  report.counter = GetWord(bytes, 6);
  return true;
}

void WriteWoodenReport(const WoodenReport& report, std::span<std::uint8_t, kWoodenReportBytes> bytes) {
  for (std::size_t i = 0; i < report.counts.size(); ++i) {
    PutWord(bytes, 2 * i, static_cast<std::uint16_t>(report.counts[i]));
  }
  PutWord(bytes, 6, report.counter);
}

void WriteWoodenCurrents(const Vec3& currents_mA, std::span<std::uint8_t, kWoodenReportBytes> bytes) {
  for (int i = 0; i < 3; ++i) {
    const double held = std::isfinite(currents_mA[i]) ? std::clamp(currents_mA[i], -32767.0, 32767.0) : 0.0;
    PutWord(bytes, 2 * static_cast<std::size_t>(i), static_cast<std::uint16_t>(std::lround(held)));
  }
  PutWord(bytes, 6, 0);
}

Vec3 ReadWoodenCurrents(std::span<const std::uint8_t, kWoodenReportBytes> bytes) {
  Vec3 currents_mA;
  for (int i = 0; i < 3; ++i) {
    currents_mA[i] = static_cast<std::int16_t>(GetWord(bytes, 2 * static_cast<std::size_t>(i)));
  }
  return currents_mA;
}

WoodenReportFilter::WoodenReportFilter(const Vec3& counts_per_turn) {
  for (std::size_t i = 0; i < max_counts_.size(); ++i) {
    const double counts = std::abs(counts_per_turn[static_cast<int>(i)]) * kMaxTurnsPerReport;
    max_counts_[i] = static_cast<int>(std::clamp(std::ceil(counts), 1.0, 32767.0));
  }
}

bool WoodenReportFilter::Follows(const WoodenReport& before, const WoodenReport& after) const {
  const int ahead = static_cast<std::uint16_t>(after.counter - before.counter);
  if (ahead == 0 || ahead > kMaxLost + 1) return false;
  for (std::size_t i = 0; i < after.counts.size(); ++i) {
    // 16-bit counts wrap around.
    const auto gone = static_cast<std::int16_t>(after.counts[i] - before.counts[i]);
    if (std::abs(int{gone}) > ahead * max_counts_[i]) return false;
  }
  return true;
}

WoodenReportFilter::Verdict WoodenReportFilter::Judge(const WoodenReport& report) {
  const bool follows_doubtful = has_doubtful_ && Follows(doubtful_, report);
  if (!has_last_ || Follows(last_, report) || follows_doubtful) {
    last_ = report;
    has_last_ = true;
    has_doubtful_ = false;
    return Verdict::kNew;
  }
  if (report.counter == last_.counter) return Verdict::kOld;
  if (has_doubtful_ && report.counter == doubtful_.counter) return Verdict::kOld;
  doubtful_ = report;
  has_doubtful_ = true;
  return Verdict::kBad;
}

WoodenDriver::WoodenDriver(std::unique_ptr<UsbTransport> transport, const WoodenParams& params)
    : transport_(std::move(transport)),
      params_(params),
      profile_(FindDeviceProfile("wooden")),
      filter_(params.counts_per_turn * params.gear) {
  for (int i = 0; i < 3; ++i) {
    if (!(std::abs(params.counts_per_turn[i]) >= 1)) throw Error("counts_per_turn must not be 0 for any joint");
    if (!(std::abs(params.gear[i]) >= 0.1)) throw Error("gear must be 0.1 or more, or -0.1 or less, for each joint");
    const double counts = std::abs(params.counts_per_turn[i] * params.gear[i]);
    if (!(counts <= kWoodenMaxCountsPerTurn)) {
      throw Error(
          fmt::format("counts_per_turn times gear is {:.0f} for a joint; it must be at most {:.0f}, because counts in "
                      "the reports have 16 bits and must not overflow within a turn of the joint",
                      counts, kWoodenMaxCountsPerTurn));
    }
    if (!(params.motor_Nmm_per_A[i] > 0)) throw Error("motor_Nmm_per_A must be above 0 for each motor");
  }
  if (!FindWoodenAngles(params, Vec3{0})) {
    throw Error(
        "the arm can't reach the middle of its workspace; check base_mm, upper_arm_mm, forearm_mm and middle_mm");
  }
  profile_.peak_force_N = params.peak_force_N;
  profile_.continuous_force_N = std::min(profile_.continuous_force_N, params.peak_force_N);
  profile_.max_stiffness_N_per_mm = params.max_stiffness_N_per_mm;
  profile_.max_damping_Ns_per_mm = params.max_damping_Ns_per_mm;
  profile_.workspace_radius_mm = params.workspace_radius_mm;
  traits_.homing = DescribeZero(params);
  traits_.timeout_ms = kTimeout_ms;
}

void WoodenDriver::CheckReportSizes() {
  constexpr std::uint8_t kFromInterface = 0x81, kGetDescriptor = 6;
  constexpr std::uint16_t kReportDescriptor = 0x2200;
  std::array<std::uint8_t, 512> bytes{};
  const Transfer transfer =
      transport_->Control(kFromInterface, kGetDescriptor, kReportDescriptor, 0, bytes, 20 * kTimeout_ms);
  if (transfer.end == TransferEnd::kGone) throw Error("the WoodenHaptics device was unplugged");
  if (transfer.end != TransferEnd::kOk) return;  // the size is also checked in the first report
  const auto sizes = ReadHidReportSizes(std::span(bytes).first(static_cast<std::size_t>(transfer.bytes)));
  const auto wanted = static_cast<int>(kWoodenReportBytes);
  if (!sizes || sizes->has_ids || sizes->input_bytes != wanted || sizes->output_bytes != wanted) {
    throw Error(
        fmt::format("the device {:04x}:{:04x} is not a WoodenHaptics device: its reports are not {} bytes without an "
                    "id (other gadgets made with mbed have the same USB ID)",
                    kWoodenVendor, kWoodenProduct, kWoodenReportBytes));
  }
}

void WoodenDriver::Start(const std::function<bool(const std::string& doing, double fraction)>& show) {
  const auto report_progress = [&show](const std::string& doing, double fraction) {
    if (show && !show(doing, fraction)) throw Error("starting the device was cancelled");
  };
  report_progress("reading the size of the device's reports", 0);
  CheckReportSizes();
  filter_.Reset();
  has_counts_ = false;
  zero_ = {};
  report_progress("waiting for the first report", 0.5);
  // The firmware may hold one old report; the second report is current.
  constexpr int kTries = 50;
  int good = 0;
  for (int i = 0; i < kTries && good < 3; ++i) {
    DriverSample sample;
    const RoundEnd end = Exchange({}, sample);
    if (end == RoundEnd::kGone) throw Error("the WoodenHaptics device was unplugged");
    if (end == RoundEnd::kSample) ++good;
  }
  if (good < 3) {
    throw Error(
        "the WoodenHaptics device sends no reports of 8 bytes; check that its board runs the USB HID firmware, and "
        "plug it in again");
  }
  if (params_.zero_at_start) zero_ = counts_;
  report_progress("ready", 1);
}

RoundEnd WoodenDriver::Send(const Vec3& currents_mA) noexcept {
  std::array<std::uint8_t, kWoodenReportBytes> bytes{};
  WriteWoodenCurrents(currents_mA, bytes);
  const Transfer transfer = transport_->Write(kWoodenOut, bytes, kTransfer_ms);
  if (transfer.end == TransferEnd::kGone) return RoundEnd::kGone;
  const bool whole = transfer.end == TransferEnd::kOk && transfer.bytes == static_cast<int>(kWoodenReportBytes);
  return whole ? RoundEnd::kSample : RoundEnd::kNoAnswer;
}

Vec3 WoodenDriver::CalcAngles() const noexcept {
  WoodenCounts counts{};
  for (std::size_t i = 0; i < counts.size(); ++i) counts[i] = static_cast<std::int16_t>(counts_[i] - zero_[i]);
  return CalcWoodenAngles(params_, counts);
}

RoundEnd WoodenDriver::Exchange(const DriverCommand& command, DriverSample& sample) noexcept {
  const Vec3 f_D_N = LimitLength(command.f_D_N, profile_.peak_force_N);
  const Vec3 currents_mA = has_counts_ ? CalcWoodenCurrents(params_, CalcAngles(), f_D_N) : Vec3{0};
  const RoundEnd sent = Send(currents_mA);
  if (sent == RoundEnd::kGone) return RoundEnd::kGone;

  // Reports arrive unsolicited, so they do not show that the command arrived. If the command did not arrive, the
  // reports are still read, in order to judge later ones, but do not count as an answer. Two reports are read, since
  // the first may be old.
  for (int i = 0; i < 2; ++i) {
    std::array<std::uint8_t, kEndpointBytes> bytes;
    const Transfer transfer = transport_->Read(kWoodenIn, bytes, kTransfer_ms);
    if (transfer.end == TransferEnd::kGone) return RoundEnd::kGone;
    if (transfer.end == TransferEnd::kTimeout) return RoundEnd::kNoAnswer;
    WoodenReport report;
    if (transfer.end != TransferEnd::kOk ||
        !ReadWoodenReport(std::span(bytes).first(static_cast<std::size_t>(transfer.bytes)), report)) {
      return RoundEnd::kBadAnswer;
    }
    const WoodenReportFilter::Verdict verdict = filter_.Judge(report);
    if (verdict == WoodenReportFilter::Verdict::kBad) return RoundEnd::kBadAnswer;
    if (verdict == WoodenReportFilter::Verdict::kOld) continue;
    counts_ = report.counts;
    has_counts_ = true;
    if (sent != RoundEnd::kSample) return sent;
    sample = DriverSample{};
    sample.X_DH.p_AB = CalcWoodenPosition(params_, CalcAngles());
    return RoundEnd::kSample;
  }
  return RoundEnd::kNoAnswer;
}

void WoodenDriver::Stop() noexcept {
  // If no report was ever received, no current was ever sent, and the device may be a different gadget.
  if (transport_ && has_counts_) Send(Vec3{0});
}

}  // namespace kerf
