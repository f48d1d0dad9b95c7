#include "device/emulated/emulated_kernel.h"

#include <dlfcn.h>
#include <fmt/format.h>
#include <linux/capability.h>
#include <linux/usbdevice_fs.h>
#include <sys/ioctl.h>
#include <sys/prctl.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <umockdev.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <chrono>
#include <cstdlib>
#include <cstring>
#include <deque>
#include <filesystem>
#include <fstream>
#include <map>

#include "kerf/error.h"

// These two functions override the system's functions only because of umockdev 0.17. umockdev ends the program if a
// listener for plug events closes just as it is notified, which sooner or later happens with libusb's contexts, or if a
// listener has not read for a long time. Neither is an error. Only umockdev's messages are sent with an address.

extern "C" int connect(int fd, const sockaddr* address, socklen_t bytes) {
  static const auto system = reinterpret_cast<int (*)(int, const sockaddr*, socklen_t)>(dlsym(RTLD_NEXT, "connect"));
  const int end = system(fd, address, bytes);
  if (end < 0 && errno == ENOENT) errno = ECONNREFUSED;  // an error that umockdev handles
  return end;
}

extern "C" ssize_t sendmsg(int fd, const msghdr* message, int flags) {
  static const auto system = reinterpret_cast<ssize_t (*)(int, const msghdr*, int)>(dlsym(RTLD_NEXT, "sendmsg"));
  const ssize_t sent = system(fd, message, flags);
  const bool is_of_umockdev = message->msg_name != nullptr;
  return sent < 0 && is_of_umockdev && (errno == ECONNREFUSED || errno == EAGAIN) ? 0 : sent;
}

namespace kerf::test {
namespace {

constexpr char kPreload[] = "libumockdev-preload.so.0";
constexpr std::int64_t kStep_ns = 500'000;
constexpr std::int64_t kMaxCaughtUp_ns = 2'000'000'000;
constexpr std::size_t kSetupBytes = 8;

std::int64_t Now_ns() {
  return std::chrono::duration_cast<std::chrono::nanoseconds>(std::chrono::steady_clock::now().time_since_epoch())
      .count();
}

/// Deleter that releases a reference to a GObject.
template <typename T>
struct Unref {
  void operator()(T* object) const { g_object_unref(object); }
};
using Data = std::unique_ptr<UMockdevIoctlData, Unref<UMockdevIoctlData>>;

/// Returns the data in the other program to which the pointer at `offset` of `data` points.
Data Resolve(UMockdevIoctlData* data, gsize offset, gsize bytes) {
  return Data(umockdev_ioctl_data_resolve(data, offset, bytes, nullptr));
}

/// Returns the description of a device in umockdev's format.
std::string DescribeUsb(const std::string& path, int address, const std::vector<std::uint8_t>& descriptors,
                        int speed_mbit) {
  std::string hex;
  for (const std::uint8_t byte : descriptors) hex += fmt::format("{:02x}", byte);
  const UsbDeviceInfo info = ReadDeviceInfo(descriptors);
  return fmt::format(
      "P: {0}\nN: bus/usb/001/{1:03}\nE: SUBSYSTEM=usb\nE: DEVTYPE=usb_device\nE: DRIVER=usb\nE: BUSNUM=001\n"
      "E: DEVNUM={1:03}\nE: DEVNAME=/dev/bus/usb/001/{1:03}\nE: MAJOR=189\nE: MINOR={2}\nE: "
      "PRODUCT={3:x}/{4:x}/100\nA: busnum=1\\n\nA: devnum={1}\\n\nA: bConfigurationValue=1\\n\nA: speed={5}\\n\n"
      "A: idVendor={3:04x}\\n\nA: idProduct={4:04x}\\n\nH: descriptors={6}\n\n",
      path, address, address - 1, info.vendor, info.product, speed_mbit, hex);
}

}  // namespace

std::string RunUnderUmockdev(char** argv) {
  const char* before = std::getenv("LD_PRELOAD");
  if (before != nullptr && std::strstr(before, kPreload) != nullptr) return "";
  std::string preload = kPreload;
  std::ifstream maps("/proc/self/maps");
  for (std::string line; std::getline(maps, line);) {
    const std::size_t path = line.find('/');
    if (path != std::string::npos && line.find("libasan.so") != std::string::npos) {
      preload = fmt::format("{}:{}", line.substr(path), preload);  // libasan must be loaded first
      break;
    }
  }
  if (before != nullptr) preload = fmt::format("{}:{}", preload, before);
  setenv("LD_PRELOAD", preload.c_str(), 1);
  execv("/proc/self/exe", argv);
  return fmt::format("this program can't be run again with {}: {}", kPreload, std::strerror(errno));
}

// A transfer that was submitted to the kernel.
struct Urb {
  Data data;
  UMockdevIoctlClient* client = nullptr;
  usbdevfs_urb* fields() const { return reinterpret_cast<usbdevfs_urb*>(data->data); }
};

struct EmulatedKernel::Socket {
  EmulatedKernel* kernel = nullptr;
  UsbModel* model = nullptr;
  EmulatedSocket options;
  std::string path;
  int address = 0;
  bool plugged_in = true;
  bool silent = false;
  bool driver_bound = false;
  std::map<int, int> endpoint_types;  // type as in usbdevfs_urb, by endpoint address
  UMockdevIoctlClient* claimed_by = nullptr;
  std::deque<Urb> waiting;
  std::deque<Urb> done;

  static gboolean HandleIoctl(UMockdevIoctlBase* /*base*/, UMockdevIoctlClient* client, gpointer user);
  static void Forget(UMockdevIoctlBase* /*base*/, UMockdevIoctlClient* client, gpointer user);
  bool Answer(UMockdevIoctlClient* client);
  void Submit(UMockdevIoctlClient* client, UMockdevIoctlData* argument);
  void Reap(UMockdevIoctlClient* client, UMockdevIoctlData* argument);
  void Discard(UMockdevIoctlClient* client, UMockdevIoctlData* argument);
  void Claim(UMockdevIoctlClient* client, bool take);
  void Bind(bool own);
  bool TryToEnd(Urb& urb);
};

struct EmulatedKernel::Umockdev {
  UMockdevTestbed* testbed = nullptr;
  // One handler for each time that a device was plugged in; the handlers live as long as the testbed.
  std::vector<UMockdevIoctlBase*> handlers;

  std::string Root() const {
    gchar* folder = umockdev_testbed_get_root_dir(testbed);
    std::string root = folder;
    g_free(folder);
    return root;
  }
};

namespace {

int ErrorOf(TransferEnd end) {
  switch (end) {
    case TransferEnd::kOk:
      return 0;
    case TransferEnd::kGone:
      return -ESHUTDOWN;
    case TransferEnd::kStall:
      return -EPIPE;
    case TransferEnd::kTimeout:
    case TransferEnd::kFailed:
      break;
  }
  return -EPROTO;
}

}  // namespace

gboolean EmulatedKernel::Socket::HandleIoctl(UMockdevIoctlBase* /*base*/, UMockdevIoctlClient* client, gpointer user) {
  auto* socket = static_cast<Socket*>(user);
  const std::lock_guard lock(socket->kernel->mutex_);
  socket->kernel->AdvanceAll();
  if (socket->Answer(client)) return TRUE;
  ++socket->kernel->unknown_calls_;
  return FALSE;
}

void EmulatedKernel::Socket::Forget(UMockdevIoctlBase* /*base*/, UMockdevIoctlClient* client, gpointer user) {
  auto* socket = static_cast<Socket*>(user);
  const std::lock_guard lock(socket->kernel->mutex_);
  for (std::deque<Urb>* urbs : {&socket->waiting, &socket->done}) {
    std::erase_if(*urbs, [&](const Urb& urb) { return urb.client == client; });
  }
  if (socket->claimed_by == client) socket->claimed_by = nullptr;
}

bool EmulatedKernel::Socket::Answer(UMockdevIoctlClient* client) {
  const gulong request = umockdev_ioctl_client_get_request(client);
  UMockdevIoctlData* argument = umockdev_ioctl_client_get_arg(client);  // owned by the client
  const auto answer = [&](int error) { umockdev_ioctl_client_complete(client, error == 0 ? 0 : -1, error); };
  switch (request) {
    case USBDEVFS_REAPURB:
    case USBDEVFS_REAPURBNDELAY:
      Reap(client, argument);
      return true;
    case USBDEVFS_DISCARDURB:
      Discard(client, argument);
      return true;
    default:
      break;
  }
  if (!plugged_in) {
    answer(ENODEV);
    return true;
  }
  switch (request) {
    case USBDEVFS_GET_CAPABILITIES: {
      const Data flags = Resolve(argument, 0, sizeof(std::uint32_t));
      const std::uint32_t all = USBDEVFS_CAP_ZERO_PACKET | USBDEVFS_CAP_BULK_CONTINUATION |
                                USBDEVFS_CAP_NO_PACKET_SIZE_LIM | USBDEVFS_CAP_REAP_AFTER_DISCONNECT;
      std::memcpy(flags->data, &all, sizeof(all));
      answer(0);
      return true;
    }
    case USBDEVFS_CLAIMINTERFACE:
      Claim(client, false);
      return true;
    case USBDEVFS_DISCONNECT_CLAIM:
      Claim(client, true);
      return true;
    case USBDEVFS_RELEASEINTERFACE:
      if (claimed_by == client) claimed_by = nullptr;
      answer(0);
      return true;
    case USBDEVFS_GETDRIVER: {
      const Data driver = Resolve(argument, 0, sizeof(usbdevfs_getdriver));
      const std::string name = driver_bound ? options.driver : claimed_by != nullptr ? "usbfs" : "";
      auto* fields = reinterpret_cast<usbdevfs_getdriver*>(driver->data);
      std::strncpy(fields->driver, name.c_str(), sizeof(fields->driver) - 1);
      answer(name.empty() ? ENODATA : 0);
      return true;
    }
    case USBDEVFS_IOCTL: {
      // A DISCONNECT or CONNECT of the kernel's driver.
      const Data call = Resolve(argument, 0, sizeof(usbdevfs_ioctl));
      const auto* fields = reinterpret_cast<const usbdevfs_ioctl*>(call->data);
      Bind(static_cast<gulong>(fields->ioctl_code) == USBDEVFS_CONNECT);
      answer(0);
      return true;
    }
    case USBDEVFS_CLEAR_HALT:
    case USBDEVFS_RESETEP:
      answer(0);
      return true;
    case USBDEVFS_SUBMITURB:
      Submit(client, argument);
      return true;
    default:
      return false;
  }
}

void EmulatedKernel::Socket::Claim(UMockdevIoctlClient* client, bool take) {
  const bool held = claimed_by != nullptr && claimed_by != client;
  if (held || (driver_bound && (!take || options.driver_holds))) {
    umockdev_ioctl_client_complete(client, -1, EBUSY);
    return;
  }
  Bind(false);
  claimed_by = client;
  umockdev_ioctl_client_complete(client, 0, 0);
}

/// Binds the kernel's own driver to interface 0, or the driver for user programs (usbfs).
void EmulatedKernel::Socket::Bind(bool own) {
  if (options.driver.empty() || own == driver_bound) return;
  driver_bound = own;
  const std::string name = path.substr(path.rfind('/') + 1);
  const std::filesystem::path link = fmt::format("{}/sys{}/{}:1.0/driver", kernel->umockdev_->Root(), path, name);
  std::error_code error;
  std::filesystem::remove(link, error);
  std::filesystem::create_symlink(fmt::format("../../../../bus/usb/drivers/{}", own ? options.driver : "usbfs"), link,
                                  error);
}

/// Returns true if the transfer has ended.
bool EmulatedKernel::Socket::TryToEnd(Urb& urb) {
  usbdevfs_urb* fields = urb.fields();
  const Data buffer =
      Resolve(urb.data.get(), offsetof(usbdevfs_urb, buffer), static_cast<gsize>(fields->buffer_length));
  const std::span<std::uint8_t> bytes(buffer->data, static_cast<std::size_t>(fields->buffer_length));
  Transfer transfer;
  if (fields->type == USBDEVFS_URB_TYPE_CONTROL) {
    if (bytes.size() < kSetupBytes) return false;
    const auto word = [&](int at) { return static_cast<std::uint16_t>(bytes[at] | bytes[at + 1] << 8); };
    transfer = model->Control(bytes[0], bytes[1], word(2), word(4), bytes.subspan(kSetupBytes));
  } else if ((fields->endpoint & 0x80) == 0) {
    transfer = model->Write(fields->endpoint, bytes);
  } else {
    if (silent) return false;
    transfer = model->Read(fields->endpoint, bytes);
  }
  if (transfer.end == TransferEnd::kTimeout) return false;
  fields->status = ErrorOf(transfer.end);
  fields->actual_length = transfer.bytes;
  return true;
}

void EmulatedKernel::Socket::Submit(UMockdevIoctlClient* client, UMockdevIoctlData* argument) {
  Urb urb{Resolve(argument, 0, sizeof(usbdevfs_urb)), client};
  const auto type = endpoint_types.find(urb.fields()->endpoint);
  const bool control = urb.fields()->type == USBDEVFS_URB_TYPE_CONTROL;
  // Linux accepts libusb's bulk transfers on interrupt endpoints; here the type must match the endpoint.
  if (!control && (claimed_by != client || type == endpoint_types.end() || type->second != urb.fields()->type)) {
    umockdev_ioctl_client_complete(client, -1, EINVAL);
    return;
  }
  const bool ended = TryToEnd(urb);
  (ended ? done : waiting).push_back(std::move(urb));
  umockdev_ioctl_client_complete(client, 0, 0);
}

void EmulatedKernel::Socket::Reap(UMockdevIoctlClient* client, UMockdevIoctlData* argument) {
  for (std::size_t i = 0; i < waiting.size(); ++i) {
    // The device was unplugged: no data will come.
    if (!plugged_in) {
      waiting[i].fields()->status = -ESHUTDOWN;
    } else if (!TryToEnd(waiting[i])) {
      continue;
    }
    done.push_back(std::move(waiting[i]));
    waiting.erase(waiting.begin() + static_cast<std::ptrdiff_t>(i--));
  }
  const auto mine = std::find_if(done.begin(), done.end(), [&](const Urb& urb) { return urb.client == client; });
  if (mine == done.end()) {
    umockdev_ioctl_client_complete(client, -1, plugged_in ? EAGAIN : ENODEV);
    return;
  }
  const Data pointer = Resolve(argument, 0, sizeof(gpointer));
  umockdev_ioctl_data_set_ptr(pointer.get(), 0, mine->data.get());
  umockdev_ioctl_client_complete(client, 0, 0);
  done.erase(mine);
}

void EmulatedKernel::Socket::Discard(UMockdevIoctlClient* client, UMockdevIoctlData* argument) {
  gulong wanted = 0;
  std::memcpy(&wanted, argument->data, sizeof(wanted));
  const auto urb = std::find_if(waiting.begin(), waiting.end(), [&](const Urb& candidate) {
    return candidate.client == client && candidate.data->client_addr == wanted;
  });
  if (urb == waiting.end()) {
    umockdev_ioctl_client_complete(client, -1, EINVAL);
    return;
  }
  urb->fields()->status = -ENOENT;
  done.push_back(std::move(*urb));
  waiting.erase(urb);
  umockdev_ioctl_client_complete(client, 0, 0);
}

EmulatedKernel::EmulatedKernel() : umockdev_(std::make_unique<Umockdev>()), now_ns_(Now_ns()) {
  umockdev_->testbed = umockdev_testbed_new();
  if (umockdev_in_mock_environment() == FALSE) {
    g_object_unref(umockdev_->testbed);
    throw Error(fmt::format("{} is not loaded", kPreload));
  }
  // Each emulated call sleeps for zero time, which would otherwise take 50 us.
  prctl(PR_SET_TIMERSLACK, 1);
  ticking_ = std::thread([this] {
    while (!end_) {
      std::this_thread::sleep_for(std::chrono::milliseconds(5));
      const std::lock_guard lock(mutex_);
      AdvanceAll();
    }
  });
}

EmulatedKernel::~EmulatedKernel() {
  end_ = true;
  ticking_.join();
  g_object_unref(umockdev_->testbed);
  for (UMockdevIoctlBase* handler : umockdev_->handlers) g_object_unref(handler);
}

void EmulatedKernel::AdvanceAll() {
  const std::int64_t now_ns = Now_ns();
  now_ns_ = std::max(now_ns_, now_ns - kMaxCaughtUp_ns);
  while (now_ns_ < now_ns) {
    const std::int64_t step_ns = std::min(kStep_ns, now_ns - now_ns_);
    for (const auto& socket : sockets_) socket->model->Advance(1e-9 * static_cast<double>(step_ns));
    now_ns_ += step_ns;
  }
}

void EmulatedKernel::Attach(Socket& socket) {
  const std::vector<std::uint8_t> descriptors = socket.model->descriptors();
  for (std::size_t at = 0; at + 3 < descriptors.size() && descriptors[at] > 0; at += descriptors[at]) {
    constexpr std::uint8_t kEndpoint = 5;
    constexpr int kInterrupt = 3;
    if (descriptors[at + 1] != kEndpoint) continue;
    socket.endpoint_types[descriptors[at + 2]] =
        (descriptors[at + 3] & 3) == kInterrupt ? USBDEVFS_URB_TYPE_INTERRUPT : USBDEVFS_URB_TYPE_BULK;
  }
  GError* error = nullptr;
  std::string text = DescribeUsb(socket.path, socket.address, descriptors, socket.model->bus_speed_mbit());
  const std::string interface = fmt::format("{}/{}:1.0", socket.path, socket.path.substr(socket.path.rfind('/') + 1));
  if (!socket.options.driver.empty()) {
    text =
        fmt::format("{}P: {}\nE: SUBSYSTEM=usb\nE: DEVTYPE=usb_interface\nL: driver=../../../../bus/usb/drivers/{}\n",
                    text, interface, socket.options.driver);
  }
  // The file that appears must be answered at once: umockdev ends a program that opens it before its socket listens.
  const std::string node = fmt::format("/dev/bus/usb/001/{:03}", socket.address);
  UMockdevIoctlBase* handler = umockdev_ioctl_base_new();
  umockdev_->handlers.push_back(handler);
  g_signal_connect(handler, "handle-ioctl", G_CALLBACK(Socket::HandleIoctl), &socket);
  g_signal_connect(handler, "client-vanished", G_CALLBACK(Socket::Forget), &socket);
  if (umockdev_testbed_attach_ioctl(umockdev_->testbed, node.c_str(), handler, &error) == FALSE) {
    throw Error(fmt::format("umockdev can't emulate {}: {}", node, error->message));
  }
  if (umockdev_testbed_add_from_string(umockdev_->testbed, text.c_str(), &error) == FALSE) {
    throw Error(fmt::format("umockdev refuses a device: {}", error->message));
  }
  if (socket.options.no_permission) {
    chmod((umockdev_->Root() + node).c_str(), 0);
  }
  socket.driver_bound = !socket.options.driver.empty();
}

int EmulatedKernel::PlugIn(UsbModel& model, const EmulatedSocket& options) {
  auto socket = std::make_unique<Socket>();
  socket->kernel = this;
  socket->model = &model;
  socket->options = options;
  socket->path = fmt::format("/devices/usb1/1-{}", sockets_.size() + 1);
  socket->address = next_address_++;
  Attach(*socket);
  const std::lock_guard lock(mutex_);
  sockets_.push_back(std::move(socket));
  return static_cast<int>(sockets_.size()) - 1;
}

void EmulatedKernel::Unplug(int number) {
  Socket& socket = *sockets_[number];
  {
    const std::lock_guard lock(mutex_);
    socket.plugged_in = false;
    socket.claimed_by = nullptr;
  }
  const std::string path = "/sys" + socket.path;
  umockdev_testbed_uevent(umockdev_->testbed, path.c_str(), "remove");
  umockdev_testbed_remove_device(umockdev_->testbed, path.c_str());
}

void EmulatedKernel::PlugInAgain(int number) {
  // The device gets a new socket; programs that still have the old file open get "no device" from now on.
  auto socket = std::make_unique<Socket>();
  {
    const std::lock_guard lock(mutex_);
    const Socket& before = *sockets_[number];
    socket->kernel = this;
    socket->model = before.model;
    socket->options = before.options;
    socket->path = before.path;
    socket->address = next_address_++;
    socket->model->PowerOn();
  }
  Attach(*socket);
  const std::string path = "/sys" + socket->path;
  {
    const std::lock_guard lock(mutex_);
    std::swap(sockets_[number], socket);
    past_.push_back(std::move(socket));
  }
  umockdev_testbed_uevent(umockdev_->testbed, path.c_str(), "add");
}

void EmulatedKernel::SetSilent(int number, bool silent) {
  const std::lock_guard lock(mutex_);
  sockets_[number]->silent = silent;
}

void EmulatedKernel::Look(const std::function<void()>& what) {
  const std::lock_guard lock(mutex_);
  AdvanceAll();
  what();
}

namespace {

constexpr std::uint32_t kOverrides = 1U << CAP_DAC_OVERRIDE | 1U << CAP_DAC_READ_SEARCH;

}  // namespace

WithoutPrivileges::WithoutPrivileges() {
  __user_cap_header_struct header{_LINUX_CAPABILITY_VERSION_3, 0};
  std::array<__user_cap_data_struct, 2> data{};
  syscall(SYS_capget, &header, data.data());
  effective_[0] = data[0].effective;
  effective_[1] = data[1].effective;
  data[0].effective &= ~kOverrides;
  syscall(SYS_capset, &header, data.data());
}

WithoutPrivileges::~WithoutPrivileges() {
  __user_cap_header_struct header{_LINUX_CAPABILITY_VERSION_3, 0};
  std::array<__user_cap_data_struct, 2> data{};
  syscall(SYS_capget, &header, data.data());
  data[0].effective = effective_[0];
  data[1].effective = effective_[1];
  syscall(SYS_capset, &header, data.data());
}

}  // namespace kerf::test
