// 3Dconnexion SpaceMouse and its kin over USB HID: a sprung cap with six axes and buttons; it makes no force. The
// device is silent while nothing changes.
#pragma once

#include <array>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "device/devices/driver.h"
#include "device/devices/usb.h"

namespace kerf {

struct SpaceMouseModel {
  std::uint16_t vendor = 0;
  std::uint16_t product = 0;
  const char* name = "";
  int buttons = 2;
};
/// Those known. Older ones have Logitech's vendor number, newer ones 3Dconnexion's. Source: the lists in OpenCASCADE's
/// WNT_HIDSpaceMouse.cxx and VL.Devices.SpaceMouseHID.
std::span<const SpaceMouseModel> SpaceMouseModels();
/// Null when it is none of them.
const SpaceMouseModel* FindSpaceMouse(const UsbDeviceInfo& info);

/// What the reports have said so far: raw axes x, y, z and about x, y, z, about -350 to 350.
struct SpaceMouseState {
  std::array<int, 6> axes{};
  std::uint32_t buttons = 0;
};
enum class SpaceMouseReport : std::uint8_t {
  kAxes,
  kButtons,
  kOther,  // battery and the like
  kBad,    // not of the length that its kind has, or with an axis far out of range
};
/// Takes a report with its id as the first byte; `state` stays as it is but for kAxes and kButtons.
SpaceMouseReport ReadSpaceMouseReport(std::span<const std::uint8_t> bytes, SpaceMouseState& state);

/// A raw axis as a share of its way: 0 in the dead band (a share, 0 to 0.9), from its edge on evenly to -1 or 1.
double CalcDeflection(int raw, double dead_band);

struct SpaceMouseOptions {
  double dead_band = 0.06;  // 0 to 0.9
};

class SpaceMouseDriver final : public DeviceDriver {
 public:
  /// Throws Error when an option is out of range.
  SpaceMouseDriver(std::unique_ptr<UsbTransport> transport, const SpaceMouseModel& model,
                   const SpaceMouseOptions& options = {});
  ~SpaceMouseDriver() override { SpaceMouseDriver::Stop(); }

  const DeviceProfile& profile() const override { return profile_; }
  const DriverTraits& traits() const override { return traits_; }
  void Start(const std::function<bool(const std::string& doing, double share)>& show) override;
  /// No report is kSample with what was told last; but a cap that is off its middle and says nothing for kSilence_s has
  /// been let go of, and its last word was lost.
  RoundEnd Exchange(const DriverCommand& command, DriverSample& sample) noexcept override;
  void Stop() noexcept override;

  static constexpr double kSilence_s = 0.5;  // of rounds that take two periods each

 private:
  bool SetLamp(bool on) noexcept;

  std::unique_ptr<UsbTransport> transport_;
  SpaceMouseOptions options_;
  DeviceProfile profile_;
  DriverTraits traits_;
  SpaceMouseState state_;
  int silent_rounds_ = 0;
};

}  // namespace kerf
