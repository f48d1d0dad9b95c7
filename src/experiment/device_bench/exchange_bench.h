// Measurement of the time between a request to a device and its answer.
#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "base/core/percentiles.h"
#include "base/table/table.h"
#include "device/devices/driver.h"
#include "device/drivers/device_list.h"

namespace kerf {

struct ExchangeBenchOptions {
  int rounds = 5000;
  double rate_hz = 1000;
  bool realtime = false;                                                  // SCHED_FIFO, as in the loop
  std::function<void(const std::string& now, double fraction)> progress;  // may be empty
  const std::atomic<bool>* stop = nullptr;                                // ends it early if true; may be null
};

template <typename V>
void Describe(ExchangeBenchOptions& p, V&& visit) {
  visit("rounds", p.rounds, Range{10, 1e7}, "number of exchanges with each device");
  visit("rate_hz", p.rate_hz, Range{0, 10'000}, "rate of exchanges with a connected device; 0: as fast as it answers");
}

struct ExchangeTimes {
  std::string device;  // kind of device
  std::string link;    // "in process": a model, through memory; "libusb": a connected device; or another link
  double rate_hz = 0;  // 0: each round starts when the previous one ends
  std::uint64_t rounds = 0;
  std::uint64_t samples = 0;
  std::uint64_t no_answer = 0;  // rounds without an answer in time
  std::uint64_t bad = 0;
  std::uint64_t late = 0;  // rounds that began a whole period or more too late and were skipped
  Percentiles times;       // of all rounds
  std::uint64_t hash = 0;  // of all samples; reproducible in process
  std::string failure;     // reason for an early end; otherwise empty
};

/// Measures models of all kinds of USB devices, each held by a hand that moves in circles. Model time advances by 1 ms
/// per round. Throws Error if an option is out of range.
std::vector<ExchangeTimes> BenchModels(const ExchangeBenchOptions& options);
/// Opens and starts the device without commanding a force. If that fails, `failure` in the result gives the reason.
ExchangeTimes BenchDevice(UsbBus& bus, const FoundDevice& found, const DriverOptions& driver_options,
                          const ExchangeBenchOptions& options);

/// Describes the keys of a result in JSON.
const Columns<ExchangeTimes>& ExchangeColumns();
/// These format both kinds of results as one table: text for a terminal, Markdown, and JSON.
std::string FormatExchangeTable(const std::vector<ExchangeTimes>& results);
std::string FormatExchangeMarkdown(const std::vector<ExchangeTimes>& results);
std::string FormatExchangeJson(const std::vector<ExchangeTimes>& results);

}  // namespace kerf
