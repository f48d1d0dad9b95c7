// Tests of the benchmark of device exchanges. They check counts and hashes, not times.
#include "experiment/device_bench/exchange_bench.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "device/emulation/falcon_model.h"
#include "device/emulation/model_bus.h"
#include "kerf/error.h"

namespace kerf {
namespace {

using testing::HasSubstr;

TEST(ExchangeBench, ModelsAnswerEveryRoundReproducibly) {
  ExchangeBenchOptions options;
  options.rounds = 500;
  const std::vector<ExchangeTimes> first = BenchModels(options);
  const std::vector<ExchangeTimes> second = BenchModels(options);
  ASSERT_EQ(first.size(), 3U);
  for (std::size_t i = 0; i < first.size(); ++i) {
    EXPECT_EQ(first[i].failure, "");
    EXPECT_EQ(first[i].rounds, 500U);
    EXPECT_EQ(first[i].samples, 500U) << first[i].device;
    EXPECT_EQ(first[i].bad, 0U);
    EXPECT_EQ(first[i].no_answer, 0U);
    EXPECT_EQ(first[i].hash, second[i].hash);
    EXPECT_LE(first[i].times.p50_us, first[i].times.p99_us);
    EXPECT_LE(first[i].times.p99_us, first[i].times.p999_us);
    EXPECT_LE(first[i].times.p999_us, first[i].times.max_us);
    EXPECT_GT(first[i].times.p50_us, 0);
  }
  options.rounds = 501;
  EXPECT_NE(BenchModels(options)[0].hash, first[0].hash);
}

/// The device is a model on an in-process bus.
TEST(ExchangeBench, ConnectedDeviceReceivesNoForce) {
  PrescribedMechanism held;
  FalconModelOptions falcon_options;
  falcon_options.firmware_is_there = true;
  falcon_options.homed = true;
  FalconModel falcon(held, falcon_options);
  ModelBus bus;
  bus.PlugIn(falcon);
  ExchangeBenchOptions options;
  options.rounds = 50;
  options.rate_hz = 0;
  const FoundDevice found = FindUsbDevices(bus).at(0);
  const ExchangeTimes times = BenchDevice(bus, found, {}, options);
  EXPECT_EQ(times.failure, "");
  EXPECT_EQ(times.samples, 50U);
  EXPECT_EQ(held.f_D_N(), Vec3(0));
  EXPECT_EQ(falcon.last_command().motors, (std::array<int, 3>{}));
  // A device that can no longer be opened is reported as a failure, without an exception.
  bus.SetProblem(UsbProblem::kBusy);
  EXPECT_THAT(BenchDevice(bus, found, {}, options).failure, HasSubstr("can't be opened"));
}

TEST(ExchangeBench, StopsOnRequest) {
  std::atomic<bool> stop{true};
  ExchangeBenchOptions options;
  options.stop = &stop;
  for (const ExchangeTimes& times : BenchModels(options)) EXPECT_EQ(times.rounds, 0U);
}

TEST(ExchangeBench, ReportsAllFigures) {
  ExchangeTimes times;
  times.device = "falcon";
  times.link = "libusb";
  times.rate_hz = 1000;
  times.rounds = 77;
  times.times.p999_us = 12.5;
  times.hash = 0xabc;
  times.failure = "pulled";
  const auto json = nlohmann::json::parse(FormatExchangeJson({times}));
  EXPECT_EQ(json["schema"], 1);
  EXPECT_EQ(json["exchanges"][0]["p999_us"], 12.5);
  EXPECT_EQ(json["exchanges"][0]["exchanges"], 77);
  EXPECT_EQ(json["exchanges"][0]["samples_hash"], "0000000000000abc");
  EXPECT_THAT(FormatExchangeTable({times}), HasSubstr("pulled"));
  EXPECT_THAT(FormatExchangeMarkdown({times}), HasSubstr("| falcon | libusb | 1000 | 77 |"));
}

TEST(ExchangeBench, RefusesOptionsOutOfRange) {
  ExchangeBenchOptions options;
  options.rounds = 9;
  EXPECT_THROW(BenchModels(options), Error);
  options.rounds = 10;
  options.rate_hz = 20'000;
  EXPECT_THROW(BenchModels(options), Error);
}

}  // namespace
}  // namespace kerf
