// Driver of the 3Dconnexion SpaceMouse and related devices over USB HID: a spring-centred cap with six axes and
// buttons, without force. The device sends nothing while its cap is at rest and no button changes.
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
/// Returns the known models. Older ones have Logitech's vendor ID, newer ones that of 3Dconnexion. Source: the lists in
/// OpenCASCADE's WNT_HIDSpaceMouse.cxx and VL.Devices.SpaceMouseHID.
std::span<const SpaceMouseModel> SpaceMouseModels();
/// Returns nullptr if the device is not a known model.
const SpaceMouseModel* FindSpaceMouse(const UsbDeviceInfo& info);

/// State according to the reports so far: raw axes x, y, z and rotations about x, y, z, each about -350 to 350.
struct SpaceMouseState {
  std::array<int, 6> axes{};
  std::uint32_t buttons = 0;
};
enum class SpaceMouseReport : std::uint8_t {
  kAxes,
  kButtons,
  kOther,  // battery state, for example
  kBad,    // wrong length for its kind, or an axis far out of range
};
/// Reads a report, which begins with its id. `state` changes only for kAxes and kButtons.
SpaceMouseReport ReadSpaceMouseReport(std::span<const std::uint8_t> bytes, SpaceMouseState& state);

/// Converts a raw axis to a fraction of its range: 0 within `dead_band`, then linear up to -1 or 1.
double CalcDeflection(int raw, double dead_band);

struct SpaceMouseOptions {
  double dead_band = 0.06;
};
template <typename V>
void Describe(SpaceMouseOptions& p, V&& visit) {
  visit("dead_band", p.dead_band, Range{0, 0.9}, "fraction of an axis's range that counts as 0");
}

class SpaceMouseDriver final : public DeviceDriver {
 public:
  /// Throws kerf::Error if an option is out of range.
  SpaceMouseDriver(std::unique_ptr<UsbTransport> transport, const SpaceMouseModel& model,
                   const SpaceMouseOptions& options = {});
  ~SpaceMouseDriver() override { SpaceMouseDriver::Stop(); }

  const DeviceProfile& profile() const override { return profile_; }
  const DriverTraits& traits() const override { return traits_; }
  void Start(const std::function<bool(const std::string& doing, double fraction)>& show) override;
  /// If no report has arrived, returns kSample with the last state. If a deflected cap sends nothing for kSilence_s, it
  /// is assumed that it was released and that its last report was lost.
  RoundEnd Exchange(const DriverCommand& command, DriverSample& sample) noexcept override;
  void Stop() noexcept override;

  static constexpr double kSilence_s = 0.5;  // correct if each round without a report takes two periods

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
