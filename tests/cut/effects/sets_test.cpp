// Any set of effects: an effect that a scene does not name is absent, and effects that only observe do not influence
// the others.
#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdio>
#include <map>
#include <numbers>
#include <random>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "base/core/hash.h"
#include "base/core/heap_guard.h"
#include "cut/effects/plan.h"
#include "cut/hand_sim/internals.h"
#include "kerf/coupled.h"
#include "kerf/error.h"
#include "kerf/simulation.h"
#include "support/cuts.h"

namespace kerf {
namespace {

using test::DiscPose;

constexpr double kSetsVoxel_mm = 0.25;
constexpr int kSetsTicks = 400;

/// Returns true if the effect may push, turn or stop the tool. Effects called only after a step or a tick cannot.
bool Moves(const EffectInfo& info) {
  return (info.hooks & (kEffectBegin | kEffectHolds | kEffectEngage)) != 0;
}
/// Returns true if the hand may feel the effect: it moves the tool, or it pushes the hand.
bool IsFelt(const EffectInfo& info) {
  return Moves(info) || (info.hooks & kEffectPush) != 0;
}

/// Makes a block with a canal slightly below the end of the cut, for the effects that need a canal.
const Bone& MakeSetsBlock() {
  static const Bone kBlock = [] {
    SolidField field;
    field.value = [](const Vec3& p) { return test::BoxDistance(p, {8, 2, 4}); };
    field.classify = ClassifyByDistance(field.value);
    field.region = [](const Vec3& p) { return std::hypot(p.y, p.z + 1) < 0.8 ? 2 : 1; };
    MaterialTable table;
    table.Add({1, "cortex", Tissue::kCortical, 19300, 0.28, true, "test"});
    table.Add({2, "canal", Tissue::kCanal, 100, 0.4, true, "test"});
    return MakeBone(field, Box3{{-8, -2, -4}, {8, 2, 4}}.Grown(6 * kSetsVoxel_mm), {kSetsVoxel_mm, kSetsVoxel_mm, {}},
                    table);
  }();
  return kBlock;
}

/// Pose of a handle that moves down into the block at 10 mm/s, along it with a sideways offset, and out again: through
/// air, on the teeth, on the flats, and through air again.
Pose HandlePose(int tick) {
  const double t = static_cast<double>(tick) / kSetsTicks;
  const double deep_mm = 4 * std::clamp(std::min(t, 1 - t) * 4, 0.0, 1.0);
  const double aside_mm = 0.4 * std::sin(2 * std::numbers::pi * t);
  Pose X_WH = DiscPose({}, {10 * (t - 0.5), aside_mm, 4 + 11 + 1 - deep_mm});
  X_WH.R_AB = X_WH.R_AB * glm::angleAxis(0.02 * std::sin(2 * std::numbers::pi * t), Vec3(1, 0, 0));
  return X_WH;
}

/// All results of a run.
struct Outcome {
  std::uint64_t bone = 0;
  std::uint64_t motion = 0;                       // hash of the tool's motion and of the removal, over all ticks
  std::uint64_t force = 0;                        // hash of the force on the hand
  std::map<std::string, std::uint64_t> channels;  // by effect, hash over all ticks
  std::size_t plan_bytes = 0;
  double removed_mm3 = 0;
};

void Mix(std::uint64_t& hash, double value) {
  hash = MixHash(hash ^ std::bit_cast<std::uint64_t>(value));
}
void Mix(std::uint64_t& hash, const Vec3& v) {
  for (int axis = 0; axis < 3; ++axis) Mix(hash, v[axis]);
}

Outcome RunWith(const EffectChoices& choices) {
  CoupledParams params;
  params.tool = DiscSaw{};
  params.coupling.stiffness_N_per_mm = 20;
  params.effects = choices;
  CoupledSimulation simulation(MakeSetsBlock(), params, HandlePose(0));
  const EffectPlan& plan = EffectsOf(std::as_const(simulation));
  std::vector<double> channels(plan.channel_count());
  Outcome run;
  for (int tick = 1; tick <= kSetsTicks; ++tick) {
    CoupledOutput out;
    {
      const HeapGuard guard;
      out = simulation.Tick({.X_WH = HandlePose(tick)});
      plan.Report(channels);
      simulation.ClearChanged();
    }
    Mix(run.motion, out.X_WT.p_AB);
    Mix(run.motion, Vec3(out.X_WT.R_AB.x, out.X_WT.R_AB.y, out.X_WT.R_AB.z));
    Mix(run.motion, out.cut_mJ);
    Mix(run.motion, out.friction_mJ);
    Mix(run.force, out.f_H_W_N);
    Mix(run.force, out.tau_H_W_Nmm);
    EXPECT_TRUE(std::isfinite(glm::length(out.f_H_W_N)) && std::isfinite(glm::length(out.X_WT.p_AB))) << tick;
    run.removed_mm3 += out.removed_mm3;
    for (const EffectPlan::Entry& entry : plan.entries()) {
      for (std::size_t i = 0; i < entry.info->channels.size(); ++i) {
        Mix(run.channels[entry.info->name], channels[entry.first_channel + i]);
      }
    }
  }
  run.bone = simulation.UpdateBone().CalcHash();
  run.plan_bytes = plan.CalcMemoryBytes();
  return run;
}

/// Returns the named effects and all that they need, directly or indirectly, in the registry's order.
EffectChoices ChooseWithNeeded(std::set<std::string> names) {
  EffectChoices choices;
  for (auto info = Effects().rbegin(); info != Effects().rend(); ++info) {
    if (!names.contains((*info)->name)) continue;
    names.insert((*info)->needs.begin(), (*info)->needs.end());
    choices.emplace(choices.begin(), (*info)->name);
  }
  return choices;
}

/// Returns the effects that can be made with their default parameters on this block.
const std::vector<const EffectInfo*>& Usable() {
  static const std::vector<const EffectInfo*> kUsable = [] {
    std::vector<const EffectInfo*> usable;
    for (const EffectInfo* info : Effects()) {
      try {
        CoupledParams params;
        params.effects = ChooseWithNeeded({info->name});
        const CoupledSimulation simulation(MakeSetsBlock(), params, HandlePose(0));
        usable.push_back(info);
      } catch (const Error& e) {
        std::printf("%s has no defaults that fit a block: %s\n", info->name, e.what());
      }
    }
    return usable;
  }();
  return kUsable;
}

std::string NameSet(const EffectChoices& choices) {
  std::string text;
  for (const EffectChoice& choice : choices) text += std::string(text.empty() ? "" : " ") + choice.name();
  return text.empty() ? "none" : text;
}

/// Returns the results for a set, which are computed once.
const Outcome& OutcomeOf(const EffectChoices& choices) {
  static std::map<std::string, Outcome> runs;
  const auto found = runs.find(NameSet(choices));
  if (found != runs.end()) return found->second;
  return runs.emplace(NameSet(choices), RunWith(choices)).first->second;
}

/// Expects the same bone and motion as with only those effects of the set that move the tool, and the same force on the
/// hand as with only those that the hand can feel. Each effect's channels must be the same as with only the effects
/// that move the tool and those that it needs.
void ExpectOnlyDeclaredInfluences(const EffectChoices& choices) {
  SCOPED_TRACE(NameSet(choices));
  const Outcome& all = OutcomeOf(choices);
  std::set<std::string> moving;
  std::set<std::string> felt;
  for (const EffectChoice& choice : choices) {
    if (Moves(choice.info())) moving.insert(choice.name());
    if (IsFelt(choice.info())) felt.insert(choice.name());
  }
  const Outcome& moved = OutcomeOf(ChooseWithNeeded(moving));
  EXPECT_EQ(all.bone, moved.bone);
  EXPECT_EQ(all.motion, moved.motion);
  EXPECT_EQ(all.force, OutcomeOf(ChooseWithNeeded(felt)).force);
  for (const EffectChoice& choice : choices) {
    std::set<std::string> with = moving;
    with.insert(choice.name());
    const Outcome& own = OutcomeOf(ChooseWithNeeded(with));
    const auto reported = all.channels.find(choice.name());
    if (reported != all.channels.end()) {
      EXPECT_EQ(reported->second, own.channels.at(choice.name())) << choice.name();
    }
  }
}

TEST(EffectSets, TheRunCoversAirTeethAndFlats) {
  const Outcome& plain = OutcomeOf({});
  EXPECT_GT(plain.removed_mm3, 1);
  EXPECT_NE(plain.bone, MakeSetsBlock().CalcHash());
  // The disc is offset sideways in its kerf, so it rubs; otherwise friction would have no effect on this motion.
  EXPECT_NE(OutcomeOf(ChooseWithNeeded({"kerf_friction"})).motion, plain.motion);
}

TEST(EffectSets, UnnamedEffectsAreAbsent) {
  const Outcome& plain = OutcomeOf({});
  EXPECT_EQ(plain.plan_bytes, sizeof(EffectPlan));
  CoupledParams params;
  params.effects.clear();
  CoupledSimulation simulation(MakeSetsBlock(), params, HandlePose(0));
  const EffectPlan& plan = EffectsOf(std::as_const(simulation));
  EXPECT_TRUE(plan.entries().empty());
  EXPECT_TRUE(plan.left_out().empty());
  EXPECT_EQ(plan.channel_count(), 0u);
  EXPECT_EQ(plan.capacity().solids + plan.capacity().frictions, 0u);
  EXPECT_FALSE(plan.wants_steps());
  for (const EffectInfo* info : Effects()) EXPECT_EQ(plan.Find(info->name), nullptr);
}

TEST(EffectSets, EachChangesOnlyWhatItDeclares) {
  const Outcome& plain = OutcomeOf({});
  for (const EffectInfo* info : Usable()) {
    SCOPED_TRACE(info->name);
    const EffectChoices choices = ChooseWithNeeded({info->name});
    const Outcome& with = OutcomeOf(choices);
    EXPECT_GT(with.plan_bytes, plain.plan_bytes);
    if ((info->hooks & kEffectEngage) != 0) {
      EXPECT_NE(std::string(info->writes).find("force"), std::string::npos);
    }
    if ((info->hooks & kEffectBegin) != 0) {
      EXPECT_NE(std::string(info->writes).find("speed"), std::string::npos);
    }
    ExpectOnlyDeclaredInfluences(choices);
  }
}

TEST(EffectSets, PairsDoNotInterfere) {
  const auto& usable = Usable();
  for (std::size_t a = 0; a < usable.size(); ++a) {
    for (std::size_t b = a + 1; b < usable.size(); ++b) {
      ExpectOnlyDeclaredInfluences(ChooseWithNeeded({usable[a]->name, usable[b]->name}));
    }
  }
}

TEST(EffectSets, LargerSetsDoNotInterfere) {
  std::mt19937 dice(20261120);
  std::set<std::string> every;
  for (const EffectInfo* info : Usable()) every.insert(info->name);
  ExpectOnlyDeclaredInfluences(ChooseWithNeeded(every));
  for (int n = 0; n < 20; ++n) {
    std::set<std::string> names;
    for (const std::string& name : every) {
      if (dice() % 2 == 0) names.insert(name);
    }
    ExpectOnlyDeclaredInfluences(ChooseWithNeeded(names));
  }
}

// Effects are called in the registry's order, not in the scene's.
TEST(EffectSets, TheOrderInTheSceneDoesNotMatter) {
  std::set<std::string> every;
  for (const EffectInfo* info : Usable()) every.insert(info->name);
  EffectChoices choices = ChooseWithNeeded(every);
  const Outcome& forwards = OutcomeOf(choices);
  std::reverse(choices.begin(), choices.end());
  const Outcome backwards = RunWith(choices);
  EXPECT_EQ(backwards.bone, forwards.bone);
  EXPECT_EQ(backwards.motion, forwards.motion);
  EXPECT_EQ(backwards.force, forwards.force);
  EXPECT_EQ(backwards.channels, forwards.channels);
}

// No effect moves a tool on a path. Effects that need a hand are left out and listed; the others are used.
TEST(EffectSets, NoneChangesTheCutOnAPath) {
  const auto run = [](const EffectChoices& choices) {
    SimulationParams params;
    params.effects = choices;
    Simulation simulation(MakeSetsBlock(), params, HandlePose(0));
    const EffectPlan& plan = EffectsOf(std::as_const(simulation));
    EXPECT_EQ(plan.entries().size() + plan.left_out().size(), choices.size());
    for (const EffectInfo* info : plan.left_out()) EXPECT_EQ(info->tool, EffectTool::kInHand) << info->name;
    std::uint64_t force = 0;
    for (int tick = 1; tick <= kSetsTicks; ++tick) {
      const HeapGuard guard;
      Mix(force, simulation.Tick({HandlePose(tick)}).f_T_W_N);
    }
    return std::pair{simulation.UpdateBone().CalcHash(), force};
  };
  const auto plain = run({});
  std::set<std::string> unfelt;
  for (const EffectInfo* info : Usable()) {
    SCOPED_TRACE(info->name);
    const EffectChoices choices = ChooseWithNeeded({info->name});
    if (std::any_of(choices.begin(), choices.end(), [](const EffectChoice& c) { return IsFelt(c.info()); })) continue;
    unfelt.insert(info->name);
    EXPECT_EQ(run(choices), plain);
  }
  EXPECT_EQ(run(ChooseWithNeeded(unfelt)), plain);
}

}  // namespace
}  // namespace kerf
