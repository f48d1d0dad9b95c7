#include "device/emulation/wooden_model.h"

#include <algorithm>

namespace kerf {
namespace {

constexpr double kWatchdog_s = 0.5;
constexpr double kWoodenInterval_s = 0.001;
constexpr double kFirmwareLimit_mA = 3000;

HidFace MakeFace() {
  HidFace face;
  face.vendor = kWoodenVendor;
  face.product = kWoodenProduct;
  face.release = 1;
  // Vendor-defined page; 8 bytes in, 8 bytes out.
  face.report_descriptor = {0x06, 0xab, 0xff, 0x0a, 0x00, 0x02, 0xa1, 0x01, 0x75, 0x08, 0x15, 0x00, 0x26, 0xff,
                            0x00, 0x95, 0x08, 0x09, 0x01, 0x81, 0x02, 0x95, 0x08, 0x09, 0x02, 0x91, 0x02, 0xc0};
  return face;
}

}  // namespace

WoodenModel::WoodenModel(Mechanism& mechanism, const WoodenParams& params)
    : mechanism_(mechanism), params_(params), face_(MakeFace()) {
  angles_ = FindWoodenAngles(params_, Vec3{0}).value_or(Vec3{0});
  WoodenModel::PowerOn();
}

void WoodenModel::PowerOn() {
  currents_mA_ = Vec3{0};
  motors_on_ = false;
  since_packet_s_ = 0;
  since_report_s_ = kWoodenInterval_s;
  report_ = {};
  has_report_ = false;
}

void WoodenModel::Advance(double dt_s) {
  since_packet_s_ += dt_s;
  if (since_packet_s_ > kWatchdog_s) {
    currents_mA_ = Vec3{0};
    motors_on_ = false;
  }
  mechanism_.Move(dt_s, CalcWoodenForce(params_, angles_, currents_mA_), Vec3{0});
  angles_ = FindWoodenAngles(params_, mechanism_.handle().p_AB).value_or(angles_);
  since_report_s_ += dt_s;
  if (since_report_s_ < kWoodenInterval_s) return;
  since_report_s_ = std::min(since_report_s_ - kWoodenInterval_s, kWoodenInterval_s);
  report_.counts = CalcWoodenCounts(params_, angles_);
  ++report_.counter;
  has_report_ = true;
}

Transfer WoodenModel::Control(std::uint8_t request_type, std::uint8_t request, std::uint16_t value,
                              std::uint16_t /*index*/, std::span<std::uint8_t> data) {
  return AnswerHidRequest(face_, request_type, request, value, data);
}

Transfer WoodenModel::Write(std::uint8_t endpoint, std::span<const std::uint8_t> data) {
  if (endpoint != kWoodenOut) return {TransferEnd::kStall, 0};
  if (data.size() == kWoodenReportBytes) {
    const Vec3 wanted_mA = ReadWoodenCurrents(data.first<kWoodenReportBytes>());
    for (int i = 0; i < 3; ++i) currents_mA_[i] = std::clamp(wanted_mA[i], -kFirmwareLimit_mA, kFirmwareLimit_mA);
    motors_on_ = true;
    since_packet_s_ = 0;
    ++packets_;
  }
  return {TransferEnd::kOk, static_cast<int>(data.size())};
}

Transfer WoodenModel::Read(std::uint8_t endpoint, std::span<std::uint8_t> data) {
  if (endpoint != kWoodenIn) return {TransferEnd::kStall, 0};
  if (!has_report_ || data.size() < kWoodenReportBytes) return {TransferEnd::kTimeout, 0};
  has_report_ = false;
  WriteWoodenReport(report_, data.first<kWoodenReportBytes>());
  return {TransferEnd::kOk, static_cast<int>(kWoodenReportBytes)};
}

}  // namespace kerf
