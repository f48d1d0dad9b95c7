#include "session/link/igtl_server.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/post.hpp>
#include <boost/asio/read.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/asio/write.hpp>
#include <chrono>
#include <deque>
#include <future>
#include <mutex>
#include <thread>
#include <utility>

#include "kerf/error.h"

namespace kerf {
namespace {

namespace asio = boost::asio;
using asio::ip::tcp;
using boost::system::error_code;
using Clock = std::chrono::steady_clock;
using Bytes = std::shared_ptr<const std::string>;

constexpr int kFrameSlot = -1;
constexpr int kAnswerSlot = -2;
constexpr int kWelcomeSlot = -3;  // and below

std::size_t CountMessages(const std::string& messages) {
  std::size_t count = 0;
  for (std::size_t at = 0; at + IgtlHeader::kBytes <= messages.size(); ++count) {
    const auto* header = reinterpret_cast<const std::uint8_t*>(messages.data()) + at;
    at += IgtlHeader::kBytes +
          ReadIgtlHeader(std::span<const std::uint8_t, IgtlHeader::kBytes>(header, IgtlHeader::kBytes)).body_bytes;
  }
  return count;
}

}  // namespace

struct IgtlServer::State {
  struct Peer;

  State(const IgtlServerOptions& options, Calls the_calls)
      : calls(std::move(the_calls)),
        acceptor(context),
        timer(context),
        period(std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(1 / options.rate_hz))) {}

  void Listen(const IgtlServerOptions& options);
  void Accept();
  void WaitForFrame();
  void SendFrame();
  void Drop(const std::shared_ptr<Peer>& peer, const std::string& reason);
  template <typename Change>
  void Count(Change&& change) {
    const std::lock_guard lock(mutex);
    change(counts);
  }
  void CountDisconnected(const std::string& reason) {
    Count([&](IgtlCounts& c) {
      ++c.disconnected;
      const bool is_new = std::find(c.reasons.begin(), c.reasons.end(), reason) == c.reasons.end();
      if (is_new && c.reasons.size() < kMaxReasons) c.reasons.push_back(reason);
    });
  }

  Calls calls;
  asio::io_context context;
  tcp::acceptor acceptor;
  asio::steady_timer timer;
  Clock::duration period;
  std::vector<std::shared_ptr<Peer>> peers;
  PeerNumber last_number = 0;
  bool ending = false;
  std::mutex mutex;  // protects `counts`
  IgtlCounts counts;
  int port = 0;
  std::thread thread;
};

/// A connection. Its functions are called in the server's thread. Each operation on the socket keeps the object alive.
struct IgtlServer::State::Peer : std::enable_shared_from_this<Peer> {
  Peer(State& the_state, PeerNumber the_number, tcp::socket the_socket)
      : state(the_state), number(the_number), socket(std::move(the_socket)) {}

  /// Queues messages, in the place of those with the same slot.
  void Queue(int slot, const Bytes& messages) {
    const auto same = std::find_if(waiting.begin(), waiting.end(), [slot](const auto& w) { return w.first == slot; });
    if (same != waiting.end()) {
      same->second = messages;
    } else {
      waiting.emplace_back(slot, messages);
    }
    Write();
  }
  void Write() {
    if (writing || waiting.empty()) return;
    writing = waiting.front().second;
    waiting.pop_front();
    wrote_at = Clock::now();
    const auto progress = [self = shared_from_this()](const error_code& e, std::size_t) -> std::size_t {
      self->wrote_at = Clock::now();
      return e ? 0 : std::size_t{1} << 16;
    };
    asio::async_write(socket, asio::buffer(*writing), progress,
                      [self = shared_from_this()](const error_code& e, std::size_t) {
                        if (e) return self->state.Drop(self, "");
                        self->state.Count([&](IgtlCounts& c) { c.sent += CountMessages(*self->writing); });
                        self->writing.reset();
                        self->Write();
                      });
  }
  bool is_stuck() const { return writing && Clock::now() - wrote_at > std::chrono::duration<double>(kPatience_s); }
  void ReadHeader() {
    paused = budget == 0;
    if (paused) return;
    --budget;
    asio::async_read(socket, asio::buffer(head), [self = shared_from_this()](const error_code& e, std::size_t) {
      if (e) return self->state.Drop(self, "");
      self->Try([&] {
        self->header = ReadIgtlHeader(self->head);
        self->skips = !self->Admits();
        self->body.clear();
        self->left = self->header.body_bytes;
        self->ReadBody();
      });
    });
  }
  /// Returns whether the body may be read. Throws kerf::Error if the peer is to be disconnected.
  bool Admits() {
    const Calls& calls = state.calls;
    try {
      const std::size_t max = calls.max_bytes ? calls.max_bytes(header) : kMaxBodyBytes;
      if (header.body_bytes <= max) return true;
      throw Error(
          fmt::format("a message of type {} has {} bytes; the limit is {}", header.type, header.body_bytes, max));
    } catch (const Error& e) {
      if (!calls.refuse || header.body_bytes > kMaxSkippedBytes) throw;
      if (const Bytes answer = calls.refuse(e.what())) Queue(kAnswerSlot, answer);
    }
    return false;
  }
  /// Reads the body in pieces: it takes memory only as it arrives.
  void ReadBody() {
    constexpr std::uint64_t kPieceBytes = kMaxBodyBytes;
    const std::uint64_t piece = std::min(left, kPieceBytes);
    left -= piece;
    if (skips) body.clear();
    const std::size_t from = body.size();
    body.resize(from + static_cast<std::size_t>(piece));
    asio::async_read(socket, asio::buffer(body.data() + from, body.size() - from),
                     [self = shared_from_this()](const error_code& e, std::size_t) {
                       if (e) return self->state.Drop(self, "");
                       if (self->left > 0) return self->ReadBody();
                       self->TakeBody();
                     });
  }
  void TakeBody() {
    Try([&] {
      const Bytes answer = skips ? nullptr : state.calls.take(number, header, CheckIgtlBody(header, body));
      state.Count([](IgtlCounts& c) { ++c.received; });
      if (answer != nullptr) Queue(kAnswerSlot, answer);
      if (body.capacity() > kMaxBodyBytes) body = {};
      ReadHeader();
    });
  }
  template <typename Act>
  void Try(Act&& act) {
    try {
      act();
    } catch (const Error& e) {
      state.Drop(shared_from_this(), e.what());
    }
  }

  State& state;
  const PeerNumber number;
  tcp::socket socket;
  std::deque<std::pair<int, Bytes>> waiting;  // by slot
  Bytes writing;                              // null: nothing is being sent
  Clock::time_point wrote_at;
  int budget = kMessagesPerFrame;  // messages that it may still send until the next frame
  bool paused = false;             // it has used them up
  std::array<std::uint8_t, IgtlHeader::kBytes> head{};
  IgtlHeader header;
  std::vector<std::uint8_t> body;
  std::uint64_t left = 0;  // bytes of the body that are still to be read
  bool skips = false;      // the body is refused
};

void IgtlServer::State::Listen(const IgtlServerOptions& options) {
  error_code error;
  const asio::ip::address address = asio::ip::make_address(options.address, error);
  if (error) throw Error(fmt::format("'{}' is not a numeric address such as 127.0.0.1", options.address));
  const tcp::endpoint endpoint(address, static_cast<std::uint16_t>(options.port));
  acceptor.open(endpoint.protocol(), error);
  if (!error) acceptor.set_option(tcp::acceptor::reuse_address(true), error);
  if (!error) acceptor.bind(endpoint, error);
  if (!error) acceptor.listen(asio::socket_base::max_listen_connections, error);
  if (!error) port = acceptor.local_endpoint(error).port();
  if (error) {
    throw Error(
        fmt::format("OpenIGTLink: cannot listen on {}, port {}: {}", options.address, options.port, error.message()));
  }
}

void IgtlServer::State::Accept() {
  acceptor.async_accept([this](const error_code& error, tcp::socket socket) {
    if (ending) return;
    if (!error && peers.size() < kMaxPeers) {
      error_code ignored;
      socket.set_option(tcp::no_delay(true), ignored);
      const auto peer = std::make_shared<Peer>(*this, ++last_number, std::move(socket));
      peers.push_back(peer);
      Count([](IgtlCounts& c) { ++c.peers; });
      int slot = kWelcomeSlot;
      for (const Bytes& messages : calls.welcome()) peer->Queue(slot--, messages);
      peer->ReadHeader();
    } else if (!error) {
      CountDisconnected(fmt::format("more than {} peers wanted to connect", kMaxPeers));
    }
    Accept();
  });
}

void IgtlServer::State::WaitForFrame() {
  timer.expires_after(period);
  timer.async_wait([this](const error_code& error) {
    if (error || ending) return;
    SendFrame();
    WaitForFrame();
  });
}

void IgtlServer::State::SendFrame() {
  const std::vector<std::shared_ptr<Peer>> all = peers;
  if (all.empty()) return;
  const Bytes frame = calls.frame();
  for (const auto& peer : all) {
    if (peer->is_stuck()) {
      Drop(peer, fmt::format("a peer took nothing for {:g} s", kPatience_s));
      continue;
    }
    peer->budget = kMessagesPerFrame;
    if (peer->paused) peer->ReadHeader();
    if (frame == nullptr) continue;
    if (peer->writing) {
      Count([](IgtlCounts& c) { ++c.skipped; });
    } else {
      peer->Queue(kFrameSlot, frame);
    }
  }
}

void IgtlServer::State::Drop(const std::shared_ptr<Peer>& peer, const std::string& reason) {
  const auto at = std::find(peers.begin(), peers.end(), peer);
  if (at == peers.end()) return;  // a second operation of it has ended
  peers.erase(at);
  if (calls.gone) calls.gone(peer->number);
  if (!reason.empty()) CountDisconnected(reason);
  error_code ignored;
  peer->socket.close(ignored);
}

IgtlServer::IgtlServer(const IgtlServerOptions& options, Calls calls)
    : state_(std::make_unique<State>(options, std::move(calls))) {
  CheckParameters(options);
  state_->Listen(options);
  state_->Accept();
  state_->WaitForFrame();
  state_->thread = std::thread([state = state_.get()] { state->context.run(); });
}

IgtlServer::~IgtlServer() {
  asio::post(state_->context, [state = state_.get()] {
    state->ending = true;  // handlers that are waiting to be called already start nothing new
    error_code ignored;
    state->acceptor.close(ignored);
    state->timer.cancel();
    while (!state->peers.empty()) state->Drop(state->peers.back(), "");
  });
  state_->thread.join();
}

int IgtlServer::port() const {
  return state_->port;
}

void IgtlServer::Send(int slot, std::shared_ptr<const std::string> messages) {
  asio::post(state_->context, [state = state_.get(), slot, messages = std::move(messages)] {
    const std::vector<std::shared_ptr<State::Peer>> all = state->peers;
    for (const auto& peer : all) peer->Queue(slot, messages);
  });
}

void IgtlServer::WaitUntilSent(std::chrono::milliseconds max_wait) {
  for (const auto until = Clock::now() + max_wait; Clock::now() < until;) {
    std::promise<bool> sent;
    asio::post(state_->context, [&] {
      sent.set_value(std::all_of(state_->peers.begin(), state_->peers.end(),
                                 [](const auto& peer) { return !peer->writing && peer->waiting.empty(); }));
    });
    if (sent.get_future().get()) return;
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
}

IgtlCounts IgtlServer::counts() const {
  const std::lock_guard lock(state_->mutex);
  return state_->counts;
}

}  // namespace kerf
