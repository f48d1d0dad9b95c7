#include "device/drivers/libusb_bus.h"

#include <fmt/format.h>
#include <libusb.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <filesystem>
#include <memory>
#include <utility>

#include "kerf/error.h"

namespace kerf {
namespace {

constexpr std::size_t kMaxBytes = 4096;  // maximum size of a transfer
// Time for the kernel to return a transfer, in addition to the transfer's own timeout.
constexpr std::chrono::milliseconds kGrace{1000};

struct ContextEnd {
  void operator()(libusb_context* context) const { libusb_exit(context); }
};
using Context = std::unique_ptr<libusb_context, ContextEnd>;

struct DeviceEnd {
  void operator()(libusb_device* device) const { libusb_unref_device(device); }
};
using DeviceRef = std::unique_ptr<libusb_device, DeviceEnd>;

struct HandleEnd {
  void operator()(libusb_device_handle* handle) const { libusb_close(handle); }
};
using Handle = std::unique_ptr<libusb_device_handle, HandleEnd>;

struct ConfigurationEnd {
  void operator()(libusb_config_descriptor* configuration) const { libusb_free_config_descriptor(configuration); }
};
using Configuration = std::unique_ptr<libusb_config_descriptor, ConfigurationEnd>;

Context MakeContext() {
  libusb_context* context = nullptr;
  if (const int end = libusb_init(&context); end != LIBUSB_SUCCESS) {
    throw Error(
        fmt::format("the list of USB devices can't be read: {}", libusb_strerror(static_cast<libusb_error>(end))));
  }
  return Context(context);
}

std::vector<DeviceRef> ListDevices(libusb_context* context) {
  libusb_device** list = nullptr;
  const ssize_t count = libusb_get_device_list(context, &list);
  std::vector<DeviceRef> devices;
  for (ssize_t i = 0; i < count; ++i) devices.emplace_back(libusb_ref_device(list[i]));
  if (count >= 0) libusb_free_device_list(list, 1);
  return devices;
}

Configuration ReadConfiguration(libusb_device* device) {
  libusb_config_descriptor* configuration = nullptr;
  if (libusb_get_active_config_descriptor(device, &configuration) != LIBUSB_SUCCESS) {
    // A device that is not configured yet still has a first configuration.
    if (libusb_get_config_descriptor(device, 0, &configuration) != LIBUSB_SUCCESS) return nullptr;
  }
  return Configuration(configuration);
}

bool HasHidInterface(const libusb_config_descriptor* configuration) {
  if (configuration == nullptr) return false;
  for (int i = 0; i < configuration->bNumInterfaces; ++i) {
    const libusb_interface& which = configuration->interface[i];
    for (int j = 0; j < which.num_altsetting; ++j) {
      if (which.altsetting[j].bInterfaceClass == LIBUSB_CLASS_HID) return true;
    }
  }
  return false;
}

UsbDeviceInfo Describe(libusb_device* device) {
  UsbDeviceInfo info;
  libusb_device_descriptor descriptor;
  if (libusb_get_device_descriptor(device, &descriptor) == LIBUSB_SUCCESS) {
    info.vendor = descriptor.idVendor;
    info.product = descriptor.idProduct;
  }
  info.bus = libusb_get_bus_number(device);
  info.address = libusb_get_device_address(device);
  constexpr int kMaxPorts = 7;
  std::array<std::uint8_t, kMaxPorts> ports{};
  const int count = libusb_get_port_numbers(device, ports.data(), kMaxPorts);
  for (int i = 0; i < count; ++i)
    info.ports += fmt::format("{}{}", i == 0 ? fmt::format("{}-", info.bus) : ".", ports[i]);
  info.is_hid = HasHidInterface(ReadConfiguration(device).get());
  return info;
}

/// Returns the name of the kernel driver that uses the interface; "" if there is none.
std::string FindKernelDriver(const UsbDeviceInfo& device, const libusb_config_descriptor* configuration,
                             int interface_number) {
  if (configuration == nullptr || device.ports.empty()) return "";
  std::error_code error;
  const std::filesystem::path link =
      std::filesystem::read_symlink(fmt::format("/sys/bus/usb/devices/{}:{}.{}/driver", device.ports,
                                                configuration->bConfigurationValue, interface_number),
                                    error);
  return error ? "" : link.filename().string();
}

TransferEnd EndOf(libusb_transfer_status status) {
  switch (status) {
    case LIBUSB_TRANSFER_COMPLETED:
      return TransferEnd::kOk;
    case LIBUSB_TRANSFER_TIMED_OUT:
      return TransferEnd::kTimeout;
    case LIBUSB_TRANSFER_NO_DEVICE:
      return TransferEnd::kGone;
    case LIBUSB_TRANSFER_STALL:
      return TransferEnd::kStall;
    case LIBUSB_TRANSFER_ERROR:
    case LIBUSB_TRANSFER_CANCELLED:
    case LIBUSB_TRANSFER_OVERFLOW:
      break;
  }
  return TransferEnd::kFailed;
}

/// Transport with one reusable transfer. Every call waits until the transfer has completed.
class LibusbTransport final : public UsbTransport {
 public:
  LibusbTransport(Context context, Handle handle, int interface_number, const libusb_config_descriptor* configuration)
      : context_(std::move(context)), handle_(std::move(handle)), interface_(interface_number) {
    transfer_ = libusb_alloc_transfer(0);
    if (transfer_ == nullptr) throw Error("there is no memory left for a USB transfer");
    interrupt_.fill(false);
    if (configuration == nullptr) return;
    for (int i = 0; i < configuration->bNumInterfaces; ++i) {
      const libusb_interface& which = configuration->interface[i];
      for (int j = 0; j < which.num_altsetting; ++j) {
        const libusb_interface_descriptor& setting = which.altsetting[j];
        for (int k = 0; k < setting.bNumEndpoints; ++k) {
          const libusb_endpoint_descriptor& endpoint = setting.endpoint[k];
          constexpr int kTypeBits = 3;
          interrupt_[endpoint.bEndpointAddress] =
              (endpoint.bmAttributes & kTypeBits) == LIBUSB_ENDPOINT_TRANSFER_TYPE_INTERRUPT;
        }
      }
    }
  }

  ~LibusbTransport() override {
    if (!lost_) libusb_free_transfer(transfer_);
    // The kernel may still use a lost transfer, so its resources are leaked: closing them would block.
    if (lost_) {
      static_cast<void>(handle_.release());
      static_cast<void>(context_.release());
      static_cast<void>(buffer_.release());
      return;
    }
    libusb_release_interface(handle_.get(), interface_);
  }

  Transfer Control(std::uint8_t request_type, std::uint8_t request, std::uint16_t value, std::uint16_t index,
                   std::span<std::uint8_t> data, int timeout_ms) noexcept override {
    if (lost_ || data.size() > kMaxBytes) return {};
    std::uint8_t* bytes = buffer_->data();
    libusb_fill_control_setup(bytes, request_type, request, value, index, static_cast<std::uint16_t>(data.size()));
    const bool in = (request_type & LIBUSB_ENDPOINT_IN) != 0;
    if (!in) std::copy(data.begin(), data.end(), bytes + LIBUSB_CONTROL_SETUP_SIZE);
    libusb_fill_control_transfer(transfer_, handle_.get(), bytes, MarkDone, this, Patience(timeout_ms));
    const Transfer end = Send();
    if (in) std::copy_n(bytes + LIBUSB_CONTROL_SETUP_SIZE, std::min<std::size_t>(end.bytes, data.size()), data.begin());
    return end;
  }

  Transfer Write(std::uint8_t endpoint, std::span<const std::uint8_t> data, int timeout_ms) noexcept override {
    if (lost_ || data.size() > kMaxBytes) return {};
    std::copy(data.begin(), data.end(), buffer_->begin());
    return Move(endpoint & ~LIBUSB_ENDPOINT_IN, data.size(), timeout_ms);
  }

  Transfer Read(std::uint8_t endpoint, std::span<std::uint8_t> data, int timeout_ms) noexcept override {
    if (lost_) return {};
    const Transfer end = Move(endpoint | LIBUSB_ENDPOINT_IN, std::min(data.size(), kMaxBytes), timeout_ms);
    std::copy_n(buffer_->begin(), std::min<std::size_t>(end.bytes, data.size()), data.begin());
    return end;
  }

 private:
  static void LIBUSB_CALL MarkDone(libusb_transfer* transfer) {
    static_cast<LibusbTransport*>(transfer->user_data)->done_ = 1;
  }

  /// Returns the timeout for libusb, which treats 0 as no timeout.
  static unsigned Patience(int timeout_ms) { return static_cast<unsigned>(std::max(timeout_ms, 1)); }

  Transfer Move(int endpoint, std::size_t bytes, int timeout_ms) noexcept {
    const auto address = static_cast<unsigned char>(endpoint);
    const auto fill = interrupt_[address] ? libusb_fill_interrupt_transfer : libusb_fill_bulk_transfer;
    fill(transfer_, handle_.get(), address, buffer_->data(), static_cast<int>(bytes), MarkDone, this,
         Patience(timeout_ms));
    const Transfer end = Send();
    // Without this, the endpoint would refuse all further transfers.
    if (end.end == TransferEnd::kStall) libusb_clear_halt(handle_.get(), address);
    return end;
  }

  Transfer Send() noexcept {
    done_ = 0;
    transfer_->actual_length = 0;
    if (const int end = libusb_submit_transfer(transfer_); end != LIBUSB_SUCCESS) {
      return {end == LIBUSB_ERROR_NO_DEVICE ? TransferEnd::kGone : TransferEnd::kFailed, 0};
    }
    if (!Wait(std::chrono::milliseconds(transfer_->timeout) + kGrace)) {
      libusb_cancel_transfer(transfer_);
      if (!Wait(kGrace)) {
        lost_ = true;
        return {TransferEnd::kGone, 0};
      }
    }
    return {EndOf(transfer_->status), transfer_->actual_length};
  }

  /// Waits until the transfer has completed. Returns false after `longest` or on an error.
  bool Wait(std::chrono::milliseconds longest) noexcept {
    const auto begin = std::chrono::steady_clock::now();
    while (done_ == 0) {
      timeval turn{0, 100'000};
      const int end = libusb_handle_events_timeout_completed(context_.get(), &turn, &done_);
      if (done_ == 0 && (std::chrono::steady_clock::now() - begin > longest ||
                         (end != LIBUSB_SUCCESS && end != LIBUSB_ERROR_INTERRUPTED && end != LIBUSB_ERROR_TIMEOUT))) {
        return false;
      }
    }
    return true;
  }

  using Buffer = std::array<std::uint8_t, LIBUSB_CONTROL_SETUP_SIZE + kMaxBytes>;

  Context context_;
  Handle handle_;
  int interface_;
  std::array<bool, 256> interrupt_;  // by endpoint address: true for interrupt, false for bulk
  std::unique_ptr<Buffer> buffer_ = std::make_unique<Buffer>();
  libusb_transfer* transfer_ = nullptr;
  int done_ = 0;
  bool lost_ = false;  // the kernel has not returned the transfer
};

UsbProblem ProblemOf(int error) {
  switch (error) {
    case LIBUSB_ERROR_ACCESS:
      return UsbProblem::kNoPermission;
    case LIBUSB_ERROR_BUSY:
      return UsbProblem::kBusy;
    case LIBUSB_ERROR_NO_DEVICE:
      return UsbProblem::kGone;
    default:
      return UsbProblem::kOther;
  }
}

}  // namespace

std::vector<UsbDeviceInfo> LibusbBus::List() {
  const Context context = MakeContext();
  std::vector<UsbDeviceInfo> devices;
  for (const DeviceRef& device : ListDevices(context.get())) devices.push_back(Describe(device.get()));
  std::sort(devices.begin(), devices.end(), [](const UsbDeviceInfo& a, const UsbDeviceInfo& b) {
    return std::pair(a.bus, a.address) < std::pair(b.bus, b.address);
  });
  return devices;
}

UsbOpening LibusbBus::Open(const UsbDeviceInfo& device, int interface_number) {
  Context context = MakeContext();
  DeviceRef found;
  for (DeviceRef& candidate : ListDevices(context.get())) {
    if (libusb_get_bus_number(candidate.get()) == device.bus &&
        libusb_get_device_address(candidate.get()) == device.address) {
      found = std::move(candidate);
    }
  }
  if (!found) return {nullptr, UsbProblem::kGone, "it is no longer plugged in"};
  libusb_device_handle* opened = nullptr;
  if (const int end = libusb_open(found.get(), &opened); end != LIBUSB_SUCCESS) {
    if (end == LIBUSB_ERROR_ACCESS) {
      return {nullptr, UsbProblem::kNoPermission,
              fmt::format("there is no permission to write to {}", DeviceNode(device))};
    }
    return {nullptr, ProblemOf(end), libusb_strerror(static_cast<libusb_error>(end))};
  }
  Handle handle(opened);
  const Configuration configuration = ReadConfiguration(found.get());
  const std::string driver = FindKernelDriver(device, configuration.get(), interface_number);
  // Other kernel drivers keep the interface, since their use of the device is unknown.
  const bool take = driver == "usbhid" || driver == "ftdi_sio" || (driver.empty() && device.is_hid);
  if (take) libusb_set_auto_detach_kernel_driver(handle.get(), 1);
  if (const int end = libusb_claim_interface(handle.get(), interface_number); end != LIBUSB_SUCCESS) {
    if (end != LIBUSB_ERROR_BUSY) return {nullptr, ProblemOf(end), libusb_strerror(static_cast<libusb_error>(end))};
    return {nullptr, UsbProblem::kBusy,
            driver.empty() || driver == "usbfs" ? "another program uses it"
                                                : fmt::format("the kernel driver {} uses it", driver)};
  }
  return {
      std::make_unique<LibusbTransport>(std::move(context), std::move(handle), interface_number, configuration.get()),
      UsbProblem::kNone, ""};
}

}  // namespace kerf
