#include "device/drivers/haply_service.h"

#include <arpa/inet.h>
#include <fmt/format.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/beast/core/buffers_to_string.hpp>
#include <boost/beast/core/flat_buffer.hpp>
#include <boost/beast/websocket.hpp>
#include <chrono>
#include <nlohmann/json.hpp>
#include <stdexcept>

namespace kerf::test {

namespace asio = boost::asio;
namespace beast = boost::beast;

HaplyService::HaplyService(Mood mood, bool with_grip, std::uint16_t port) : mood_(mood), with_grip_(with_grip) {
  listening_ = socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
  const int again = 1;  // allows the port of an earlier service to be used again
  setsockopt(listening_, SOL_SOCKET, SO_REUSEADDR, &again, sizeof again);
  const int little = 4096;  // bytes that are buffered before the service reads them
  setsockopt(listening_, SOL_SOCKET, SO_RCVBUF, &little, sizeof little);
  sockaddr_in at{};
  at.sin_family = AF_INET;
  at.sin_port = htons(port);
  at.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  socklen_t size = sizeof at;
  if (bind(listening_, reinterpret_cast<const sockaddr*>(&at), sizeof at) != 0 || listen(listening_, 4) != 0 ||
      getsockname(listening_, reinterpret_cast<sockaddr*>(&at), &size) != 0) {
    close(listening_);
    throw std::runtime_error("no socket");
  }
  port_ = ntohs(at.sin_port);
  thread_ = std::thread([this] { Serve(); });
}

HaplyService::~HaplyService() {
  stop_ = true;
  const int connection = connection_;
  if (connection >= 0) shutdown(connection, SHUT_RDWR);
  thread_.join();
  close(listening_);
}

std::string HaplyService::MakeState() const {
  std::lock_guard lock(mutex_);
  nlohmann::json message;
  nlohmann::json device;
  device["device_id"] = "04BA";
  const Vec3 p_H_m = p_H_m_ + (moves_with_force_ ? 1e-3 : 0) * force_N_;
  device["state"]["cursor_position"] = {{"x", p_H_m.x}, {"y", p_H_m.y}, {"z", p_H_m.z}};
  device["state"]["cursor_velocity"] = {{"x", 0.0}, {"y", 0.0}, {"z", 0.0}};
  message["inverse3"] = nlohmann::json::array({device});
  message["wireless_verse_grip"] = nlohmann::json::array();
  if (with_grip_ && mood_ != Mood::kNoGrip) {
    nlohmann::json grip;
    grip["device_id"] = "61576";
    grip["state"]["orientation"] = {{"x", 0.0}, {"y", 0.0}, {"z", 0.6}, {"w", 0.8}};
    grip["state"]["buttons"] = {{"a", true}, {"b", false}, {"c", true}};
    message["wireless_verse_grip"].push_back(grip);
  }
  return message.dump();
}

void HaplyService::Serve() {
  while (!stop_) {
    pollfd waiting{.fd = listening_, .events = POLLIN, .revents = 0};
    if (poll(&waiting, 1, 5) <= 0) continue;
    const int accepted = accept(listening_, nullptr, nullptr);
    if (accepted < 0) continue;
    connection_ = accepted;
    asio::io_context context;
    beast::websocket::stream<asio::ip::tcp::socket> stream(context);
    beast::error_code error;
    stream.next_layer().assign(asio::ip::tcp::v4(), accepted, error);
    stream.accept(error);
    const auto say = [&](const std::string& text) {
      if (!error) stream.write(asio::buffer(text), error);
      ++reported_;
    };
    bool hello = true;
    while (!error && !stop_) {
      switch (mood_) {
        case Mood::kGarbage:
          say("{\"inverse3\": [");
          break;
        case Mood::kStrange:
          say(R"({"inverse3": [{"device_id": "04BA", "state": {"cursor_position": {"x": "far", "y": 1e999}}}]})");
          break;
        case Mood::kNoDevice:
          say(R"({"inverse3": [], "wireless_verse_grip": []})");
          break;
        case Mood::kSlow:
          std::this_thread::sleep_for(std::chrono::milliseconds(60));
          say(MakeState());
          break;
        case Mood::kSilent:
          break;
        case Mood::kDeaf:
          while (mood_ == Mood::kDeaf && !stop_ && !error) {
            say(MakeState());
            std::this_thread::sleep_for(std::chrono::microseconds(100));
          }
          break;
        case Mood::kWithheld:
          while (mood_ == Mood::kWithheld && !stop_) std::this_thread::sleep_for(std::chrono::milliseconds(1));
          say(MakeState());
          break;
        case Mood::kShortHello:
          if (hello) say("hello");
          say(MakeState());
          break;
        case Mood::kClosing:
        case Mood::kGood:
        case Mood::kNoGrip:
          say(MakeState());
          break;
      }
      hello = false;
      if (error) break;
      beast::flat_buffer received;
      stream.read(received, error);
      if (error) break;
      const auto message = nlohmann::json::parse(beast::buffers_to_string(received.data()), nullptr, false);
      if (message.is_object()) {
        const auto& values = message["inverse3"][0]["commands"]["set_cursor_force"]["values"];
        std::lock_guard lock(mutex_);
        force_N_ = {values["x"].get<double>(), values["y"].get<double>(), values["z"].get<double>()};
        ++forces_;
      }
      if (mood_ == Mood::kClosing) break;
    }
    connection_ = -1;
    beast::error_code ignored;
    if (!error) stream.close(beast::websocket::close_code::going_away, ignored);
    stream.next_layer().close(ignored);
  }
}

}  // namespace kerf::test
