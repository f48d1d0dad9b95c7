#include "device/emulated/emulated_devices.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>

#include "device/emulation/falcon_model.h"
#include "device/emulation/spacemouse_model.h"
#include "device/emulation/wooden_model.h"
#include "kerf/error.h"

namespace kerf::test {
namespace {

FalconModelOptions MakeFalconOptions(const EmulatedDeviceOptions& options) {
  FalconModelOptions falcon;
  falcon.firmware = options.firmware;
  falcon.firmware_is_there = options.firmware_is_there;
  falcon.homed = options.homed;
  falcon.wrong_echoes = options.wrong_echoes;
  return falcon;
}

class EmulatedFalcon final : public EmulatedDevice {
 public:
  EmulatedFalcon(Mechanism& mechanism, const EmulatedDeviceOptions& options)
      : model_(mechanism, MakeFalconOptions(options)) {}

  UsbModel& model() override { return model_; }
  bool driven() const override { return model_.runs() && model_.commands() > 0; }
  std::uint64_t packets() const override { return model_.commands(); }
  bool wants_homing() const override { return driven() && !model_.homed(); }
  bool engaged() const override { return driven() && model_.last_command().lamps == kFalconGreen; }
  bool waits() const override { return driven() && model_.last_command().lamps == kFalconBlue; }
  nlohmann::ordered_json Report() const override {
    return {{"device", "falcon"},
            {"runs", model_.runs()},
            {"homed", model_.homed()},
            {"uploads", model_.uploads()},
            {"firmware_bytes", model_.loaded().size()},
            {"commands", model_.commands()},
            {"homing_bit_was_off", model_.saw_homing_off()},
            {"motors_at_end", model_.last_command().motors}};
  }

 private:
  FalconModel model_;
};

class EmulatedWooden final : public EmulatedDevice {
 public:
  explicit EmulatedWooden(Mechanism& mechanism) : model_(mechanism) {}

  UsbModel& model() override { return model_; }
  bool driven() const override { return model_.packets() > 0; }
  std::uint64_t packets() const override { return model_.packets(); }
  nlohmann::ordered_json Report() const override {
    const Vec3 currents = model_.currents_mA();
    return {{"device", "wooden"},
            {"packets", model_.packets()},
            {"motors_on", model_.motors_on()},
            {"currents_at_end_mA", {currents.x, currents.y, currents.z}}};
  }

 private:
  WoodenModel model_;
};

/// A SpaceMouse whose cap is deflected in proportion to the hand's distance from the middle, fully at 20 mm.
class EmulatedSpaceMouse final : public EmulatedDevice {
 public:
  UsbModel& model() override { return model_; }
  bool driven() const override { return model_.lamp(); }
  void Follow(Mechanism& hand, double dt_s) override {
    hand.Move(dt_s, Vec3{0}, Vec3{0});
    constexpr double kFull = 350;
    constexpr double kFull_mm = 20;
    const Vec3 p_D_mm = hand.handle().p_AB;
    const auto raw = [](double mm) { return static_cast<int>(std::clamp(mm / kFull_mm, -1.0, 1.0) * kFull); };
    model_.Push({raw(p_D_mm.x), raw(p_D_mm.z), raw(-p_D_mm.y), 0, 0, 0});
    model_.Press(hand.buttons());
  }
  nlohmann::ordered_json Report() const override { return {{"device", "spacemouse"}, {"lamp", model_.lamp()}}; }

 private:
  SpaceMouseEmulation model_;
};

}  // namespace

const std::vector<std::string>& NamesOfEmulatedDevices() {
  static const std::vector<std::string> names = {"falcon", "wooden", "spacemouse"};
  return names;
}

std::unique_ptr<EmulatedDevice> MakeEmulatedDevice(const std::string& name, Mechanism& mechanism,
                                                   const EmulatedDeviceOptions& options) {
  if (name == "falcon") return std::make_unique<EmulatedFalcon>(mechanism, options);
  if (name == "wooden") return std::make_unique<EmulatedWooden>(mechanism);
  if (name == "spacemouse") return std::make_unique<EmulatedSpaceMouse>();
  throw Error(fmt::format("can't emulate a device named \"{}\"; available devices: {}", name,
                          fmt::join(NamesOfEmulatedDevices(), ", ")));
}

}  // namespace kerf::test
