#include "device/drivers/udp_link.h"

#include <arpa/inet.h>
#include <fmt/format.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <cerrno>
#include <system_error>

#include "kerf/error.h"

namespace kerf {
namespace {

UdpEnd EndOf(int error) {
  if (error == ECONNREFUSED) return UdpEnd::kRefused;
  if (error == EAGAIN || error == EWOULDBLOCK || error == EINTR) return UdpEnd::kTimeout;
  return UdpEnd::kFailed;
}

}  // namespace

bool IsLoopbackAddress(const std::string& address) {
  in_addr parsed{};
  return inet_pton(AF_INET, address.c_str(), &parsed) == 1 && ntohl(parsed.s_addr) >> 24 == 127;
}

UdpLink::UdpLink(const std::string& address, std::uint16_t port) {
  sockaddr_in to{};
  to.sin_family = AF_INET;
  to.sin_port = htons(port);
  if (inet_pton(AF_INET, address.c_str(), &to.sin_addr) != 1) {
    throw Error(fmt::format("\"{}\" is not a numeric IPv4 address, such as 127.0.0.1", address));
  }
  socket_ = socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
  if (socket_ < 0 || connect(socket_, reinterpret_cast<const sockaddr*>(&to), sizeof to) != 0) {
    const std::string why = std::system_category().message(errno);
    if (socket_ >= 0) close(socket_);
    throw Error(fmt::format("can't reach {}:{}: {}", address, port, why));
  }
}

UdpLink::~UdpLink() {
  close(socket_);
}

UdpEnd UdpLink::Send(std::span<const std::uint8_t> bytes) noexcept {
  const ssize_t sent = send(socket_, bytes.data(), bytes.size(), MSG_NOSIGNAL);
  return sent == static_cast<ssize_t>(bytes.size()) ? UdpEnd::kOk : EndOf(sent < 0 ? errno : EMSGSIZE);
}

UdpEnd UdpLink::Receive(std::span<std::uint8_t> bytes, int timeout_ms, std::size_t& count) noexcept {
  count = 0;
  pollfd waiting{.fd = socket_, .events = POLLIN, .revents = 0};
  if (timeout_ms > 0) {
    const int ready = poll(&waiting, 1, timeout_ms);
    if (ready == 0) return UdpEnd::kTimeout;
    if (ready < 0) return EndOf(errno);
  }
  const ssize_t got = recv(socket_, bytes.data(), bytes.size(), MSG_TRUNC);
  if (got < 0) return EndOf(errno);
  count = static_cast<std::size_t>(got);
  return UdpEnd::kOk;
}

}  // namespace kerf
