// A transport directly to a device's model, without faults and without heap use of its own.
#pragma once

#include "device/devices/usb.h"
#include "device/emulation/usb_model.h"

namespace kerf::test {

/// Transport to a model. A read without data advances the model once by the timeout.
class DirectLine final : public UsbTransport {
 public:
  explicit DirectLine(UsbModel& model) : model_(model) {}

  Transfer Control(std::uint8_t request_type, std::uint8_t request, std::uint16_t value, std::uint16_t index,
                   std::span<std::uint8_t> data, int /*timeout_ms*/) noexcept override {
    return model_.Control(request_type, request, value, index, data);
  }
  Transfer Write(std::uint8_t endpoint, std::span<const std::uint8_t> data, int /*timeout_ms*/) noexcept override {
    return model_.Write(endpoint, data);
  }
  Transfer Read(std::uint8_t endpoint, std::span<std::uint8_t> data, int timeout_ms) noexcept override {
    const Transfer transfer = model_.Read(endpoint, data);
    if (transfer.end != TransferEnd::kTimeout) return transfer;
    model_.Advance(1e-3 * timeout_ms);
    return model_.Read(endpoint, data);
  }

 private:
  UsbModel& model_;
};

}  // namespace kerf::test
