// How long it takes to ask a device and to have its answer.
#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "device/devices/driver.h"
#include "device/drivers/device_list.h"

namespace kerf {

struct ExchangeBenchOptions {
  int rounds = 5000;      // 10 to 10,000,000
  double rate_hz = 1000;  // at which a device that is plugged in is asked; 0: as fast as it answers; at most 10,000
  bool realtime = false;  // SCHED_FIFO, as the loop has it
  std::function<void(const std::string& now, double fraction)> progress;  // none: not shown
  const std::atomic<bool>* stop = nullptr;                                // ends it early
};

struct ExchangeTimes {
  std::string device;  // the kind
  std::string way;     // "in process": a model, by way of memory; "libusb": what is plugged in; or another link
  double rate_hz = 0;  // 0: one round after the other
  std::uint64_t rounds = 0;
  std::uint64_t samples = 0;
  std::uint64_t no_answer = 0;  // in time
  std::uint64_t bad = 0;
  std::uint64_t late = 0;  // rounds that began a whole period or more after their time: skipped
  double p50_us = 0;       // nearest rank, of all rounds
  double p99_us = 0;
  double p999_us = 0;
  double max_us = 0;
  std::uint64_t hash = 0;  // of all samples; in process the same each time
  std::string failure;     // what ended it early; "" else
};

/// Models of all kinds of devices on USB, each in a hand that goes round; the model's time passes by 1 ms a round.
/// Throws Error when options are out of range.
std::vector<ExchangeTimes> BenchModels(const ExchangeBenchOptions& options);
/// The device is opened and started, and gets no force at all. Where it can't be, `failure` tells.
ExchangeTimes BenchDevice(UsbBus& bus, const FoundDevice& found, const DriverOptions& driver_options,
                          const ExchangeBenchOptions& options);

/// One table for both; text for people, Markdown, JSON.
std::string FormatExchangeTable(const std::vector<ExchangeTimes>& results);
std::string FormatExchangeMarkdown(const std::vector<ExchangeTimes>& results);
std::string FormatExchangeJson(const std::vector<ExchangeTimes>& results);

}  // namespace kerf
