#include "device/emulation/spacemouse_model.h"

#include <algorithm>

namespace kerf {
namespace {

constexpr double kMouseInterval_s = 0.008;
constexpr std::size_t kMaxWaiting = 16;
constexpr std::uint8_t kButtons = 3;  // report id

HidFace MakeFace(std::uint16_t vendor, std::uint16_t product, bool six_axes) {
  HidFace face;
  face.vendor = vendor;
  face.product = product;
  face.in_packet = 16;
  face.out_packet = 0;
  face.interval_ms = 8;
  const std::uint8_t axes = six_axes ? 6 : 3;
  // Multi-axis controller: reports 1 and 2 with 16-bit axes, report 3 with 32 buttons, and output report 4 for the
  // lamp.
  face.report_descriptor = {0x05, 0x01, 0x09, 0x08, 0xa1, 0x01, 0x85, 1,    0x16, 0xa2,
                            0xfe, 0x26, 0x5e, 0x01, 0x75, 16,   0x95, axes, 0x81, 0x06};
  const auto add = [&face](std::initializer_list<std::uint8_t> bytes) {
    for (const std::uint8_t byte : bytes) face.report_descriptor.push_back(byte);
  };
  if (!six_axes) add({0x85, 2, 0x81, 0x06});
  add({0x85, kButtons, 0x15, 0x00, 0x25, 0x01, 0x75, 1, 0x95, 32, 0x81, 0x02});
  add({0x85, 4, 0x75, 8, 0x95, 1, 0x91, 0x02, 0xc0});
  return face;
}

}  // namespace

SpaceMouseEmulation::SpaceMouseEmulation(std::uint16_t vendor, std::uint16_t product, bool six_axes)
    : face_(MakeFace(vendor, product, six_axes)), six_axes_(six_axes) {}

void SpaceMouseEmulation::PowerOn() {
  lamp_ = false;
  reported_axes_ = {};
  reported_buttons_ = 0;
  since_report_s_ = 0;
  reports_.clear();
}

void SpaceMouseEmulation::QueueAxes(std::uint8_t id, std::size_t first, std::size_t count) {
  std::vector<std::uint8_t> report = {id};
  for (std::size_t i = first; i < first + count; ++i) {
    const auto word = static_cast<std::uint16_t>(static_cast<std::int16_t>(axes_[i]));
    report.push_back(static_cast<std::uint8_t>(word & 0xff));
    report.push_back(static_cast<std::uint8_t>(word >> 8));
  }
  reports_.push_back(std::move(report));
}

void SpaceMouseEmulation::Advance(double dt_s) {
  since_report_s_ += dt_s;
  if (since_report_s_ < kMouseInterval_s) return;
  since_report_s_ = 0;
  if (reported_buttons_ != buttons_) {
    reported_buttons_ = buttons_;
    std::vector<std::uint8_t> report = {kButtons};
    for (int i = 0; i < 4; ++i) report.push_back(static_cast<std::uint8_t>(buttons_ >> (8 * i) & 0xff));
    reports_.push_back(std::move(report));
  }
  constexpr std::array<int, 6> kMiddle{};
  if (axes_ != kMiddle || reported_axes_ != kMiddle) {
    reported_axes_ = axes_;
    if (six_axes_) {
      QueueAxes(1, 0, 6);
    } else {
      QueueAxes(1, 0, 3);
      QueueAxes(2, 3, 3);
    }
  }
  // Reports of axes are repeated while the cap is deflected, and again after it has returned, so the oldest of them
  // may be dropped. A button change is reported only once.
  while (reports_.size() > kMaxWaiting) {
    const auto oldest = std::find_if(reports_.begin(), reports_.end(),
                                     [](const std::vector<std::uint8_t>& report) { return report[0] != kButtons; });
    reports_.erase(oldest != reports_.end() ? oldest : reports_.begin());
  }
}

Transfer SpaceMouseEmulation::Control(std::uint8_t request_type, std::uint8_t request, std::uint16_t value,
                                      std::uint16_t /*index*/, std::span<std::uint8_t> data) {
  constexpr std::uint8_t kToInterface = 0x21, kSetReport = 9;
  if (request_type == kToInterface && request == kSetReport) {
    if (value != 0x0204 || data.size() != 2 || data[0] != 4) return {TransferEnd::kStall, 0};
    lamp_ = data[1] != 0;
    return {TransferEnd::kOk, 2};
  }
  return AnswerHidRequest(face_, request_type, request, value, data);
}

Transfer SpaceMouseEmulation::Write(std::uint8_t /*endpoint*/, std::span<const std::uint8_t> /*data*/) {
  return {TransferEnd::kStall, 0};
}

Transfer SpaceMouseEmulation::Read(std::uint8_t endpoint, std::span<std::uint8_t> data) {
  if (endpoint != 0x81) return {TransferEnd::kStall, 0};
  if (reports_.empty()) return {TransferEnd::kTimeout, 0};
  const std::vector<std::uint8_t> report = std::move(reports_.front());
  reports_.pop_front();
  const std::size_t count = std::min(report.size(), data.size());
  std::copy_n(report.begin(), count, data.begin());
  return {TransferEnd::kOk, static_cast<int>(count)};
}

}  // namespace kerf
