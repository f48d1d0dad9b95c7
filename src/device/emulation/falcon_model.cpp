#include "device/emulation/falcon_model.h"

#include <algorithm>
#include <utility>

#include "device/devices/falcon/falcon_usb.h"

namespace kerf {
namespace {

constexpr std::size_t kShortReportBytes = 14;
constexpr std::size_t kMinFirmwareBytes = 1024;
constexpr std::size_t kMaxWaitingBytes = 384;  // size of the FT232's buffer towards the host
constexpr std::uint8_t kModemStatus = 0x01;
constexpr std::uint8_t kLineStatus = 0x60;
// A time long before the clock's origin, so that no packet is recent at the start.
constexpr double kLongAgo_s = -1;

}  // namespace

FalconModel::FalconModel(Mechanism& mechanism, FalconModelOptions options)
    : mechanism_(mechanism), options_(std::move(options)) {
  PlugIn();
  SwitchOn();
  if (!options_.firmware_is_there) return;
  state_ = State::kRun;
  if (options_.homed) homed_ = kFalconAllHomed;
}

void FalconModel::PowerOn() {
  PlugIn();
  if (!options_.keeps_power) SwitchOn();
}

void FalconModel::PlugIn() {
  baud_ = 0;
  format_ = kFtdiFormat8N1;
  flow_ = 0;
  latency_ms_ = kFalconLatencyBoot_ms;
  dtr_ = false;
  rts_ = false;
  to_host_.clear();
  last_packet_s_ = kLongAgo_s;
  stream_.Forget();
}

void FalconModel::SwitchOn() {
  state_ = State::kBoot;
  greeted_ = 0;
  command_ = FalconCommand{};
  was_out_ = 0;
  homed_ = 0;
  f_D_N_ = Vec3{0};
  ReadEncoders();
}

std::vector<std::uint8_t> FalconModel::descriptors() const {
  // Descriptors of device, configuration, interface and endpoints: an FT232BM with the Falcon's product number.
  return {
      18,   1,    0x10,
      0x01, 0,    0,
      0,    8,    0x03,
      0x04, 0x48, 0xcb,
      0x00, 0x04, 0,
      0,    0,    1,  // device
      9,    2,    32,
      0,    1,    1,
      0,    0x80, 45,  // configuration
      9,    4,    0,
      0,    2,    0xff,
      0xff, 0xff, 0,  // interface
      7,    5,    kFalconEndpointIn,
      2,    64,   0,
      0,  //
      7,    5,    kFalconEndpointOut,
      2,    64,   0,
      0,
  };
}

void FalconModel::Advance(double dt_s) {
  if (!(dt_s > 0)) return;
  now_s_ += dt_s;
  SetForce();
  mechanism_.Move(dt_s, f_D_N_, Vec3{0});
  ReadEncoders();
}

void FalconModel::SetForce() {
  f_D_N_ = Vec3{0};
  if (state_ != State::kRun || command_.motors == std::array<int, 3>{}) return;
  Vec3 tau_Nmm{0};
  for (int i = 0; i < 3; ++i) tau_Nmm[i] = command_.motors[static_cast<std::size_t>(i)] / options_.motor_counts_per_Nmm;
  f_D_N_ = CalcFalconForce(mechanism_.handle().p_AB, tau_Nmm).value_or(Vec3{0});
}

void FalconModel::ReadEncoders() {
  const std::optional<FalconAngles> angles = CalcFalconAnglesAt(mechanism_.handle().p_AB);
  if (!angles) return;
  counts_ = CalcFalconCounts(*angles);
  if (state_ != State::kRun || !command_.homing) return;
  for (std::size_t i = 0; i < 3; ++i) {
    const auto bit = static_cast<std::uint8_t>(1U << i);
    if (counts_[i] > kFalconHomingOut) was_out_ |= bit;
    if ((was_out_ & bit) != 0 && counts_[i] < kFalconHomingIn) homed_ |= bit;
  }
}

Transfer FalconModel::Control(std::uint8_t request_type, std::uint8_t request, std::uint16_t value, std::uint16_t index,
                              std::span<std::uint8_t> data) {
  const Transfer refused = {TransferEnd::kStall, 0};
  if (request_type != kFtdiRequestType || index != 0 || !data.empty()) return refused;
  switch (request) {
    case kFtdiReset:
      if (value > kFtdiPurgeSending) return refused;
      if (value != kFtdiPurgeSending) to_host_.clear();
      if (value != kFtdiPurgeReceived) stream_.Forget();
      break;
    case kFtdiModemLines: {
      const bool had_dtr = dtr_;
      if ((value & 0x0100U) != 0) dtr_ = (value & 1U) != 0;
      if ((value & 0x0200U) != 0) rts_ = (value & 2U) != 0;
      // A low DTR holds the Falcon's processor in reset.
      if (!had_dtr && dtr_ && baud_ == kFalconBaudBoot) {
        state_ = State::kBoot;
        greeted_ = 0;
        command_ = FalconCommand{};
        was_out_ = 0;
        homed_ = 0;
      }
      break;
    }
    case kFtdiFlowControl:
      flow_ = value;
      break;
    case kFtdiBaud:
      baud_ = value;
      if (state_ == State::kLoaded && baud_ == kFalconBaudRun) state_ = State::kRun;
      break;
    case kFtdiFormat:
      format_ = value;
      break;
    case kFtdiLatency:
      if (value < 1 || value > 255) return refused;
      latency_ms_ = value;
      break;
    default:
      return refused;
  }
  return {TransferEnd::kOk, 0};
}

Transfer FalconModel::Write(std::uint8_t endpoint, std::span<const std::uint8_t> data) {
  if (endpoint != kFalconEndpointOut) return {TransferEnd::kStall, 0};
  for (const std::uint8_t byte : data) {
    if (format_ != kFtdiFormat8N1 || flow_ != 0) continue;
    if (state_ != State::kRun) {
      BootByte(byte);
    } else if (baud_ == kFalconBaudRun) {
      RunByte(byte);
    }
  }
  return {TransferEnd::kOk, static_cast<int>(data.size())};
}

void FalconModel::BootByte(std::uint8_t byte) {
  switch (state_) {
    case State::kBoot:
      if (baud_ != kFalconBaudBoot || !dtr_ || rts_) return;
      greeted_ = byte == kFalconHello[greeted_] ? greeted_ + 1 : (byte == kFalconHello[0] ? 1 : 0);
      if (greeted_ < std::size(kFalconHello)) return;
      greeted_ = 0;
      if (options_.zero_before_answer) Send(0);
      for (const std::uint8_t answer : kFalconHelloAnswer) Send(answer);
      to_host_.back().ends_packet = true;
      state_ = State::kGreeted;
      return;
    case State::kGreeted:
      // A repeated greeting is answered again.
      if (baud_ == kFalconBaudBoot && dtr_) {
        state_ = State::kBoot;
        BootByte(byte);
        return;
      }
      if (baud_ != kFalconBaudLoad || dtr_ || byte != kFalconLoadMark) return;
      Send(byte);
      to_host_.back().ends_packet = true;
      loaded_.clear();
      ++uploads_;
      state_ = State::kLoading;
      return;
    case State::kLoading:
    case State::kLoaded: {
      if (baud_ != kFalconBaudLoad) return;
      loaded_.push_back(byte);
      const bool wrong = uploads_ <= options_.wrong_echoes && loaded_.size() == kMinFirmwareBytes / 2;
      Send(wrong ? static_cast<std::uint8_t>(byte ^ 0x10U) : byte);
      const bool whole = options_.firmware.empty() ? loaded_.size() >= kMinFirmwareBytes : loaded_ == options_.firmware;
      state_ = whole && uploads_ > options_.wrong_echoes ? State::kLoaded : State::kLoading;
      return;
    }
    case State::kRun:
      return;
  }
}

void FalconModel::RunByte(std::uint8_t byte) {
  if (!stream_.Put(byte)) return;
  const std::optional<FalconCommand> command = UnpackCommand(stream_.packet());
  if (!command) return;
  command_ = *command;
  ++commands_;
  saw_homing_off_ = saw_homing_off_ || !command->homing;
  SetForce();
  Answer();
}

void FalconModel::Answer() {
  ReadEncoders();
  FalconReport report;
  for (std::size_t i = 0; i < 3; ++i) {
    report.counts[i] = counts_[i] + ((homed_ >> i & 1U) != 0 ? 0 : options_.zero_offset[i]);
  }
  report.buttons = static_cast<std::uint8_t>(mechanism_.buttons() & 0xfU);
  report.homed = homed_;
  const FalconPacket packet = Pack(report);
  ++reports_;
  const auto is_turn = [&](int every) { return every > 0 && reports_ % static_cast<std::uint64_t>(every) == 0; };
  const std::size_t bytes = is_turn(options_.short_report_every) ? kShortReportBytes : kFalconPacketBytes;
  for (std::size_t i = 0; i < bytes; ++i) {
    Send(packet[i]);
    if (is_turn(options_.split_report_every) && i == bytes / 2) to_host_.back().ends_packet = true;
  }
}

void FalconModel::Send(std::uint8_t byte) {
  if (to_host_.size() >= kMaxWaitingBytes) return;
  to_host_.push_back({byte, now_s_ + (state_ == State::kRun ? options_.answer_after_s : 0), false});
}

Transfer FalconModel::Read(std::uint8_t endpoint, std::span<std::uint8_t> data) {
  if (endpoint != kFalconEndpointIn) return {TransferEnd::kStall, 0};
  if (data.size() < kFtdiStatusBytes) return {TransferEnd::kFailed, 0};
  const std::size_t max_count = std::min(data.size(), kFalconUsbPacketBytes);
  std::size_t count = kFtdiStatusBytes;
  while (count < max_count && !to_host_.empty() && to_host_.front().at_s <= now_s_) {
    const Byte byte = to_host_.front();
    to_host_.pop_front();
    data[count++] = byte.value;
    if (byte.ends_packet) break;
  }
  if (count == kFtdiStatusBytes && now_s_ < last_packet_s_ + 1e-3 * latency_ms_) return {TransferEnd::kTimeout, 0};
  last_packet_s_ = now_s_;
  data[0] = kModemStatus;
  data[1] = kLineStatus;
  return {TransferEnd::kOk, static_cast<int>(count)};
}

}  // namespace kerf
