#include "experiment/device_bench/exchange_bench.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <chrono>
#include <cmath>
#include <memory>
#include <nlohmann/json.hpp>
#include <numbers>
#include <thread>

#include "base/core/hash.h"
#include "base/realtime/realtime.h"
#include "device/devices/hand.h"
#include "device/devices/profiles.h"
#include "device/emulation/falcon_model.h"
#include "device/emulation/model_bus.h"
#include "device/emulation/scripted_hand.h"
#include "device/emulation/spacemouse_model.h"
#include "device/emulation/wooden_model.h"
#include "kerf/error.h"

namespace kerf {
namespace {

constexpr int kUncounted = 10;  // initial rounds that are not counted, because a driver may reject the first samples

using Clock = std::chrono::steady_clock;

void Mix(std::uint64_t& hash, std::uint64_t word) {
  hash = MixHash(hash ^ word);
}

void Mix(std::uint64_t& hash, const DriverSample& sample) {
  const Vec3& p = sample.X_DH.p_AB;
  for (const double x : {p.x, p.y, p.z}) Mix(hash, std::bit_cast<std::uint64_t>(x));
  for (const double x : sample.deflection) Mix(hash, std::bit_cast<std::uint64_t>(x));
  Mix(hash, sample.buttons | std::uint64_t{sample.homed} << 32);
}

/// Exchanges data until all rounds are done, `before_round` returns false, or the device is disconnected.
void Measure(DeviceDriver& driver, const ExchangeBenchOptions& options,
             const std::function<bool(int round, DriverCommand& command)>& before_round, ExchangeTimes& times) {
  std::vector<double> took_us;
  took_us.reserve(static_cast<std::size_t>(options.rounds));
  for (int i = -kUncounted; i < options.rounds; ++i) {
    DriverCommand command;
    if (!before_round(i, command)) break;
    DriverSample sample;
    if (i < 0) {
      driver.Exchange(command, sample);
      continue;
    }
    const auto begin = Clock::now();
    const RoundEnd end = driver.Exchange(command, sample);
    took_us.push_back(std::chrono::duration<double, std::micro>(Clock::now() - begin).count());
    ++times.rounds;
    if (end == RoundEnd::kSample) {
      ++times.samples;
      Mix(times.hash, sample);
    } else if (end == RoundEnd::kNoAnswer) {
      ++times.no_answer;
    } else if (end == RoundEnd::kBadAnswer) {
      ++times.bad;
    } else {
      times.failure = "the device was unplugged";
      break;
    }
  }
  if (took_us.empty()) return;
  std::sort(took_us.begin(), took_us.end());
  const auto percentile = [&](double fraction) {
    const auto rank = static_cast<std::size_t>(std::ceil(fraction * static_cast<double>(took_us.size())));
    return took_us[std::clamp<std::size_t>(rank, 1, took_us.size()) - 1];
  };
  times.p50_us = percentile(0.5);
  times.p99_us = percentile(0.99);
  times.p999_us = percentile(0.999);
  times.max_us = took_us.back();
}

bool GoOn(const ExchangeBenchOptions& options, const std::string& now, int round) {
  constexpr int kShowEvery = 64;
  if (options.progress && round >= 0 && round % kShowEvery == 0) {
    options.progress(now, static_cast<double>(round) / static_cast<double>(options.rounds));
  }
  return options.stop == nullptr || !*options.stop;
}

/// Returns a rotating force of about a tenth of the peak, so that the whole protocol is exercised.
Vec3 CalcTestForce(const DeviceDriver& driver, int round) {
  if (!driver.traits().makes_force) return Vec3{0};
  const double angle = 2 * std::numbers::pi * round / 1000;
  return 0.1 * driver.profile().peak_force_N * Vec3(std::cos(angle), std::sin(angle), 0.5);
}

struct ModelCase {
  std::string device;
  std::unique_ptr<ScriptedHand> hand;
  std::unique_ptr<UsbModel> model;
  std::function<void(const ScriptedHand&)> follow;  // called before each round
};

ModelCase MakeModel(const std::string& device) {
  ModelCase model;
  model.device = device;
  ScriptedHandOptions options;
  options.path = ScriptedPath::kCircle;
  model.hand = std::make_unique<ScriptedHand>(FindDeviceProfile(device == "spacemouse" ? "falcon" : device),
                                              FindHandModel("H4"), options);
  model.hand->Begin();
  if (device == "falcon") {
    FalconModelOptions falcon;
    falcon.firmware_is_there = true;
    falcon.homed = true;
    model.model = std::make_unique<FalconModel>(*model.hand, falcon);
  } else if (device == "wooden") {
    model.model = std::make_unique<WoodenModel>(*model.hand);
  } else if (device == "spacemouse") {
    auto mouse = std::make_unique<SpaceMouseEmulation>();
    model.follow = [cap = mouse.get()](const ScriptedHand& hand) {
      constexpr double kRawPerMm = 15;
      const Vec3 p_D_mm = hand.handle().p_AB;
      cap->Push({static_cast<int>(kRawPerMm * p_D_mm.x), 0, static_cast<int>(-kRawPerMm * p_D_mm.y), 0, 0, 0});
    };
    model.model = std::move(mouse);
  }
  return model;
}

constexpr const char* kNoForce = "no force is sent to connected devices";

}  // namespace

std::vector<ExchangeTimes> BenchModels(const ExchangeBenchOptions& options) {
  CheckParameters(options);
  RealtimeGrants grants;
  RequestPriority(options.realtime ? 80 : 0, grants);
  std::vector<ExchangeTimes> results;
  for (const KnownDevice& known : KnownDevices()) {
    if (known.numbers.empty()) continue;
    const ModelCase model = MakeModel(known.name);
    ModelBus bus;
    bus.PlugIn(*model.model);
    ExchangeTimes times;
    times.device = known.name;
    times.link = "in process";
    try {
      const std::unique_ptr<DeviceDriver> driver = OpenDriver(bus, known.name, {});
      driver->Start({});
      Measure(
          *driver, options,
          [&](int round, DriverCommand& command) {
            constexpr double kRound_s = 1e-3;
            bus.Advance(kRound_s);
            // A SpaceMouse has no mechanism that could move the hand.
            if (model.follow) {
              model.hand->Move(kRound_s, Vec3{0}, Vec3{0});
              model.follow(*model.hand);
            }
            command.f_D_N = CalcTestForce(*driver, round);
            command.engaged = true;
            return GoOn(options, known.name + " in process", round);
          },
          times);
      driver->Stop();
    } catch (const Error& error) {
      times.failure = error.what();
    }
    results.push_back(std::move(times));
  }
  return results;
}

ExchangeTimes BenchDevice(UsbBus& bus, const FoundDevice& found, const DriverOptions& driver_options,
                          const ExchangeBenchOptions& options) {
  CheckParameters(options);
  RealtimeGrants grants;
  RequestPriority(options.realtime ? 80 : 0, grants);
  ExchangeTimes times;
  times.device = found.kind->name;
  times.link = found.usb.vendor != 0 ? "libusb" : found.kind->link;
  try {
    const std::unique_ptr<DeviceDriver> driver = OpenDriver(bus, found.choice, driver_options);
    driver->Start({});
    times.rate_hz = std::min(options.rate_hz, driver->traits().rate_hz);
    const std::chrono::nanoseconds period(
        times.rate_hz > 0 ? static_cast<std::int64_t>(std::lround(1e9 / times.rate_hz)) : 0);
    auto next = Clock::now();
    Measure(
        *driver, options,
        [&](int round, DriverCommand&) {
          if (period.count() > 0) {
            next += period;
            const auto now = Clock::now();
            if (now >= next + period) {
              const auto behind = (now - next) / period;
              times.late += static_cast<std::uint64_t>(behind);
              next += behind * period;
            }
            std::this_thread::sleep_until(next);
          }
          return GoOn(options, times.device + " by " + times.link, round);
        },
        times);
    driver->Stop();
  } catch (const Error& error) {
    times.failure = error.what();
  }
  return times;
}

std::string FormatExchangeTable(const std::vector<ExchangeTimes>& results) {
  std::string text = fmt::format("{:<11} {:<11} {:>8} {:>9} {:>9} {:>6} {:>6} {:>9} {:>9} {:>9} {:>9}  {}\n", "device",
                                 "link", "rate Hz", "exchanges", "no answer", "bad", "late", "p50 us", "p99 us",
                                 "p99.9 us", "max us", "hash of samples");
  for (const ExchangeTimes& t : results) {
    text += fmt::format("{:<11} {:<11} {:>8} {:>9} {:>9} {:>6} {:>6} {:>9.2f} {:>9.2f} {:>9.2f} {:>9.2f}  {:016x}\n",
                        t.device, t.link, t.rate_hz > 0 ? fmt::format("{:g}", t.rate_hz) : "free", t.rounds,
                        t.no_answer, t.bad, t.late, t.p50_us, t.p99_us, t.p999_us, t.max_us, t.hash);
    if (!t.failure.empty()) text += fmt::format("            {}\n", t.failure);
  }
  text += fmt::format("in-process models receive a rotating force; {}\n", kNoForce);
  return text;
}

std::string FormatExchangeMarkdown(const std::vector<ExchangeTimes>& results) {
  std::string text =
      "| device | link | rate (Hz) | exchanges | no answer | bad | p50 (us) | p99 (us) | p99.9 (us) | max (us) |\n"
      "| --- | --- | --- | --- | --- | --- | --- | --- | --- | --- |\n";
  for (const ExchangeTimes& t : results) {
    text += fmt::format("| {} | {} | {} | {} | {} | {} | {:.2f} | {:.2f} | {:.2f} | {:.2f} |\n", t.device, t.link,
                        t.rate_hz > 0 ? fmt::format("{:g}", t.rate_hz) : "free", t.rounds, t.no_answer, t.bad, t.p50_us,
                        t.p99_us, t.p999_us, t.max_us);
  }
  return text;
}

std::string FormatExchangeJson(const std::vector<ExchangeTimes>& results) {
  nlohmann::ordered_json json = {{"schema", 1}, {"exchanges", nlohmann::ordered_json::array()}};
  for (const ExchangeTimes& t : results) {
    json["exchanges"].push_back({{"device", t.device},
                                 {"way", t.link},
                                 {"rate_hz", t.rate_hz},
                                 {"exchanges", t.rounds},
                                 {"samples", t.samples},
                                 {"no_answer", t.no_answer},
                                 {"bad", t.bad},
                                 {"late", t.late},
                                 {"p50_us", t.p50_us},
                                 {"p99_us", t.p99_us},
                                 {"p999_us", t.p999_us},
                                 {"max_us", t.max_us},
                                 {"samples_hash", fmt::format("{:016x}", t.hash)},
                                 {"failure", t.failure}});
  }
  return json.dump(2) + "\n";
}

}  // namespace kerf
