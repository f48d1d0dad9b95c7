// UDP socket connected to one address.
#pragma once

#include <cstdint>
#include <span>
#include <string>

namespace kerf {

enum class UdpEnd : std::uint8_t {
  kOk,
  kTimeout,
  kRefused,  // no program listens there
  kFailed,
};

/// Socket that receives only from `address` and `port`: the system drops other packets. Used by one thread at a time.
class UdpLink {
 public:
  /// `address` is a numeric IPv4 address. Throws kerf::Error if it is not, or if the system cannot create a socket.
  UdpLink(const std::string& address, std::uint16_t port);
  ~UdpLink();
  UdpLink(const UdpLink&) = delete;
  UdpLink& operator=(const UdpLink&) = delete;

  /// Send() never blocks; Receive() waits at most `timeout_ms`. Neither allocates.
  UdpEnd Send(std::span<const std::uint8_t> bytes) noexcept;
  /// Receives a datagram. `count` is its full length, even if it was longer than `bytes` and was truncated.
  UdpEnd Receive(std::span<std::uint8_t> bytes, int timeout_ms, std::size_t& count) noexcept;

 private:
  int socket_ = -1;
};

/// Returns true if the text is an IPv4 address of this machine: 127.x.x.x. Returns false for any other text.
bool IsLoopbackAddress(const std::string& address);

}  // namespace kerf
