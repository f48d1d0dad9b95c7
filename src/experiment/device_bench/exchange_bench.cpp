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
#include "base/table/run_info.h"
#include "base/table/table_json.h"
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
  times.times = CalcPercentiles(took_us);
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

/// Makes the table for a terminal and for Markdown.
TextTable MakeExchangeTable(const std::vector<ExchangeTimes>& results) {
  TextTable table({"device", "link", "rate (Hz)", "exchanges", "no answer", "bad", "late", "p50 (us)", "p99 (us)",
                   "p99.9 (us)", "max (us)", "hash of samples"});
  const auto us = [](double time_us) { return fmt::format("{:.2f}", time_us); };
  for (const ExchangeTimes& t : results) {
    table.Add({t.device, t.link, t.rate_hz > 0 ? fmt::format("{:g}", t.rate_hz) : "free", t.rounds, t.no_answer, t.bad,
               t.late, us(t.times.p50_us), us(t.times.p99_us), us(t.times.p999_us), us(t.times.max_us),
               fmt::format("{:016x}", t.hash)});
  }
  return table;
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

const Columns<ExchangeTimes>& ExchangeColumns() {
  static const Columns<ExchangeTimes> kColumns{
      {"device", "{}", "kind of device", &ExchangeTimes::device},
      {"way", "{}", "`in process`: a model, through memory; `libusb`: a connected device; or another link",
       &ExchangeTimes::link},
      {"rate_hz", "{}", "rate of the exchanges; 0: each begins when the previous one ends", &ExchangeTimes::rate_hz},
      {"exchanges", "{}", "number of exchanges", &ExchangeTimes::rounds},
      {"samples", "{}", "exchanges that returned a sample", &ExchangeTimes::samples},
      {"no_answer", "{}", "exchanges without an answer in time", &ExchangeTimes::no_answer},
      {"bad", "{}", "exchanges with an invalid answer", &ExchangeTimes::bad},
      {"late", "{}", "exchanges that were skipped because they began a period or more too late", &ExchangeTimes::late},
      {"p50_us", "{}", "percentiles of the duration of an exchange", [](const auto& t) { return t.times.p50_us; }},
      {"p99_us", "{}", "percentiles of the duration of an exchange", [](const auto& t) { return t.times.p99_us; }},
      {"p999_us", "{}", "percentiles of the duration of an exchange", [](const auto& t) { return t.times.p999_us; }},
      {"max_us", "{}", "percentiles of the duration of an exchange", [](const auto& t) { return t.times.max_us; }},
      {"samples_hash", "{}", "hash of all samples; reproducible in process",
       [](const auto& t) { return fmt::format("{:016x}", t.hash); }},
      {"failure", "{}", "reason for an early end; otherwise empty", &ExchangeTimes::failure}};
  return kColumns;
}

std::string FormatExchangeTable(const std::vector<ExchangeTimes>& results) {
  std::string text = MakeExchangeTable(results).FormatTerminal();
  for (const ExchangeTimes& t : results) {
    if (!t.failure.empty()) text += fmt::format("{}: {}\n", t.device, t.failure);
  }
  return text + fmt::format("in-process models receive a rotating force; {}\n", kNoForce);
}

std::string FormatExchangeMarkdown(const std::vector<ExchangeTimes>& results) {
  return MakeExchangeTable(results).FormatMarkdown();
}

std::string FormatExchangeJson(const std::vector<ExchangeTimes>& results) {
  nlohmann::ordered_json json = {{"schema", 1}, {"exchanges", RowsJson(ExchangeColumns(), results)}};
  json.update(RunJson(ReadRunInfo()));
  return DumpJson(json);
}

}  // namespace kerf
