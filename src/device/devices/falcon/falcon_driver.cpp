#include "device/devices/falcon/falcon_driver.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "base/core/sha256.h"
#include "base/core/vectors.h"
#include "device/devices/falcon/falcon_usb.h"
#include "device/devices/profiles.h"
#include "kerf/error.h"

namespace kerf {
namespace {

constexpr int kControl_ms = 500;
constexpr int kBootTransfer_ms = 100;
constexpr int kMaxUploads = 10;
constexpr int kGreetings = 30;
constexpr int kProbes = 10;
constexpr int kReadsPerRound = 8;

constexpr const char* kGoneInStart = "the Falcon was unplugged while it was being started; plug it in and try again";

}  // namespace

void CheckFalconFirmware(const std::vector<std::uint8_t>& firmware, const std::string& file) {
  if (firmware.size() < kFalconMinFirmwareBytes || firmware.size() > kFalconMaxFirmwareBytes) {
    throw Error(fmt::format("{}: has {} bytes and can't be Falcon firmware, which has {} to {}", file, firmware.size(),
                            kFalconMinFirmwareBytes, kFalconMaxFirmwareBytes));
  }
}

FalconDriver::FalconDriver(std::unique_ptr<UsbTransport> transport, FalconOptions options)
    : transport_(std::move(transport)), options_(std::move(options)), profile_(FindDeviceProfile("falcon")) {
  if (!options_.firmware.empty()) {
    CheckFalconFirmware(options_.firmware, "the Falcon's firmware");
    sha256_ = CalcSha256(options_.firmware);
  }
  CheckParameters(options_, "Falcon");
  if (!std::isfinite(options_.motor_counts_per_Nmm) || options_.motor_counts_per_Nmm == 0) {
    throw Error("Falcon: motor_counts_per_Nmm must be finite and other than 0");
  }
  traits_.homes = true;
  traits_.homing = "pull the Falcon's grip all the way out, then push it all the way in";
  traits_.rate_hz = 1000;
  traits_.timeout_ms = options_.timeout_ms;
  traits_.buttons = {"plus", "forward", "centre", "minus"};
}

FalconDriver::~FalconDriver() {
  Stop();
}

FalconDriver::Step FalconDriver::Set(std::uint8_t request, std::uint16_t value) noexcept {
  const Transfer transfer = transport_->Control(kFtdiRequestType, request, value, 0, {}, kControl_ms);
  if (transfer.end == TransferEnd::kGone) return Step::kGone;
  return transfer.end == TransferEnd::kOk ? Step::kDone : Step::kFailed;
}

FalconDriver::Step FalconDriver::SendAll(std::span<const std::uint8_t> bytes) noexcept {
  const Transfer transfer = transport_->Write(kFalconEndpointOut, bytes, kBootTransfer_ms);
  if (transfer.end == TransferEnd::kGone) return Step::kGone;
  const bool all = transfer.end == TransferEnd::kOk && transfer.bytes == static_cast<int>(bytes.size());
  return all ? Step::kDone : Step::kFailed;
}

FalconDriver::Step FalconDriver::AwaitEcho(std::span<const std::uint8_t> bytes, bool skip_others) noexcept {
  std::size_t matched = 0;
  // A chunk takes 5 ms to transmit, and a packet with or without data arrives every 16 ms.
  constexpr int kMaxReads = 12;
  constexpr int kMaxSilent = 2;
  int silent = 0;
  for (int i = 0; i < kMaxReads && silent < kMaxSilent && matched < bytes.size(); ++i) {
    std::array<std::uint8_t, kFalconUsbPacketBytes> packet{};
    const Transfer transfer = transport_->Read(kFalconEndpointIn, packet, kBootTransfer_ms);
    if (transfer.end == TransferEnd::kGone) return Step::kGone;
    if (transfer.bytes < 0) return Step::kFailed;
    silent = transfer.bytes == 0 ? silent + 1 : 0;
    for (const std::uint8_t byte : CutFtdiStatus(std::span(packet).first(static_cast<std::size_t>(transfer.bytes)))) {
      if (matched < bytes.size() && byte == bytes[matched]) {
        ++matched;
      } else if (skip_others) {
        matched = byte == bytes[0] ? 1 : 0;
      } else {
        return Step::kFailed;
      }
    }
    if (transfer.end != TransferEnd::kOk && transfer.end != TransferEnd::kTimeout) return Step::kFailed;
  }
  return matched == bytes.size() ? Step::kDone : Step::kFailed;
}

FalconDriver::Step FalconDriver::EnterRunMode() noexcept {
  struct Setting {
    std::uint8_t request;
    std::uint16_t value;
  };
  for (const Setting& setting : {Setting{kFtdiLatency, kFalconLatencyRun_ms}, Setting{kFtdiBaud, kFalconBaudRun},
                                 Setting{kFtdiReset, kFtdiPurgeReceived}, Setting{kFtdiReset, kFtdiPurgeSending}}) {
    if (const Step step = Set(setting.request, setting.value); step != Step::kDone) return step;
  }
  stream_.Forget();
  return Step::kDone;
}

/// Returns kDone if reports are received.
FalconDriver::Step FalconDriver::LooksAlive() noexcept {
  for (int probe = 0; probe < kProbes; ++probe) {
    const FalconPacket packet = Pack(FalconCommand{.motors = {}, .homing = true, .lamps = kFalconRed});
    if (const Step step = SendAll(packet); step != Step::kDone) return step;
    constexpr int kReads = 4;
    constexpr int kRead_ms = 10;
    for (int i = 0; i < kReads; ++i) {
      std::array<std::uint8_t, kFalconUsbPacketBytes> bytes{};
      const Transfer transfer = transport_->Read(kFalconEndpointIn, bytes, kRead_ms);
      if (transfer.end == TransferEnd::kGone) return Step::kGone;
      if (transfer.bytes < 0) return Step::kFailed;
      if (TakeReport(CutFtdiStatus(std::span(bytes).first(static_cast<std::size_t>(transfer.bytes))))) {
        return Step::kDone;
      }
    }
  }
  return Step::kFailed;
}

/// Prepares the serial port and the boot loader until the boot loader expects the firmware.
FalconDriver::Step FalconDriver::Greet(const std::function<void()>& report_progress) {
  struct Setting {
    std::uint8_t request;
    std::uint16_t value;
  };
  for (const Setting& setting :
       {Setting{kFtdiReset, kFtdiPurgeReceived}, Setting{kFtdiReset, kFtdiPurgeSending},
        Setting{kFtdiLatency, kFalconLatencyBoot_ms}, Setting{kFtdiBaud, kFalconBaudBoot},
        Setting{kFtdiFormat, kFtdiFormat8N1}, Setting{kFtdiFlowControl, 0}, Setting{kFtdiModemLines, kFtdiRtsLow},
        Setting{kFtdiModemLines, kFtdiDtrLow}, Setting{kFtdiModemLines, kFtdiDtrHigh}}) {
    if (const Step step = Set(setting.request, setting.value); step != Step::kDone) return step;
  }
  Step answered = Step::kFailed;
  for (int i = 0; i < kGreetings && answered == Step::kFailed; ++i) {
    report_progress();
    if (const Step step = SendAll(kFalconHello); step != Step::kDone) return step;
    answered = AwaitEcho(kFalconHelloAnswer, true);
  }
  if (answered != Step::kDone) return answered;
  for (const Setting& setting : {Setting{kFtdiModemLines, kFtdiDtrLow}, Setting{kFtdiBaud, kFalconBaudLoad}}) {
    if (const Step step = Set(setting.request, setting.value); step != Step::kDone) return step;
  }
  if (const Step step = SendAll(std::span(&kFalconLoadMark, 1)); step != Step::kDone) return step;
  return AwaitEcho(std::span(&kFalconLoadMark, 1), true);
}

FalconDriver::Step FalconDriver::Upload(const Show& show, int attempt) {
  const std::string doing = attempt == 1 ? std::string("loading the Falcon's firmware")
                                         : fmt::format("loading the Falcon's firmware, attempt {}", attempt);
  const auto report_progress = [&](double fraction) {
    if (show && !show(doing, fraction)) throw Error("loading the Falcon's firmware was cancelled");
  };
  report_progress(0);
  if (const Step step = Greet([&] { report_progress(0); }); step != Step::kDone) return step;
  const std::span<const std::uint8_t> firmware = options_.firmware;
  for (std::size_t at = 0; at < firmware.size(); at += kFalconChunkBytes) {
    const std::span<const std::uint8_t> chunk = firmware.subspan(at, std::min(kFalconChunkBytes, firmware.size() - at));
    if (const Step step = SendAll(chunk); step != Step::kDone) return step;
    if (const Step step = AwaitEcho(chunk, false); step != Step::kDone) return step;
    report_progress(static_cast<double>(at + chunk.size()) / static_cast<double>(firmware.size()));
  }
  if (const Step step = EnterRunMode(); step != Step::kDone) return step;
  return LooksAlive();
}

void FalconDriver::Start(const Show& show) {
  has_accepted_ = has_doubtful_ = has_position_ = false;
  must_drain_ = true;
  if (show && !show("checking whether the Falcon is running", 0)) throw Error("starting the Falcon was cancelled");
  Step step = EnterRunMode();
  if (step == Step::kFailed) {
    throw Error("the Falcon's USB port rejected its settings; unplug it, wait a few seconds and plug it in again");
  }
  if (step == Step::kDone) step = LooksAlive();
  if (step == Step::kGone) throw Error(kGoneInStart);
  if (step == Step::kDone) return;
  if (options_.firmware.empty()) {
    throw Error(
        fmt::format("the Falcon has no firmware yet, and kerf may not distribute it; provide the maker's file with {} "
                    "or in the environment variable {} (docs/falcon.md describes where to find it)",
                    kFalconFirmwareOption, kFalconFirmwareVariable));
  }
  for (int attempt = 1; attempt <= kMaxUploads; ++attempt) {
    step = Upload(show, attempt);
    if (step == Step::kGone) throw Error(kGoneInStart);
    if (step == Step::kDone) return;
  }
  throw Error(
      fmt::format("the Falcon accepted no firmware in {} attempts; unplug its power and USB for ten seconds, plug "
                  "both in and try again; if that does not help, the file (SHA-256 {}) may be the wrong one",
                  kMaxUploads, sha256_));
}

/// Extracts the last report from `bytes` into report_. Returns false if there is none.
bool FalconDriver::TakeReport(std::span<const std::uint8_t> bytes) noexcept {
  bool any = false;
  for (const std::uint8_t byte : bytes) {
    if (!stream_.Put(byte)) continue;
    const std::optional<FalconReport> report = UnpackReport(stream_.packet());
    if (!report) continue;
    report_ = *report;
    any = true;
  }
  return any;
}

void FalconDriver::CalcMotors(const DriverCommand& command) noexcept {
  motors_ = {};
  if (!has_position_) return;
  const Vec3 f_D_N = LimitLength(command.f_D_N, profile_.peak_force_N);
  const std::optional<Vec3> tau_Nmm = CalcFalconTorques(forward_.p_D_mm(), f_D_N);
  if (!tau_Nmm) return;
  Vec3 counts = options_.motor_counts_per_Nmm * *tau_Nmm;
  const double largest = std::max({std::abs(counts.x), std::abs(counts.y), std::abs(counts.z)});
  if (!std::isfinite(largest)) return;
  if (largest > options_.max_motor_counts) counts *= options_.max_motor_counts / largest;
  for (int i = 0; i < 3; ++i) {
    motors_[static_cast<std::size_t>(i)] =
        std::clamp(static_cast<int>(std::lround(counts[i])), -options_.max_motor_counts, options_.max_motor_counts);
  }
}

bool FalconDriver::IsJump(const FalconReport& from, const FalconReport& to) const noexcept {
  if (from.homed != to.homed) return true;
  for (std::size_t i = 0; i < 3; ++i) {
    if (std::abs(from.counts[i] - to.counts[i]) > options_.max_jump_counts) return true;
  }
  return false;
}

/// Checks whether the received report is plausible, and computes the sample from it.
RoundEnd FalconDriver::Judge(DriverSample& sample) noexcept {
  if (!has_accepted_ || IsJump(accepted_, report_)) {
    const bool confirmed = has_doubtful_ && !IsJump(doubtful_, report_);
    doubtful_ = report_;
    has_doubtful_ = true;
    if (!confirmed) return RoundEnd::kBadAnswer;
    if (!has_accepted_ || accepted_.homed != report_.homed) has_position_ = false;  // the encoders' zero has changed
  }
  has_doubtful_ = false;
  has_accepted_ = true;
  accepted_ = report_;
  const bool homed = report_.homed == kFalconAllHomed;
  if (!homed) {
    has_position_ = false;
    sample = DriverSample{};
  } else {
    if (!has_position_) forward_.Forget();
    // If there is no solution, keep the last position. Dropping it would cause one round without force, followed by one
    // with full force.
    if (!forward_.Solve(CalcFalconAngles(report_.counts))) return RoundEnd::kBadAnswer;
    has_position_ = true;
    sample = DriverSample{};
    sample.X_DH.p_AB = forward_.p_D_mm();
  }
  sample.homed = homed;
  sample.buttons = report_.buttons;
  return RoundEnd::kSample;
}

RoundEnd FalconDriver::Exchange(const DriverCommand& command, DriverSample& sample) noexcept {
  CalcMotors(command);
  FalconCommand out;
  out.motors = motors_;
  out.lamps = !has_position_ ? kFalconRed : (command.engaged ? kFalconGreen : kFalconBlue);
  const int write_ms = options_.timeout_ms / 5;
  const int read_ms = (options_.timeout_ms - write_ms) / kReadsPerRound;
  const FalconPacket packet_out = Pack(out);
  const Transfer sent = transport_->Write(kFalconEndpointOut, packet_out, write_ms);
  if (sent.end == TransferEnd::kGone) return RoundEnd::kGone;
  const bool heard = sent.end == TransferEnd::kOk && sent.bytes == static_cast<int>(packet_out.size());

  // A late answer would delay all later ones by one round. Therefore, after a round without an answer, read until
  // nothing arrives for about 3 ms, and use the last report.
  constexpr int kQuietReads = 3;
  const bool drains = must_drain_;
  bool any_report = false;
  bool any_bytes = false;
  bool done = false;
  int quiet = 0;
  for (int i = 0; i < kReadsPerRound && !done; ++i) {
    std::array<std::uint8_t, kFalconUsbPacketBytes> packet;
    const Transfer transfer = transport_->Read(kFalconEndpointIn, packet, read_ms);
    if (transfer.end == TransferEnd::kGone) return RoundEnd::kGone;
    const auto count = static_cast<std::size_t>(std::clamp(transfer.bytes, 0, static_cast<int>(packet.size())));
    const std::span<const std::uint8_t> bytes = CutFtdiStatus(std::span(packet).first(count));
    any_bytes = any_bytes || !bytes.empty();
    any_report = TakeReport(bytes) || any_report;
    quiet = bytes.empty() ? quiet + 1 : 0;
    done = any_report && (!drains || quiet >= kQuietReads);
  }
  must_drain_ = !any_report || !heard;
  if (!any_report) return any_bytes ? RoundEnd::kBadAnswer : RoundEnd::kNoAnswer;
  if (heard) return Judge(sample);
  // A report for an earlier command serves to judge the next report, but does not count as an answer.
  DriverSample before;
  const RoundEnd end = Judge(before);
  return end == RoundEnd::kSample ? RoundEnd::kNoAnswer : end;
}

void FalconDriver::Stop() noexcept {
  // The packet is sent twice, because the first one may be merged with a truncated packet.
  const FalconPacket packet = Pack(FalconCommand{.motors = {}, .homing = true, .lamps = kFalconRed});
  for (int i = 0; i < 2; ++i) transport_->Write(kFalconEndpointOut, packet, kBootTransfer_ms);
  motors_ = {};
  has_accepted_ = has_doubtful_ = has_position_ = false;
  must_drain_ = true;
}

}  // namespace kerf
