// Datagrams to and from one address.
#pragma once

#include <cstdint>
#include <span>
#include <string>

namespace kerf {

enum class UdpEnd : std::uint8_t {
  kOk,
  kTimeout,
  kRefused,  // nobody listens there any more
  kFailed,
};

/// A socket that only hears what comes from `address` and `port`: the system drops the rest. One thread at a time.
class UdpLink {
 public:
  /// IPv4, in numbers. Throws Error when it is no such address, or the system has no socket.
  UdpLink(const std::string& address, std::uint16_t port);
  ~UdpLink();
  UdpLink(const UdpLink&) = delete;
  UdpLink& operator=(const UdpLink&) = delete;

  /// Send never waits, Receive up to `timeout_ms`; neither asks for memory.
  UdpEnd Send(std::span<const std::uint8_t> bytes) noexcept;
  /// A datagram; `count` is its length, also where it was longer than `bytes` and cut.
  UdpEnd Receive(std::span<std::uint8_t> bytes, int timeout_ms, std::size_t& count) noexcept;

 private:
  int socket_ = -1;
};

/// Whether an IPv4 address is this machine itself: 127.x.x.x. False for what is no address.
bool IsLoopbackAddress(const std::string& address);

}  // namespace kerf
