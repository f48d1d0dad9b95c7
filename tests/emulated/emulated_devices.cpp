#include "emulated/emulated_devices.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "emulation/falcon_model.h"
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
  bool wants_homing() const override { return driven() && !model_.homed(); }
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

}  // namespace

const std::vector<std::string>& NamesOfEmulatedDevices() {
  static const std::vector<std::string> names = {"falcon"};
  return names;
}

std::unique_ptr<EmulatedDevice> MakeEmulatedDevice(const std::string& name, Mechanism& mechanism,
                                                   const EmulatedDeviceOptions& options) {
  if (name == "falcon") return std::make_unique<EmulatedFalcon>(mechanism, options);
  throw Error(fmt::format("no device of the name \"{}\" can be emulated; there are: {}", name,
                          fmt::join(NamesOfEmulatedDevices(), ", ")));
}

}  // namespace kerf::test
