// Server of OpenIGTLink: sends what changes to every peer that is connected, and takes what they send.
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "kerf/describe.h"
#include "session/link/igtl_message.h"

namespace kerf {

inline constexpr Range kIgtlPortRange{0, 65535};

struct IgtlServerOptions {
  std::string address = "127.0.0.1";  // numeric; of the interface on which it listens
  int port = 18944;                   // the port that is registered for OpenIGTLink; 0: a free one
  double rate_hz = 30;                // at which frames are sent
};
template <typename V>
void Describe(IgtlServerOptions& p, V&& visit) {
  visit("port", p.port, kIgtlPortRange, "TCP port on which OpenIGTLink peers connect; 0: a free one");
  visit("rate_hz", p.rate_hz, Range{1, 60}, "rate at which the tool's pose and the forces are sent");
}

struct IgtlCounts {
  std::uint64_t peers = 0;             // connected so far
  std::uint64_t sent = 0;              // messages to all peers
  std::uint64_t skipped = 0;           // frames that a peer did not get, because it had not taken the last one
  std::uint64_t received = 0;          // valid messages, and those that were refused before their body was read
  std::uint64_t disconnected = 0;      // peers that were disconnected or not admitted for a reason
  std::vector<std::string> reasons{};  // of these, one sentence each, without repetition; at most kMaxReasons
};

/// Has a thread of its own, in which it calls the functions below. Nothing waits for a peer: one that does not read
/// misses frames, and is disconnected after kPatience_s without progress; it then costs at most the messages that are
/// on their way to it.
class IgtlServer {
 public:
  static constexpr int kMaxPeers = 4;
  static constexpr std::size_t kMaxReasons = 8;
  static constexpr std::size_t kMaxBodyBytes = 1 << 20;  // of a received message, unless Calls::max_bytes allows more
  static constexpr std::uint64_t kMaxSkippedBytes = std::uint64_t{1} << 32;  // of a refused message
  static constexpr double kPatience_s = 10;
  static constexpr int kMessagesPerFrame = 200;  // received from a peer; further ones wait

  using PeerNumber = std::uint64_t;  // from 1 on, in the order in which they connected

  struct Calls {
    /// Returns the messages of a frame; null for none. Called at the rate, while a peer is connected.
    std::function<std::shared_ptr<const std::string>()> frame;
    /// Returns what a new peer gets first.
    std::function<std::vector<std::shared_ptr<const std::string>>()> welcome;
    /// Takes a message of a peer and returns the answer; null: none. An answer that the peer has not got yet is
    /// replaced by the next one. Throws kerf::Error to disconnect it.
    std::function<std::shared_ptr<const std::string>(PeerNumber, const IgtlHeader&,
                                                     std::span<const std::uint8_t> content)>
        take;
    /// Returns the number of bytes that the body of a message with this header may have. Throws kerf::Error to refuse
    /// it before its body is read. Optional.
    std::function<std::size_t(const IgtlHeader&)> max_bytes{};
    /// Returns the answer to a message that is refused, with the reason; null: none. Its body is then skipped. Without
    /// this function, or if the body has more than kMaxSkippedBytes, the peer is disconnected.
    std::function<std::shared_ptr<const std::string>(const std::string& reason)> refuse{};
    /// A peer is disconnected. Optional.
    std::function<void(PeerNumber)> gone{};
  };

  /// Throws kerf::Error if it cannot listen there.
  IgtlServer(const IgtlServerOptions& options, Calls calls);
  /// Disconnects all peers.
  ~IgtlServer();
  IgtlServer(const IgtlServer&) = delete;
  IgtlServer& operator=(const IgtlServer&) = delete;

  int port() const;  // on which it listens
  /// Sends messages that replace earlier ones with the same `slot`, if a peer has not got those yet.
  void Send(int slot, std::shared_ptr<const std::string> messages);
  /// Waits until all peers have got everything that was sent, at most for this time.
  void WaitUntilSent(std::chrono::milliseconds max_wait);
  IgtlCounts counts() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace kerf
