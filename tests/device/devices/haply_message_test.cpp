// The JSON messages of Haply's service: complete, truncated and damaged.
#include "device/devices/haply/haply_message.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <glm/geometric.hpp>
#include <random>

#include "support/random_cases.h"

namespace kerf {
namespace {

using testing::HasSubstr;

constexpr const char* kMessage =
    R"({"inverse3": [{"device_id": "04BA", "state": {"cursor_position": {"x": 0.01, "y": -0.12, "z": 0.2}}},)"
    R"( {"device_id": "17C0", "state": {"cursor_position": {"x": 1, "y": 2, "z": 3}}}],)"
    R"( "wireless_verse_grip": [{"device_id": "61576", "state": {"orientation": {"x": 0.6, "y": 0, "z": 0, "w": 0.8},)"
    R"( "buttons": {"a": false, "b": true, "c": false}}}]})";

TEST(HaplyMessage, ValidMessageIsRead) {
  HaplyState state;
  ASSERT_EQ(ReadHaplyMessage(kMessage, "", state), HaplyReading::kOk);
  EXPECT_EQ(state.id, "04BA");
  EXPECT_LT(glm::length(state.p_H_mm - Vec3(10, -120, 200)), 1e-12);
  ASSERT_TRUE(state.R_H_grip);
  EXPECT_DOUBLE_EQ(state.R_H_grip->x, 0.6);
  EXPECT_EQ(state.buttons, 0b010u);
  ASSERT_EQ(ReadHaplyMessage(kMessage, "17C0", state), HaplyReading::kOk);
  EXPECT_LT(glm::length(state.p_H_mm - Vec3(1000, 2000, 3000)), 1e-9);
  EXPECT_EQ(ReadHaplyMessage(kMessage, "none", state), HaplyReading::kNoDevice);
  EXPECT_EQ(state.id, "17C0");
}

TEST(HaplyMessage, MalformedMessagesAreRefused) {
  HaplyState state;
  EXPECT_EQ(ReadHaplyMessage("", "", state), HaplyReading::kBad);
  EXPECT_EQ(ReadHaplyMessage("[]", "", state), HaplyReading::kBad);
  EXPECT_EQ(ReadHaplyMessage("{}", "", state), HaplyReading::kNoDevice);
  EXPECT_EQ(ReadHaplyMessage(R"({"inverse3": 3})", "", state), HaplyReading::kBad);
  EXPECT_EQ(ReadHaplyMessage(R"({"inverse3": []})", "", state), HaplyReading::kNoDevice);
  const auto with = [&state](const std::string& position, const std::string& more = "") {
    return ReadHaplyMessage(
        R"({"inverse3": [{"device_id": "a", "state": {"cursor_position": )" + position + "}}]" + more + "}", "", state);
  };
  EXPECT_EQ(with(R"({"x": 0, "y": 0, "z": 0})"), HaplyReading::kOk);
  EXPECT_EQ(with(R"({"x": 0, "y": 0})"), HaplyReading::kBad);
  EXPECT_EQ(with(R"({"x": 0, "y": 0, "z": null})"), HaplyReading::kBad);
  EXPECT_EQ(with(R"({"x": 0, "y": 0, "z": 11})"), HaplyReading::kBad);     // 11 m
  EXPECT_EQ(with(R"({"x": 0, "y": 0, "z": 1e999})"), HaplyReading::kBad);  // not a finite number
  const auto grip = [&](const std::string& orientation) {
    return with(R"({"x": 0, "y": 0, "z": 0})", R"(, "verse_grip": [{"state": {"orientation": )" + orientation + "}}]");
  };
  EXPECT_EQ(grip(R"({"w": 1, "x": 0, "y": 0, "z": 0})"), HaplyReading::kOk);
  EXPECT_EQ(grip(R"({"w": 2, "x": 0, "y": 0, "z": 0})"), HaplyReading::kBad);
  EXPECT_EQ(grip(R"({"w": 0, "x": 0, "y": 0, "z": 0})"), HaplyReading::kBad);
  EXPECT_EQ(grip(R"({"w": 1})"), HaplyReading::kBad);
}

TEST(HaplyMessage, DamagedOnesAreReadOrRefused) {
  std::mt19937_64 random(1);
  const std::string message = kMessage;
  int read = 0;
  const int cases = test::CountRandomCases();
  for (int i = 0; i < cases; ++i) {
    std::string text = message;
    for (std::uint64_t n = 1 + random() % 4; n > 0; --n) {
      const std::size_t at = random() % text.size();
      switch (random() % 3) {
        case 0:
          text[at] = static_cast<char>(random());
          break;
        case 1:
          text.erase(at, random() % 10);
          break;
        default:
          text.insert(at, text.substr(random() % text.size(), random() % 20));
      }
    }
    HaplyState state;
    if (ReadHaplyMessage(text, "", state) != HaplyReading::kOk) continue;
    ++read;
    ASSERT_LE(glm::length(state.p_H_mm), 2e4);
    ASSERT_TRUE(!state.R_H_grip || std::abs(glm::length(*state.R_H_grip) - 1) < 1e-9);
  }
  EXPECT_GT(read, cases / 100);  // not every damaged message is refused
}

TEST(HaplyMessage, ForceIsWritten) {
  EXPECT_EQ(
      WriteHaplyForce("04BA", {1, -2.5, 0}),
      R"({"inverse3":[{"commands":{"set_cursor_force":{"values":{"x":1.0,"y":-2.5,"z":0.0}}},"device_id":"04BA"}]})");
  EXPECT_THAT(WriteHaplyForce("a\"b\xff", Vec3{0}), HasSubstr("a\\\"b"));
}

TEST(HaplyMessage, FramesConvertBothWays) {
  const Vec3 v(1, 2, 3);
  EXPECT_EQ(FrameDToHaply(HaplyToFrameD(v)), v);
  EXPECT_EQ(HaplyToFrameD(Vec3(0, 0, 1)), Vec3(0, 1, 0));   // up
  EXPECT_EQ(HaplyToFrameD(Vec3(0, -1, 0)), Vec3(0, 0, 1));  // towards the user
  // A rotation is the same in both frames.
  const Quat turn = glm::normalize(Quat(0.3, 0.5, -0.7, 0.2));
  EXPECT_LT(glm::length(HaplyToFrameD(turn * v) - HaplyToFrameD(turn) * HaplyToFrameD(v)), 1e-12);
}

}  // namespace
}  // namespace kerf
