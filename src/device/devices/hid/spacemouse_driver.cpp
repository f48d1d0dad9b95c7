#include "device/devices/hid/spacemouse_driver.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>

#include "kerf/error.h"

namespace kerf {
namespace {

constexpr int kLedControl_ms = 10;
// The host polls the device once per period, and only while a read is pending, so a read waits longer than one period.
// A round without a report therefore takes two periods. Counting such rounds measures silence without a clock.
constexpr double kRate_hz = 125;
constexpr int kRead_ms = 10;
static_assert(kRead_ms > 1000 / kRate_hz && kRead_ms < 2000 / kRate_hz);
constexpr double kSilentRound_s = 2 / kRate_hz;
constexpr std::uint8_t kIn = 0x81;
constexpr std::size_t kPacketBytes = 64;
constexpr int kFullScale = 350;
constexpr int kMaxRaw = 2000;  // larger values are not valid

constexpr std::uint16_t kLogitech = 0x046d;
constexpr std::uint16_t k3Dconnexion = 0x256f;
constexpr std::array kModels{
    SpaceMouseModel{kLogitech, 0xc603, "SpaceMouse Plus", 11},
    SpaceMouseModel{kLogitech, 0xc605, "CADMan", 4},
    SpaceMouseModel{kLogitech, 0xc606, "SpaceMouse Classic", 8},
    SpaceMouseModel{kLogitech, 0xc621, "SpaceBall 5000", 12},
    SpaceMouseModel{kLogitech, 0xc623, "SpaceTraveler", 8},
    SpaceMouseModel{kLogitech, 0xc625, "SpacePilot", 21},
    SpaceMouseModel{kLogitech, 0xc626, "SpaceNavigator", 2},
    SpaceMouseModel{kLogitech, 0xc627, "SpaceExplorer", 15},
    SpaceMouseModel{kLogitech, 0xc628, "SpaceNavigator for Notebooks", 2},
    SpaceMouseModel{kLogitech, 0xc629, "SpacePilot Pro", 31},
    SpaceMouseModel{kLogitech, 0xc62b, "SpaceMouse Pro", 15},
    SpaceMouseModel{k3Dconnexion, 0xc62e, "SpaceMouse Wireless (cable)", 2},
    SpaceMouseModel{k3Dconnexion, 0xc62f, "SpaceMouse Wireless (receiver)", 2},
    SpaceMouseModel{k3Dconnexion, 0xc631, "SpaceMouse Pro Wireless (cable)", 15},
    SpaceMouseModel{k3Dconnexion, 0xc632, "SpaceMouse Pro Wireless (receiver)", 15},
    SpaceMouseModel{k3Dconnexion, 0xc633, "SpaceMouse Enterprise", 31},
    SpaceMouseModel{k3Dconnexion, 0xc635, "SpaceMouse Compact", 2},
    SpaceMouseModel{k3Dconnexion, 0xc652, "Universal Receiver", 15},
};

/// Reads three 16-bit axes. Returns false if one is far out of range.
bool ReadAxes(std::span<const std::uint8_t> bytes, std::span<int, 3> axes) {
  std::array<int, 3> read{};
  for (std::size_t i = 0; i < read.size(); ++i) {
    read[i] = static_cast<std::int16_t>(bytes[2 * i] | bytes[2 * i + 1] << 8);
    if (std::abs(read[i]) > kMaxRaw) return false;
  }
  std::copy(read.begin(), read.end(), axes.begin());
  return true;
}

}  // namespace

std::span<const SpaceMouseModel> SpaceMouseModels() {
  return kModels;
}

const SpaceMouseModel* FindSpaceMouse(const UsbDeviceInfo& info) {
  for (const SpaceMouseModel& model : kModels) {
    if (model.vendor == info.vendor && model.product == info.product) return &model;
  }
  return nullptr;
}

SpaceMouseReport ReadSpaceMouseReport(std::span<const std::uint8_t> bytes, SpaceMouseState& state) {
  constexpr std::uint8_t kTranslation = 1, kRotation = 2, kButtons = 3;
  constexpr std::size_t kThreeAxes = 7, kSixAxes = 13, kMaxButtonBytes = 7;
  if (bytes.empty()) return SpaceMouseReport::kBad;
  const std::span<int, 6> axes(state.axes);
  switch (bytes[0]) {
    case kTranslation:
      if (bytes.size() == kThreeAxes) {
        return ReadAxes(bytes.subspan(1), axes.first<3>()) ? SpaceMouseReport::kAxes : SpaceMouseReport::kBad;
      }
      if (bytes.size() == kSixAxes) {
        SpaceMouseState read;
        const std::span<int, 6> read_axes(read.axes);
        if (!ReadAxes(bytes.subspan(1), read_axes.first<3>())) return SpaceMouseReport::kBad;
        if (!ReadAxes(bytes.subspan(kThreeAxes), read_axes.last<3>())) return SpaceMouseReport::kBad;
        state.axes = read.axes;
        return SpaceMouseReport::kAxes;
      }
      return SpaceMouseReport::kBad;
    case kRotation:
      if (bytes.size() != kThreeAxes) return SpaceMouseReport::kBad;
      return ReadAxes(bytes.subspan(1), axes.last<3>()) ? SpaceMouseReport::kAxes : SpaceMouseReport::kBad;
    case kButtons: {
      if (bytes.size() < 2 || bytes.size() > kMaxButtonBytes) return SpaceMouseReport::kBad;
      std::uint32_t buttons = 0;
      for (std::size_t i = 1; i < bytes.size() && i <= 4; ++i) buttons |= std::uint32_t{bytes[i]} << (8 * (i - 1));
      state.buttons = buttons;
      return SpaceMouseReport::kButtons;
    }
    default:
      return SpaceMouseReport::kOther;
  }
}

double CalcDeflection(int raw, double dead_band) {
  const double fraction = std::min(std::abs(raw) / double{kFullScale}, 1.0);
  if (fraction <= dead_band) return 0;
  return std::copysign((fraction - dead_band) / (1 - dead_band), raw);
}

SpaceMouseDriver::SpaceMouseDriver(std::unique_ptr<UsbTransport> transport, const SpaceMouseModel& model,
                                   const SpaceMouseOptions& options)
    : transport_(std::move(transport)), options_(options) {
  CheckParameters(options, "SpaceMouse");
  profile_.name = "spacemouse";
  profile_.degrees_of_freedom = 3;
  profile_.peak_force_N = 0;
  profile_.max_stiffness_N_per_mm = 0;
  profile_.max_damping_Ns_per_mm = 0;
  profile_.source = fmt::format("3Dconnexion {}: measures how its cap is pushed, and outputs no force", model.name);
  traits_.motion = DriverMotion::kDeflection;
  traits_.makes_force = false;
  traits_.senses_orientation = true;
  traits_.rate_hz = kRate_hz;
  traits_.timeout_ms = kRead_ms;
  traits_.buttons = {"left", "right"};
  for (int i = 2; i < model.buttons; ++i) traits_.buttons.push_back(fmt::format("button {}", i + 1));
}

bool SpaceMouseDriver::SetLamp(bool on) noexcept {
  constexpr std::uint8_t kToInterface = 0x21, kSetReport = 9;
  constexpr std::uint16_t kOutputReport4 = 0x0204;
  std::array<std::uint8_t, 2> report{4, static_cast<std::uint8_t>(on ? 1 : 0)};
  return transport_->Control(kToInterface, kSetReport, kOutputReport4, 0, report, kLedControl_ms).end !=
         TransferEnd::kGone;
}

void SpaceMouseDriver::Start(const std::function<bool(const std::string& doing, double fraction)>& show) {
  if (show && !show("switching the LED on", 0)) throw Error("starting the device was cancelled");
  state_ = {};
  silent_rounds_ = 0;
  // A device without a lamp refuses this request; only kGone is an error.
  if (!SetLamp(true)) throw Error("the SpaceMouse was unplugged");
  if (show) show("ready", 1);
}

RoundEnd SpaceMouseDriver::Exchange(const DriverCommand& /*command*/, DriverSample& sample) noexcept {
  std::array<std::uint8_t, kPacketBytes> bytes;
  const Transfer transfer = transport_->Read(kIn, bytes, kRead_ms);
  if (transfer.end == TransferEnd::kGone) return RoundEnd::kGone;
  if (transfer.end == TransferEnd::kOk) {
    const auto count = static_cast<std::size_t>(transfer.bytes);
    if (ReadSpaceMouseReport(std::span(bytes).first(count), state_) == SpaceMouseReport::kBad) {
      return RoundEnd::kBadAnswer;
    }
    silent_rounds_ = 0;
  } else if (transfer.end == TransferEnd::kTimeout) {
    if (++silent_rounds_ * kSilentRound_s >= kSilence_s) {
      state_.axes = {};
      silent_rounds_ = 0;
    }
  } else {
    return RoundEnd::kBadAnswer;
  }
  std::array<double, 6> raw{};
  for (std::size_t i = 0; i < raw.size(); ++i) raw[i] = CalcDeflection(state_.axes[i], options_.dead_band);
  sample = DriverSample{};
  // The cap's axes are right, towards the user, and down.
  sample.deflection = {raw[0], -raw[2], raw[1], raw[3], -raw[5], raw[4]};
  sample.buttons = state_.buttons;
  return RoundEnd::kSample;
}

void SpaceMouseDriver::Stop() noexcept {
  if (transport_) SetLamp(false);
}

}  // namespace kerf
