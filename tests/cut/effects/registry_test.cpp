// Tests that every effect provides the required information and that invalid choices of effects are refused.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <set>
#include <string>

#include "kerf/effects.h"
#include "kerf/error.h"
#include "support/message_of.h"

namespace kerf {
namespace {

using ::testing::HasSubstr;

std::string RefusalOf(const EffectChoices& choices) {
  return test::MessageOf([&] { CheckEffects(choices); });
}

TEST(EffectRegistry, EachEffectIsFullyDescribed) {
  std::set<std::string> names;
  for (const EffectInfo* info : Effects()) {
    SCOPED_TRACE(info->name);
    EXPECT_TRUE(names.insert(info->name).second);
    EXPECT_EQ(FindEffect(info->name), info);
    for (const char* text : {info->summary, info->source, info->reads, info->writes, info->state, info->sleeps}) {
      ASSERT_NE(text, nullptr);
      EXPECT_GT(std::string(text).size(), 3u);
    }
    EXPECT_NE(info->hooks, 0u);
    EXPECT_NE(info->make, nullptr);
    for (const EffectParameter& p : info->parameters) {
      SCOPED_TRACE(p.key);
      EXPECT_GT(std::string(p.meaning).size(), 3u);
      if (const auto* number = std::get_if<double>(&p.default_value)) {
        EXPECT_LT(p.lower, p.upper);
        EXPECT_GE(*number, p.lower);
        EXPECT_LE(*number, p.upper);
      }
    }
    for (const EffectChannel& c : info->channels) EXPECT_GT(std::string(c.meaning).size(), 3u);
    // Effects that this one needs are called before it.
    for (const char* needed : info->needs) EXPECT_TRUE(names.contains(needed)) << needed;
  }
}

TEST(EffectRegistry, InvalidChoicesAreRefusedByName) {
  EXPECT_THROW(EffectChoice("kerf_frictoin"), Error);
  EffectChoices choices;
  EXPECT_EQ(RefusalOf(choices), "");
  SetEffect(choices, "kerf_friction", "coefficient", 3);
  EXPECT_THAT(RefusalOf(choices), HasSubstr("the effect kerf_friction: coefficient = 3 is above"));
  SetEffect(choices, "kerf_friction", "coefficient", 0.3);
  EXPECT_EQ(RefusalOf(choices), "");
  EXPECT_EQ(choices.size(), 1u);
  EXPECT_EQ(FindChoice(choices, "kerf_friction")->GetNumber("coefficient"), 0.3);
  EXPECT_THROW(SetEffect(choices, "kerf_friction", "coefficient", EffectValue(true)), Error);
  EXPECT_THROW(SetEffect(choices, "kerf_friction", "no_such_key", 1), Error);
  SetEffect(choices, "chips", "max_chips", 10.5);
  EXPECT_EQ(RefusalOf(choices), "the effect chips: max_chips = 10.5 is not a whole number");
  RemoveEffect(choices, "chips");
  choices.emplace_back("kerf_friction");
  EXPECT_THAT(RefusalOf(choices), HasSubstr("listed twice"));
  RemoveEffect(choices, "kerf_friction");
  EXPECT_TRUE(choices.empty());
}

}  // namespace
}  // namespace kerf
