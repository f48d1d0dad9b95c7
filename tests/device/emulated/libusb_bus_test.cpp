// Tests the real libusb with emulated devices.
#include "device/drivers/libusb_bus.h"

#include <gtest/gtest.h>

#include <array>
#include <atomic>
#include <chrono>
#include <deque>
#include <stdexcept>
#include <thread>

#include "device/emulated/echo_model.h"
#include "device/emulated/emulated_kernel.h"

namespace kerf {
namespace {

using test::EchoModel;
using test::EmulatedKernel;

// Waits are short unless the machine stalls; speed is not tested.
constexpr int kTimeout_ms = 20'000;

class LibusbBusTest : public testing::Test {
 protected:
  UsbDeviceInfo Only() {
    const std::vector<UsbDeviceInfo> devices = bus_.List();
    if (devices.size() != 1) throw std::runtime_error("expected exactly one device");
    return devices[0];
  }

  EchoModel& Make(const test::EchoModelOptions& options = {}) { return models_.emplace_back(options); }

  std::deque<EchoModel> models_;
  EmulatedKernel kernel_;
  LibusbBus bus_;
};

TEST_F(LibusbBusTest, ListsWhatIsPluggedIn) {
  EXPECT_TRUE(bus_.List().empty());
  EchoModel& plain = Make();
  EchoModel& hid = Make({.vendor = 0x1234, .product = 6, .hid = true});
  kernel_.PlugIn(plain);
  kernel_.PlugIn(hid);
  const std::vector<UsbDeviceInfo> devices = bus_.List();
  ASSERT_EQ(devices.size(), 2U);
  EXPECT_EQ(devices[0].vendor, 0x1209);
  EXPECT_EQ(devices[0].product, 1);
  EXPECT_EQ(devices[0].bus, 1);
  EXPECT_EQ(devices[0].address, 4);
  EXPECT_EQ(devices[0].ports, "1-1");
  EXPECT_FALSE(devices[0].is_hid);
  EXPECT_EQ(DeviceNode(devices[0]), "/dev/bus/usb/001/004");
  EXPECT_EQ(devices[1].vendor, 0x1234);
  EXPECT_EQ(devices[1].product, 6);
  EXPECT_EQ(devices[1].ports, "1-2");
  EXPECT_TRUE(devices[1].is_hid);
}

TEST_F(LibusbBusTest, CarriesBytesBothWaysByBulkAndByInterrupt) {
  for (const bool hid : {false, true}) {
    EchoModel model({.hid = hid});
    EmulatedKernel kernel;
    kernel.PlugIn(model);
    UsbOpening opening = bus_.Open(Only(), 0);
    ASSERT_TRUE(opening.transport) << opening.detail;
    for (int i = 0; i < 100; ++i) {
      std::array<std::uint8_t, 64> sent{};
      for (std::size_t j = 0; j < sent.size(); ++j) sent[j] = static_cast<std::uint8_t>(7 * i + 3 * j);
      const Transfer out = opening.transport->Write(EchoModel::kOut, sent, kTimeout_ms);
      ASSERT_EQ(out.end, TransferEnd::kOk);
      ASSERT_EQ(out.bytes, 64);
      std::array<std::uint8_t, 64> got{};
      const Transfer in = opening.transport->Read(EchoModel::kIn, got, kTimeout_ms);
      ASSERT_EQ(in.end, TransferEnd::kOk);
      ASSERT_EQ(in.bytes, 64);
      ASSERT_EQ(got, sent);
    }
    EXPECT_EQ(kernel.unknown_calls(), 0);
  }
}

TEST_F(LibusbBusTest, TransfersControlRequestsAndReportsUnsupportedOnes) {
  EchoModel& model = Make();
  kernel_.PlugIn(model);
  UsbOpening opening = bus_.Open(Only(), 0);
  ASSERT_TRUE(opening.transport) << opening.detail;
  EXPECT_EQ(opening.transport->Control(0x40, 1, 0xbeef, 0, {}, kTimeout_ms).end, TransferEnd::kOk);
  kernel_.Look([&] { EXPECT_EQ(model.word, 0xbeef); });
  std::array<std::uint8_t, 2> data{};
  const Transfer in = opening.transport->Control(0xc0, 2, 0, 0, data, kTimeout_ms);
  EXPECT_EQ(in.end, TransferEnd::kOk);
  EXPECT_EQ(in.bytes, 2);
  EXPECT_EQ(data[0] | data[1] << 8, 0xbeef);
  EXPECT_EQ(opening.transport->Control(0x40, 99, 0, 0, {}, kTimeout_ms).end, TransferEnd::kStall);
  // The device continues to work.
  EXPECT_EQ(opening.transport->Control(0x40, 1, 1, 0, {}, kTimeout_ms).end, TransferEnd::kOk);
}

TEST_F(LibusbBusTest, RefusedTransferDoesNotBlockTheNextAndTooLongOnesFail) {
  EchoModel& model = Make();
  kernel_.PlugIn(model);
  UsbOpening opening = bus_.Open(Only(), 0);
  ASSERT_TRUE(opening.transport) << opening.detail;
  std::array<std::uint8_t, 5000> bytes{};
  const auto packet = std::span(bytes).first(64);
  kernel_.Look([&] { model.refuses = true; });
  EXPECT_EQ(opening.transport->Write(EchoModel::kOut, packet, kTimeout_ms).end, TransferEnd::kStall);
  kernel_.Look([&] { model.refuses = false; });
  EXPECT_EQ(opening.transport->Write(EchoModel::kOut, packet, kTimeout_ms).end, TransferEnd::kOk);
  EXPECT_EQ(opening.transport->Write(EchoModel::kOut, bytes, kTimeout_ms).end, TransferEnd::kFailed);
  // Writing to an endpoint that does not exist fails too.
  EXPECT_EQ(opening.transport->Write(0x05, packet, kTimeout_ms).end, TransferEnd::kFailed);
  const Transfer in = opening.transport->Read(EchoModel::kIn, packet, kTimeout_ms);
  EXPECT_EQ(in.end, TransferEnd::kOk);
  EXPECT_EQ(in.bytes, 64);
}

TEST_F(LibusbBusTest, SilenceIsATimeoutAndTheDeviceGoesOn) {
  EchoModel& model = Make();
  kernel_.PlugIn(model);
  UsbOpening opening = bus_.Open(Only(), 0);
  ASSERT_TRUE(opening.transport) << opening.detail;
  std::array<std::uint8_t, 64> bytes{1, 2, 3};
  EXPECT_EQ(opening.transport->Read(EchoModel::kIn, bytes, 100).end, TransferEnd::kTimeout);
  EXPECT_EQ(bytes[0], 1);
  EXPECT_EQ(opening.transport->Write(EchoModel::kOut, bytes, kTimeout_ms).end, TransferEnd::kOk);
  EXPECT_EQ(opening.transport->Read(EchoModel::kIn, bytes, kTimeout_ms).end, TransferEnd::kOk);
}

TEST_F(LibusbBusTest, UnpluggedDeviceIsGoneAndIsFoundWhenPluggedInAgain) {
  EchoModel& model = Make();
  const int socket = kernel_.PlugIn(model);
  UsbOpening opening = bus_.Open(Only(), 0);
  ASSERT_TRUE(opening.transport) << opening.detail;
  std::array<std::uint8_t, 64> bytes{};
  // The device is unplugged while a read waits.
  std::thread puller([&] {
    std::this_thread::sleep_for(std::chrono::milliseconds(50));
    kernel_.Unplug(socket);
  });
  EXPECT_EQ(opening.transport->Read(EchoModel::kIn, bytes, kTimeout_ms).end, TransferEnd::kGone);
  puller.join();
  EXPECT_EQ(opening.transport->Write(EchoModel::kOut, bytes, kTimeout_ms).end, TransferEnd::kGone);
  EXPECT_EQ(opening.transport->Control(0x40, 1, 1, 0, {}, kTimeout_ms).end, TransferEnd::kGone);
  EXPECT_TRUE(bus_.List().empty());
  kernel_.PlugInAgain(socket);
  const UsbDeviceInfo again = Only();
  EXPECT_EQ(again.address, 5);
  EXPECT_EQ(again.ports, "1-1");
  EXPECT_EQ(opening.transport->Write(EchoModel::kOut, bytes, kTimeout_ms).end, TransferEnd::kGone);
  UsbOpening restarted = bus_.Open(again, 0);
  ASSERT_TRUE(restarted.transport) << restarted.detail;
  EXPECT_EQ(restarted.transport->Write(EchoModel::kOut, bytes, kTimeout_ms).end, TransferEnd::kOk);
  EXPECT_EQ(restarted.transport->Read(EchoModel::kIn, bytes, kTimeout_ms).end, TransferEnd::kOk);
}

TEST_F(LibusbBusTest, ListenerThatClosesDuringPlugInIsHarmless) {
#ifdef __SANITIZE_ADDRESS__
  GTEST_SKIP() << "libusb 1.0.26 itself keeps the memory of a device that is announced as its context ends";
#endif
  EchoModel& model = Make();
  const int socket = kernel_.PlugIn(model);
  std::atomic<bool> end = false;
  std::thread listener([&] {
    while (!end) LibusbBus{}.List();
  });
  // libusb stores a USB address in one byte, and each plug-in uses a new one.
  for (int i = 0; i < 200; ++i) {
    kernel_.Unplug(socket);
    kernel_.PlugInAgain(socket);
  }
  end = true;
  listener.join();
  EXPECT_EQ(bus_.List().size(), 1U);
}

TEST_F(LibusbBusTest, ReportsWhyADeviceCannotBeOpened) {
  EchoModel& forbidden = Make();
  EchoModel& held = Make({.hid = true});
  EchoModel& serial = Make();
  EchoModel& stuck = Make({.hid = true});
  kernel_.PlugIn(forbidden, {.no_permission = true});
  kernel_.PlugIn(held, {.driver = "usbhid"});
  kernel_.PlugIn(serial, {.driver = "cdc_acm"});
  kernel_.PlugIn(stuck, {.driver = "usbhid", .driver_holds = true});
  const std::vector<UsbDeviceInfo> devices = bus_.List();
  ASSERT_EQ(devices.size(), 4U);
  {
    const test::WithoutPrivileges limit;
    const UsbOpening opening = bus_.Open(devices[0], 0);
    EXPECT_FALSE(opening.transport);
    EXPECT_EQ(opening.problem, UsbProblem::kNoPermission);
    EXPECT_EQ(opening.detail, "there is no permission to write to /dev/bus/usb/001/004");
  }
  {
    const UsbOpening opening = bus_.Open(devices[1], 0);
    EXPECT_TRUE(opening.transport) << opening.detail;
    // This handle acts like a second program.
    const UsbOpening second = bus_.Open(devices[1], 0);
    EXPECT_EQ(second.problem, UsbProblem::kBusy);
    EXPECT_EQ(second.detail, "another program uses it");
  }
  // The device has been released.
  EXPECT_TRUE(bus_.Open(devices[1], 0).transport);
  const UsbOpening serial_opening = bus_.Open(devices[2], 0);
  EXPECT_EQ(serial_opening.problem, UsbProblem::kBusy);
  EXPECT_EQ(serial_opening.detail, "the kernel driver cdc_acm uses it");
  EXPECT_EQ(bus_.Open(devices[3], 0).problem, UsbProblem::kBusy);
  UsbDeviceInfo gone = devices[0];
  gone.address = 99;
  EXPECT_EQ(bus_.Open(gone, 0).problem, UsbProblem::kGone);
}

}  // namespace
}  // namespace kerf
