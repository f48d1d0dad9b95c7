// The example bridge when more packets arrive than it should handle in one turn of its loop.
#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <csignal>
#include <map>
#include <stdexcept>
#include <string>

#include "device/devices/bridge/bridge_packet.h"
#include "device/drivers/child_process.h"
#include "test_paths.h"

namespace kerf {
namespace {

using test::ChildProcess;

/// A socket that communicates with the example.
class Asker {
 public:
  explicit Asker(std::uint16_t port) : socket_(socket(AF_INET, SOCK_DGRAM, 0)) {
    sockaddr_in to{};
    to.sin_family = AF_INET;
    to.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    to.sin_port = htons(port);
    if (connect(socket_, reinterpret_cast<const sockaddr*>(&to), sizeof to) != 0) throw std::runtime_error("no socket");
  }
  ~Asker() { close(socket_); }
  Asker(const Asker&) = delete;
  Asker& operator=(const Asker&) = delete;

  void Send(const BridgeBytes& bytes) const { send(socket_, bytes.data(), bytes.size(), 0); }
  /// Returns false if no packet arrives within `wait_ms`.
  bool Receive(BridgeBytes& bytes, int wait_ms) const {
    pollfd waiting{.fd = socket_, .events = POLLIN, .revents = 0};
    return poll(&waiting, 1, wait_ms) > 0 && recv(socket_, bytes.data(), bytes.size(), 0) == ssize_t(bytes.size());
  }

 private:
  int socket_;
};

TEST(BridgeExample, UpdatesItsDeviceEvenWithManyPackets) {
  ChildProcess example({KERF_BRIDGE_EXAMPLE, "0"});
  const std::string line = example.ReadLine();
  const Asker asker(static_cast<std::uint16_t>(std::stoi(line.substr(line.rfind(':') + 1))));
  BridgeHeader header;
  header.session = 7;
  BridgeBytes bytes{};
  asker.Send(WriteBridgeHello(header));
  ASSERT_TRUE(asker.Receive(bytes, 10'000));
  // All packets are queued before the example can read the first; each answer states when its state was measured.
  example.Signal(SIGSTOP);
  for (int i = 0; i < 150; ++i) {
    ++header.sequence;
    asker.Send(WriteBridgeCommand(header, {}));
  }
  example.Signal(SIGCONT);
  std::map<std::uint64_t, int> answers_of_one_look;
  int answers = 0;
  while (answers < 150 && asker.Receive(bytes, answers == 0 ? 10'000 : 1'000)) {
    ++answers;
    ++answers_of_one_look[ReadBridgeHeader(bytes).value_or(BridgeHeader{}).time_ns];
  }
  EXPECT_GT(answers, 64);  // one for each packet, except those that the socket's buffer dropped
  for (const auto& [time_ns, count] : answers_of_one_look) EXPECT_LE(count, 64) << time_ns;
}

}  // namespace
}  // namespace kerf
