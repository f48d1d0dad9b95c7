// The link with a peer that uses the protocol's own library, and with peers that do not keep the protocol.
#include "session/link/slicer_link.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <igtlClientSocket.h>
#include <igtlPolyDataMessage.h>
#include <igtlStatusMessage.h>
#include <igtlTransformMessage.h>

#include <array>
#include <chrono>
#include <cstring>
#include <functional>
#include <map>
#include <thread>

#include "bone/grid/set_leaf.h"
#include "kerf/models.h"
#include "kerf/surface.h"
#include "session/run/run_loop.h"
#include "support/block_scene.h"
#include "support/message_of.h"

namespace kerf {
namespace {

using test::MessageOf;
using testing::HasSubstr;

constexpr std::chrono::seconds kPatience{60};  // what is waited for takes a fraction of a second

bool WaitFor(const std::function<bool()>& condition) {
  for (const auto until = std::chrono::steady_clock::now() + kPatience; std::chrono::steady_clock::now() < until;) {
    if (condition()) return true;
    std::this_thread::sleep_for(std::chrono::milliseconds(2));
  }
  return false;
}

class Client {
 public:
  explicit Client(int port) {
    EXPECT_EQ(socket_->ConnectToServer("127.0.0.1", port), 0);
    socket_->SetReceiveTimeout(static_cast<int>(1000 * kPatience.count()));
  }
  ~Client() { socket_->CloseSocket(); }

  bool Send(const std::string& bytes) { return socket_->Send(bytes.data(), static_cast<int>(bytes.size())) != 0; }
  /// Receives a message and keeps it by its type and name; returns false if the connection has ended.
  bool Receive() {
    igtl::MessageHeader::Pointer header = igtl::MessageHeader::New();
    header->InitPack();
    if (!Fill(header->GetPackPointer(), IgtlHeader::kBytes)) return false;
    header->Unpack();
    std::string body(static_cast<std::size_t>(header->GetBodySizeToRead()), '\0');
    if (!Fill(body.data(), body.size())) return false;
    last = std::string(header->GetDeviceType()) + " " + header->GetDeviceName();
    headers[last] = header;
    bodies[last] = body;
    ++counts[last];
    return true;
  }
  bool ReceiveUntil(const std::string& name) {
    while (Receive()) {
      if (last == name) return true;
    }
    return false;
  }
  template <typename Message>
  typename Message::Pointer Get(const std::string& name) {
    typename Message::Pointer message = Message::New();
    message->SetMessageHeader(headers[name]);
    message->AllocatePack();
    std::memcpy(message->GetPackBodyPointer(), bodies[name].data(), bodies[name].size());
    EXPECT_TRUE((message->Unpack(1) & igtl::MessageHeader::UNPACK_BODY) != 0) << name;
    return message;
  }

  std::string last;
  std::map<std::string, igtl::MessageHeader::Pointer> headers;
  std::map<std::string, std::string> bodies;
  std::map<std::string, int> counts;

 private:
  bool Fill(void* to, std::size_t bytes) {
    return bytes == 0 || socket_->Receive(to, static_cast<int>(bytes)) == static_cast<int>(bytes);
  }
  igtl::ClientSocket::Pointer socket_ = igtl::ClientSocket::New();
};

IgtlServerOptions AnyPort() {
  return {.port = 0, .rate_hz = 60};
}

/// A server whose frames are counters.
struct Counting {
  explicit Counting(std::size_t padding = 0)
      : server(AnyPort(),
               {.frame =
                    [this, padding] {
                      return std::make_shared<const std::string>(
                          MakeIgtlText({"frame", static_cast<double>(++frames)}, std::string(padding, 'x')));
                    },
                .welcome = [] { return std::vector<std::shared_ptr<const std::string>>(); },
                .take =
                    [this](IgtlServer::PeerNumber, const IgtlHeader& header, std::span<const std::uint8_t> content) {
                      if (header.type == "TRANSFORM") last = ReadIgtlTransform(content);
                      return std::shared_ptr<const std::string>();
                    }}) {}
  int frames = 0;  // only used in the server's thread
  Pose last;       // the same
  IgtlServer server;
};

TEST(IgtlServer, ExchangesAThousandMessagesEachWay) {
  Counting counting;
  Client client(counting.server.port());
  for (int i = 1; i <= 1000; ++i)
    ASSERT_TRUE(client.Send(MakeIgtlTransform({"tool", 0}, {{1, 0, 0, 0}, {0, 0, 0.001 * i}})));
  EXPECT_TRUE(WaitFor([&] { return counting.server.counts().received == 1000; })) << counting.server.counts().received;
  for (int i = 0; i < 1000; ++i)
    counting.server.Send(i, std::make_shared<const std::string>(MakeIgtlText({"many", 0}, std::to_string(i))));
  while (client.counts["STRING many"] < 1000) ASSERT_TRUE(client.Receive());
  EXPECT_THAT(client.bodies["STRING many"], HasSubstr("999"));
  EXPECT_EQ(counting.server.counts().disconnected, 0U);
}

TEST(IgtlServer, DropsPeersThatDoNotKeepTheProtocol) {
  Counting counting;
  const std::string good = MakeIgtlTransform({"tool", 0}, {});
  std::string huge = good, wrong = good;
  huge[43] = 1;                                        // 2^48 bytes
  wrong.back() = static_cast<char>(wrong.back() ^ 1);  // checksum
  const std::vector<std::pair<std::string, std::string>> cases = {
      {std::string(400, 'G'), "protocol version"}, {huge, "the limit is 1048576"}, {wrong, "checksum"}};
  for (const auto& [bytes, reason] : cases) {
    Client client(counting.server.port());
    client.Send(bytes);
    while (client.Receive()) {
    }
    EXPECT_THAT(counting.server.counts().reasons.back(), HasSubstr(reason));
  }
  EXPECT_EQ(counting.server.counts().reasons.size(), 3U);
  for (int i = 0; i < 2; ++i) {
    Client again(counting.server.port());
    again.Send(wrong);
    while (again.Receive()) {
    }
  }
  EXPECT_EQ(counting.server.counts().disconnected, 5U);
  EXPECT_EQ(counting.server.counts().reasons.size(), 3U);  // each once
  // One that goes in the middle of a message.
  { Client(counting.server.port()).Send(good.substr(0, 70)); }
  // Other peers are not disturbed.
  Client last(counting.server.port());
  last.Send(good);
  EXPECT_TRUE(WaitFor([&] { return counting.server.counts().received == 1; }));
  EXPECT_TRUE(last.Receive());
}

TEST(IgtlServer, APeerThatDoesNotReadOnlyMissesFrames) {
  Counting counting(60'000);
  Client slow(counting.server.port()), quick(counting.server.port());
  // Its buffers hold some megabytes; then frames are skipped, and the other peer still gets its own.
  while (counting.server.counts().skipped == 0) ASSERT_TRUE(quick.Receive());
  const int before = quick.counts["STRING frame"];
  while (quick.counts["STRING frame"] < before + 20) ASSERT_TRUE(quick.Receive());
  EXPECT_GT(counting.server.counts().skipped, 10U);
}

TEST(IgtlServer, RefusesWhatItCannotDo) {
  const Counting counting;
  const auto listen = [](const IgtlServerOptions& options) {
    return MessageOf([&] { const IgtlServer server(options, {}); });
  };
  EXPECT_THAT(listen({.port = counting.server.port()}), HasSubstr("cannot listen on 127.0.0.1, port"));
  EXPECT_THAT(listen({.address = "localhost", .port = 0}), HasSubstr("'localhost' is not a numeric address"));
  EXPECT_THAT(listen({.port = 70'000}), HasSubstr("port = 70000"));
  std::vector<std::unique_ptr<Client>> clients;
  for (int i = 0; i <= IgtlServer::kMaxPeers; ++i) clients.push_back(std::make_unique<Client>(counting.server.port()));
  EXPECT_FALSE(clients.back()->Receive());
  EXPECT_TRUE(clients.front()->Receive());
}

TEST(SlicerLink, FollowsTheFirstTrackedToolUntilItsPeerIsGoneOrSilent) {
  SlicerLink link(AnyPort());
  const auto send = [](Client& client, double z_mm) {
    ASSERT_TRUE(client.Send(MakeIgtlTransform({"kerf_hand", 0}, {{1, 0, 0, 0}, {0, 0, z_mm}})));
  };
  Pose X_WH;
  const auto send_until_followed = [&](Client& client, double z_mm) {
    ASSERT_TRUE(WaitFor([&] {
      send(client, z_mm);
      return link.tracked_tool()->Fetch(X_WH) == RoundEnd::kSample && X_WH.p_AB.z == z_mm;
    }));
  };
  Client first(link.port());
  auto second = std::make_unique<Client>(link.port());
  send_until_followed(first, 1);
  // The first one stays connected, but is silent.
  send_until_followed(*second, 2);
  // The second one goes.
  second.reset();
  send_until_followed(first, 3);
}

TEST(SlicerLink, RefusesABoneWithoutReadingItAndStaysConnected) {
  SlicerLink link(AnyPort());
  Client client(link.port());
  const std::string status = "STATUS kerf";
  const auto await = [&](const std::string& sentence) {
    do {
      ASSERT_TRUE(client.ReceiveUntil(status));
    } while (std::string(client.Get<igtl::StatusMessage>(status)->GetStatusString()).find(sentence) ==
             std::string::npos);
  };
  std::string bone = MakeIgtlSurface({"kerf_bone", 0}, {{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, {{0, 1, 2}}});
  ASSERT_TRUE(client.Send(bone));
  await("the bone of this session is fixed");
  link.bone().Open();
  ASSERT_TRUE(client.Send(bone));
  await("the bone was received");
  EXPECT_TRUE(link.bone().Fetch().has_value());
  // 3 MiB are too many for other messages; what follows is read again.
  const std::string text = MakeIgtlText({"text", 0}, std::string(60'000, 'x'));
  std::string large = text.substr(0, IgtlHeader::kBytes) + std::string(3 << 20, 'x');
  large.replace(42, 8, std::string("\0\0\0\0\0\x30\0\0", 8));
  ASSERT_TRUE(client.Send(large));
  await("a message of type STRING has 3145728 bytes; the limit is 1048576");
  ASSERT_TRUE(client.Send(MakeIgtlTransform({"plane", 0}, {})));
  await("the plan of this session cannot be changed now");
  EXPECT_EQ(link.counts().disconnected, 0U);
  EXPECT_EQ(link.counts().received, 4U);
  EXPECT_EQ(link.refusals(), 3U);
}

TEST(SlicerLink, ShowsTheToolTheForceAndTheBoneAsItIsAtTheEnd) {
  const Scene scene = ParseScene(test::kBarToml + test::kThroughBarToml, "s.toml");
  TriangleMesh tool{{{1, 2, 3}, {4, 5, 6}, {7, 8, 10}}, {{0, 1, 2}}};
  SlicerLink link(AnyPort());
  link.Show("a bar", tool);
  Client client(link.port());
  LoopOptions options;
  options.seconds = 3;
  options.output.keep_bones = true;
  options.watchers.peer = &link;
  Pose X_WT;
  options.watchers.take_tick = [&](const LoopTick& tick, std::span<const double> channels) {
    link.TakeTick(tick, channels);
    X_WT = tick.coupled.X_WT;
  };
  options.virtual_time = true;
  const LoopSummary summary = RunLoop(scene, options, {});
  EXPECT_FALSE(summary.undo.has_value());  // the link needs none
  link.End("the session has ended");
  const std::string status = "STATUS kerf";
  do {
    ASSERT_TRUE(client.ReceiveUntil(status));
  } while (client.Get<igtl::StatusMessage>(status)->GetStatusString() != std::string("the session has ended"));
  EXPECT_EQ(client.counts["POLYDATA kerf_tool_shape"], 1);
  EXPECT_THAT(client.bodies["STRING kerf_names"], HasSubstr("time_s\ncut_mm3"));
  EXPECT_GE(client.counts["SENSOR kerf_force"], 1);
  EXPECT_THAT(client.bodies["STRING kerf_values"], HasSubstr("force_N "));
  EXPECT_THAT(client.bodies["STRING kerf_values"], HasSubstr("\ntime_s 3.000\ncut_mm3 "));
  // The bone that was sent last is that of the session's end.
  const TriangleMesh surface = ExtractSurface(summary.after, 0.1);
  const auto bone = client.Get<igtl::PolyDataMessage>("POLYDATA kerf_bone");
  ASSERT_EQ(static_cast<std::size_t>(bone->GetPoints()->GetNumberOfPoints()), surface.points.size());
  EXPECT_EQ(bone->GetPolygons()->GetNumberOfCells(), surface.triangles.size());
  for (std::size_t i = 0; i < surface.points.size(); ++i) {
    std::array<float, 3> p{};
    bone->GetPoints()->GetPoint(static_cast<unsigned int>(i), p.data());
    // Points are sent as float numbers.
    ASSERT_LT(glm::length(Vec3(-p[0], -p[1], p[2]) - surface.points[i]), 1e-5);
  }
  // Before the end, the tool was where a tick left it.
  Client late(link.port());
  ASSERT_TRUE(late.Send(MakeIgtlStatus({"asks", 0}, false, "")));  // is ignored
  igtl::GetStatusMessage::Pointer ask = igtl::GetStatusMessage::New();
  ask->Pack();
  ASSERT_TRUE(
      late.Send({static_cast<const char*>(ask->GetPackPointer()), static_cast<std::size_t>(ask->GetPackSize())}));
  ASSERT_TRUE(late.ReceiveUntil("POLYDATA kerf_bone"));
  while (late.counts[status] < 2) ASSERT_TRUE(late.Receive());
  // The other peer gets no answer.
  const int others = client.counts[status];
  link.End("again");
  ASSERT_TRUE(client.ReceiveUntil(status));
  EXPECT_EQ(client.counts[status], others + 1);
  EXPECT_STREQ(client.Get<igtl::StatusMessage>(status)->GetStatusString(), "again");
  igtl::Matrix4x4 m;
  client.Get<igtl::TransformMessage>("TRANSFORM kerf_tool")->GetMatrix(m);
  EXPECT_GT(m[2][3], 0);
}

}  // namespace
}  // namespace kerf
