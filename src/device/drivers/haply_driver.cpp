#include "device/drivers/haply_driver.h"

#include <fmt/format.h>

#include <algorithm>
#include <boost/asio/connect.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/beast/core/buffers_to_string.hpp>
#include <boost/beast/core/flat_buffer.hpp>
#include <boost/beast/websocket.hpp>
#include <chrono>
#include <cmath>
#include <glm/geometric.hpp>

#include "device/devices/profiles.h"
#include "device/drivers/udp_link.h"
#include "kerf/error.h"

namespace kerf {

namespace asio = boost::asio;
namespace beast = boost::beast;
using Clock = std::chrono::steady_clock;

constexpr auto kLate = std::chrono::milliseconds(5);
constexpr int kSendBytes = 8192;
constexpr int kMaxMessages = 64;  // per call to Receive()

/// WebSocket with a timeout for each wait. Unfinished operations continue in the next call.
class HaplyDriver::Connection {
 public:
  Connection() : stream_(context_) {
    stream_.read_message_max(256 << 10);
    stream_.text(true);
    received_.reserve(64 << 10);
  }
  ~Connection() {
    beast::error_code ignored;
    stream_.next_layer().close(ignored);
    // Complete the cancelled operations while their buffers still exist.
    context_.restart();
    context_.run_for(std::chrono::seconds(1));
  }
  Connection(const Connection&) = delete;
  Connection& operator=(const Connection&) = delete;

  /// Returns the error; timed_out if it takes too long.
  beast::error_code Connect(const asio::ip::tcp::endpoint& to, std::chrono::milliseconds max_wait) {
    const auto end = Clock::now() + max_wait;
    std::optional<beast::error_code> error;
    stream_.next_layer().async_connect(to, [&error](beast::error_code e) { error = e; });
    if (!RunUntil(end, [&error] { return error.has_value(); })) return Abandon();
    if (*error) return *error;
    beast::error_code ignored;
    stream_.next_layer().set_option(asio::ip::tcp::no_delay(true), ignored);
    // A service that does not read is noticed only when the send buffer is full, so the buffer is small.
    stream_.next_layer().set_option(asio::socket_base::send_buffer_size(kSendBytes), ignored);
    error.reset();
    stream_.async_handshake(fmt::format("localhost:{}", to.port()), "/", [&error](beast::error_code e) { error = e; });
    if (!RunUntil(end, [&error] { return error.has_value(); })) return Abandon();
    return *error;
  }

  /// Starts sending. Returns false and does nothing if an earlier text is still being sent or the connection is broken.
  bool Send(std::string text) {
    if (sending_ || error_) return false;
    sending_ = true;
    sent_ = std::move(text);
    stream_.async_write(asio::buffer(sent_), [this](beast::error_code e, std::size_t) {
      sending_ = false;
      if (e) error_ = e;
    });
    return true;
  }

  /// Returns the latest message, or nullopt on timeout or if the connection is broken. If `end` has already passed,
  /// returns what has already arrived.
  std::optional<std::string> Receive(Clock::time_point end) {
    std::optional<std::string> newest;
    for (int i = 0; i < kMaxMessages; ++i) {
      BeginReading();
      const auto until = newest ? Clock::now() : end;
      if (!RunUntil(until, [this] { return !reading_ || error_; })) break;
      if (error_) break;
      newest = beast::buffers_to_string(received_.data());
      received_.consume(received_.size());
    }
    return newest;
  }

  void Flush(Clock::time_point end) {
    RunUntil(end, [this] { return !sending_ || error_; });
  }

  bool broken() const { return error_.failed(); }
  bool sending() const { return sending_; }

 private:
  void BeginReading() {
    if (reading_ || error_) return;
    reading_ = true;
    stream_.async_read(received_, [this](beast::error_code e, std::size_t) {
      reading_ = false;
      if (e) error_ = e;
    });
  }

  template <typename Done>
  bool RunUntil(Clock::time_point end, const Done& done) {
    context_.restart();
    // Take what has already arrived even if no time is left, but stop if the service does not stop sending.
    const Clock::time_point last = std::max(end, Clock::now()) + kLate;
    while (!done()) {
      if (context_.poll_one() > 0) {
        if (Clock::now() > last) break;
        continue;
      }
      if (context_.stopped() || context_.run_one_until(end) == 0) break;
    }
    return done();
  }

  beast::error_code Abandon() {
    beast::error_code ignored;
    stream_.next_layer().close(ignored);
    context_.restart();
    context_.run_for(std::chrono::seconds(1));  // runs handlers that refer to local variables
    return asio::error::timed_out;
  }

  asio::io_context context_;
  beast::websocket::stream<asio::ip::tcp::socket> stream_;
  beast::flat_buffer received_;
  std::string sent_;
  bool sending_ = false;
  bool reading_ = false;
  beast::error_code error_;
};

HaplyDriver::HaplyDriver(const HaplyOptions& options) : options_(options), profile_(FindDeviceProfile("inverse3")) {
  if (!IsLoopbackAddress(options.address)) {
    throw Error(fmt::format("the Haply service must be on this machine (127.x.x.x), not at {}", options.address));
  }
  CheckParameters(options, "Haply service");
  traits_.timeout_ms = options.timeout_ms;
}

HaplyDriver::~HaplyDriver() {
  HaplyDriver::Stop();
}

void HaplyDriver::Start(const std::function<bool(const std::string& doing, double fraction)>& show) {
  const auto report_progress = [&show](const std::string& doing, double fraction) {
    if (show && !show(doing, fraction)) throw Error("starting the device was cancelled");
  };
  const std::string where = fmt::format("ws://{}:{}", options_.address, options_.port);
  Stop();
  report_progress(fmt::format("connecting to the Haply service at {}", where), 0);
  const std::chrono::milliseconds max_wait(options_.start_timeout_ms);
  auto connection = std::make_unique<Connection>();
  const asio::ip::tcp::endpoint to(asio::ip::make_address(options_.address), options_.port);
  if (const beast::error_code error = connection->Connect(to, max_wait)) {
    throw Error(
        error == asio::error::connection_refused
            ? fmt::format("no Haply service is listening at {}; install and start Haply's Inverse Service", where)
            : fmt::format("the Haply service at {} can't be reached: {}", where, error.message()));
  }
  report_progress("waiting for the list of devices", 0.5);
  const auto end = Clock::now() + max_wait;
  bool spoke = false;
  bool good = false;
  bool listed = false;
  while (!listed && !connection->broken() && Clock::now() < end) {
    const std::optional<std::string> text = connection->Receive(end);
    if (!text) break;
    spoke = true;
    const HaplyReading reading = ReadHaplyMessage(*text, options_.device_id, state_);
    good = good || reading != HaplyReading::kBad;
    listed = reading == HaplyReading::kOk;
  }
  if (!spoke) throw Error(fmt::format("the Haply service at {} does not answer; restart it", where));
  if (!good) {
    throw Error(
        fmt::format("the program listening at {} does not speak the JSON of Haply's Inverse Service 3.1", where));
  }
  if (!listed) {
    throw Error(options_.device_id.empty()
                    ? "the Haply service lists no Inverse3; plug it in, switch it on, and check that Haply's own "
                      "program shows it"
                    : fmt::format("the Haply service lists no Inverse3 with the id {}", options_.device_id));
  }
  p_H_middle_mm_ = options_.p_H_middle_mm.value_or(state_.p_H_mm);
  traits_.senses_orientation = state_.R_H_grip.has_value();
  traits_.buttons.clear();
  if (traits_.senses_orientation) traits_.buttons = {"a", "b", "c"};
  missing_ = 0;
  connection_ = std::move(connection);
  report_progress("ready", 1);
}

RoundEnd HaplyDriver::Take(const std::string& text, DriverSample& sample) {
  const HaplyReading reading = ReadHaplyMessage(text, state_.id, state_);
  if (reading == HaplyReading::kBad) return RoundEnd::kBadAnswer;
  if (reading == HaplyReading::kNoDevice) {
    if (++missing_ < kMaxMissing) return RoundEnd::kNoAnswer;
    connection_.reset();
    return RoundEnd::kGone;
  }
  missing_ = 0;
  if (traits_.senses_orientation && !state_.R_H_grip) return RoundEnd::kNoAnswer;
  sample = DriverSample{};
  sample.X_DH.p_AB = HaplyToFrameD(state_.p_H_mm - p_H_middle_mm_);
  if (traits_.senses_orientation && state_.R_H_grip) sample.X_DH.R_AB = HaplyToFrameD(*state_.R_H_grip);
  sample.buttons = state_.buttons;
  return RoundEnd::kSample;
}

RoundEnd HaplyDriver::Exchange(const DriverCommand& command, DriverSample& sample) noexcept {
  if (!connection_) return RoundEnd::kGone;
  try {
    Vec3 f_D_N = command.f_D_N;
    const double force_N = glm::length(f_D_N);
    if (!std::isfinite(force_N)) f_D_N = Vec3{0};
    if (force_N > profile_.peak_force_N) f_D_N *= profile_.peak_force_N / force_N;
    // A message that arrived before the force was sent does not answer it. If it were used as the answer, one late
    // message would delay every later round by one. It is used only if no other message arrives.
    const std::optional<std::string> late = connection_->Receive(Clock::now());
    const bool begun = connection_->Send(WriteHaplyForce(state_.id, FrameDToHaply(f_D_N)));
    const auto end = Clock::now() + std::chrono::milliseconds(options_.timeout_ms);
    const std::optional<std::string> text = connection_->Receive(end);
    // If the service sends states but does not read, there is no answer, because the device still outputs an older
    // force.
    const bool gone_out = begun && !connection_->sending();
    if (gone_out && (text || late)) return Take(text ? *text : *late, sample);
    if (!connection_->broken()) return RoundEnd::kNoAnswer;
  } catch (const std::exception&) {
    // Lack of memory, or a connection error thrown by Boost, is treated as a lost connection.
  }
  connection_.reset();
  return RoundEnd::kGone;
}

void HaplyDriver::Stop() noexcept {
  if (!connection_) return;
  try {
    const auto end = Clock::now() + std::chrono::milliseconds(100);
    connection_->Flush(end);
    connection_->Send(WriteHaplyForce(state_.id, Vec3{0}));
    connection_->Flush(end);
  } catch (const std::exception&) {
    // The service sets the force to zero when the connection ends.
  }
  connection_.reset();
}

}  // namespace kerf
