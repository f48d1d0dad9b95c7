#include "device/emulation/model_bus.h"

#include <fmt/format.h>

#include <algorithm>
#include <deque>
#include <random>
#include <utility>

#include "kerf/error.h"

namespace kerf {
namespace {

constexpr std::size_t kDeviceDescriptorBytes = 18;
constexpr std::uint8_t kHidClass = 3;
constexpr std::size_t kMaxPacketBytes = 512;
constexpr double kWaitStep_s = 0.0005;

}  // namespace

UsbDeviceInfo ReadDeviceInfo(std::span<const std::uint8_t> descriptors) {
  if (descriptors.size() < kDeviceDescriptorBytes || descriptors[0] != kDeviceDescriptorBytes || descriptors[1] != 1) {
    throw Error("these bytes are not a USB device descriptor");
  }
  UsbDeviceInfo info;
  info.vendor = static_cast<std::uint16_t>(descriptors[8] | descriptors[9] << 8);
  info.product = static_cast<std::uint16_t>(descriptors[10] | descriptors[11] << 8);
  for (std::size_t at = kDeviceDescriptorBytes; at + 2 <= descriptors.size() && descriptors[at] >= 2;
       at += descriptors[at]) {
    constexpr std::uint8_t kInterface = 4;
    if (descriptors[at + 1] == kInterface && at + 6 <= descriptors.size()) {
      info.is_hid = info.is_hid || descriptors[at + 5] == kHidClass;
    }
  }
  return info;
}

struct ModelBus::Socket {
  UsbModel* model = nullptr;
  UsbDeviceInfo info;
  UsbFaults faults;
  std::mt19937_64 random{1};
  int times_plugged_in = 1;

  bool Draw(double fraction) { return fraction > 0 && std::uniform_real_distribution<double>(0, 1)(random) < fraction; }
};

/// Transport of an opened device.
class ModelBus::Connection final : public UsbTransport {
 public:
  explicit Connection(std::shared_ptr<Socket> socket)
      : socket_(std::move(socket)), plugged_in_(socket_->times_plugged_in) {}

  Transfer Control(std::uint8_t request_type, std::uint8_t request, std::uint16_t value, std::uint16_t index,
                   std::span<std::uint8_t> data, int /*timeout_ms*/) noexcept override {
    if (IsGone()) return {TransferEnd::kGone, 0};
    return socket_->model->Control(request_type, request, value, index, data);
  }

  Transfer Write(std::uint8_t endpoint, std::span<const std::uint8_t> data, int timeout_ms) noexcept override {
    if (IsGone()) return {TransferEnd::kGone, 0};
    if (const std::optional<Transfer>& ends = socket_->faults.out_ends) {
      if (ends->end == TransferEnd::kTimeout) socket_->model->Advance(1e-3 * timeout_ms);
      return *ends;
    }
    if (socket_->Draw(socket_->faults.drop_out)) return {TransferEnd::kOk, static_cast<int>(data.size())};
    return socket_->model->Write(endpoint, data);
  }

  Transfer Read(std::uint8_t endpoint, std::span<std::uint8_t> data, int timeout_ms) noexcept override {
    for (double waited_s = 0;;) {
      if (IsGone()) return {TransferEnd::kGone, 0};
      const Transfer transfer = Fetch(endpoint, data);
      if (transfer.end != TransferEnd::kTimeout || waited_s >= 1e-3 * timeout_ms) return transfer;
      socket_->model->Advance(kWaitStep_s);
      waited_s += kWaitStep_s;
    }
  }

 private:
  struct Packet {
    std::uint8_t endpoint = 0;
    std::vector<std::uint8_t> bytes;
  };

  bool IsGone() const { return socket_->faults.unplugged || plugged_in_ != socket_->times_plugged_in; }

  /// Returns one packet, with the faults of the connection.
  Transfer Fetch(std::uint8_t endpoint, std::span<std::uint8_t> data) {
    if (socket_->faults.stalled) return {TransferEnd::kTimeout, 0};
    const auto waiting = std::find_if(waiting_.begin(), waiting_.end(),
                                      [&](const Packet& packet) { return packet.endpoint == endpoint; });
    if (waiting != waiting_.end() && !late_) {
      const Transfer transfer = Give(waiting->bytes, data);
      waiting_.erase(waiting);
      return transfer;
    }
    late_ = false;
    std::vector<std::uint8_t> bytes(kMaxPacketBytes);
    const Transfer transfer = socket_->model->Read(endpoint, bytes);
    if (transfer.end != TransferEnd::kOk) return transfer;
    bytes.resize(static_cast<std::size_t>(transfer.bytes));
    const UsbFaults& faults = socket_->faults;
    if (socket_->Draw(faults.drop_in)) return {TransferEnd::kTimeout, 0};
    if (!bytes.empty() && socket_->Draw(faults.truncate)) bytes.resize(socket_->random() % bytes.size());
    if (!bytes.empty() && socket_->Draw(faults.corrupt)) {
      bytes[socket_->random() % bytes.size()] ^= static_cast<std::uint8_t>(1 + socket_->random() % 255);
    }
    if (socket_->Draw(faults.duplicate)) waiting_.push_back({endpoint, bytes});
    if (socket_->Draw(faults.delay)) {
      waiting_.push_back({endpoint, bytes});
      late_ = true;
      return {TransferEnd::kTimeout, 0};
    }
    return Give(bytes, data);
  }

  static Transfer Give(const std::vector<std::uint8_t>& bytes, std::span<std::uint8_t> data) {
    const std::size_t count = std::min(bytes.size(), data.size());
    std::copy_n(bytes.begin(), count, data.begin());
    return {TransferEnd::kOk, static_cast<int>(count)};
  }

  std::shared_ptr<Socket> socket_;
  int plugged_in_;
  std::deque<Packet> waiting_;
  bool late_ = false;
};

void ModelBus::PlugIn(UsbModel& model) {
  auto socket = std::make_shared<Socket>();
  socket->model = &model;
  socket->info = ReadDeviceInfo(model.descriptors());
  socket->info.bus = 1;
  socket->info.address = next_address_++;
  socket->info.ports = fmt::format("1-{}", sockets_.size() + 1);
  sockets_.push_back(std::move(socket));
}

void ModelBus::SetFaults(const UsbFaults& faults) {
  for (const std::shared_ptr<Socket>& socket : sockets_) {
    if (faults.seed != socket->faults.seed) socket->random.seed(faults.seed);
    socket->faults = faults;
  }
}

void ModelBus::PlugInAgain() {
  for (const std::shared_ptr<Socket>& socket : sockets_) {
    if (!socket->faults.unplugged) continue;
    socket->faults.unplugged = false;
    ++socket->times_plugged_in;
    socket->info.address = next_address_++;
    socket->model->PowerOn();
  }
}

void ModelBus::Advance(double dt_s) {
  for (const std::shared_ptr<Socket>& socket : sockets_) socket->model->Advance(dt_s);
}

std::vector<UsbDeviceInfo> ModelBus::List() {
  std::vector<UsbDeviceInfo> devices;
  for (const std::shared_ptr<Socket>& socket : sockets_) {
    if (!socket->faults.unplugged) devices.push_back(socket->info);
  }
  return devices;
}

UsbOpening ModelBus::Open(const UsbDeviceInfo& device, int /*interface_number*/) {
  if (problem_ != UsbProblem::kNone) return {nullptr, problem_, "the model was set to report this"};
  for (const std::shared_ptr<Socket>& socket : sockets_) {
    if (!socket->faults.unplugged && socket->info.address == device.address) {
      return {std::make_unique<Connection>(socket), UsbProblem::kNone, ""};
    }
  }
  return {nullptr, UsbProblem::kGone, "no device has that address"};
}

}  // namespace kerf
