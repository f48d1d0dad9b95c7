// The smallest device that has all kinds of transfers: it returns the data that it receives.
#pragma once

#include <algorithm>
#include <deque>
#include <vector>

#include "device/emulation/usb_model.h"

namespace kerf::test {

struct EchoModelOptions {
  std::uint16_t vendor = 0x1209;
  std::uint16_t product = 1;
  bool hid = false;  // interrupt endpoints and HID class; otherwise bulk endpoints
};

class EchoModel final : public UsbModel {
 public:
  explicit EchoModel(const EchoModelOptions& options = {}) : options_(options) {}

  std::vector<std::uint8_t> descriptors() const override {
    const auto low = [](int both) { return static_cast<std::uint8_t>(both & 0xff); };
    const auto high = [](int both) { return static_cast<std::uint8_t>(both >> 8); };
    const std::uint8_t type = options_.hid ? 3 : 2;
    std::vector<std::uint8_t> bytes = {18,
                                       1,
                                       0,
                                       2,
                                       0,
                                       0,
                                       0,
                                       64,
                                       low(options_.vendor),
                                       high(options_.vendor),
                                       low(options_.product),
                                       high(options_.product),
                                       0,
                                       1,
                                       0,
                                       0,
                                       0,
                                       1};
    const std::vector<std::uint8_t> hid = {9, 0x21, 0x11, 1, 0, 1, 0x22, 24, 0};
    const int total = 9 + 9 + 7 + 7 + (options_.hid ? 9 : 0);
    bytes.insert(bytes.end(), {9, 2, low(total), high(total), 1, 1, 0, 0x80, 50});
    bytes.insert(bytes.end(), {9, 4, 0, 0, 2, static_cast<std::uint8_t>(options_.hid ? 3 : 0xff), 0, 0, 0});
    if (options_.hid) bytes.insert(bytes.end(), hid.begin(), hid.end());
    bytes.insert(bytes.end(), {7, 5, kOut, type, 64, 0, 1});
    bytes.insert(bytes.end(), {7, 5, kIn, type, 64, 0, 1});
    return bytes;
  }
  void Advance(double dt_s) override { time_s += dt_s; }
  /// Request 1 sets a word; request 2 reads it back.
  Transfer Control(std::uint8_t request_type, std::uint8_t request, std::uint16_t value, std::uint16_t /*index*/,
                   std::span<std::uint8_t> data) override {
    if (request_type == 0x40 && request == 1) {
      word = value;
      return {TransferEnd::kOk, 0};
    }
    if (request_type == 0xc0 && request == 2 && data.size() >= 2) {
      data[0] = static_cast<std::uint8_t>(word & 0xff);
      data[1] = static_cast<std::uint8_t>(word >> 8);
      return {TransferEnd::kOk, 2};
    }
    return {TransferEnd::kStall, 0};
  }
  Transfer Write(std::uint8_t endpoint, std::span<const std::uint8_t> data) override {
    if (endpoint != kOut || refuses) return {TransferEnd::kStall, 0};
    packets_.emplace_back(data.begin(), data.end());
    return {TransferEnd::kOk, static_cast<int>(data.size())};
  }
  Transfer Read(std::uint8_t endpoint, std::span<std::uint8_t> data) override {
    if (endpoint != kIn) return {TransferEnd::kStall, 0};
    if (packets_.empty()) return {TransferEnd::kTimeout, 0};
    const std::size_t count = std::min(data.size(), packets_.front().size());
    std::copy_n(packets_.front().begin(), count, data.begin());
    packets_.pop_front();
    return {TransferEnd::kOk, static_cast<int>(count)};
  }
  void PowerOn() override {
    packets_.clear();
    word = 0;
  }

  static constexpr std::uint8_t kOut = 0x02;
  static constexpr std::uint8_t kIn = 0x81;
  std::uint16_t word = 0;
  bool refuses = false;  // refuses all writes
  double time_s = 0;

 private:
  EchoModelOptions options_;
  std::deque<std::vector<std::uint8_t>> packets_;
};

}  // namespace kerf::test
