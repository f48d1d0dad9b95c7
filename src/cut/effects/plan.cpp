#include "cut/effects/plan.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <span>

#include "cut/effects/own_effect.h"

namespace kerf {
namespace {

std::unique_ptr<Effect> MakeEffect(const EffectInfo& info, std::span<const EffectValue> values,
                                   const EffectSetup& setup) {
  return info.make_own != nullptr ? MakeOwnEffect(info, values, setup) : info.make(values, setup);
}

}  // namespace

EffectPlan::EffectPlan(const EffectChoices& choices, const EffectSetup& setup) : shape_(&setup.shape) {
  CheckEffects(choices);
  if (choices.empty()) return;  // avoids building the list of effects
  EffectSetup with_plan = setup;
  with_plan.plan = this;
  for (const EffectInfo* info : Effects()) {
    const EffectChoice* choice = FindChoice(choices, info->name);
    if (choice == nullptr) continue;
    if (info->tool == EffectTool::kInHand && setup.faces == nullptr) {
      left_out_.push_back(info);
      continue;
    }
    with_plan.files = choice->files();
    entries_.push_back(Entry{info, MakeEffect(*info, choice->values(), with_plan), channel_count_});
    Effect* effect = entries_.back().effect.get();
    channel_count_ += info->channels.size();
    const auto list = [&](EffectHook hook, std::vector<Called>& called) {
      if ((info->hooks & hook) != 0) called.push_back({effect, entries_.size() - 1});
    };
    list(kEffectBegin, begin_);
    list(kEffectHolds, holds_);
    list(kEffectEngage, engage_);
    list(kEffectSolved, solved_);
    list(kEffectEnd, end_);
  }
  for (const Called& called : solved_) reads_teeth_ = reads_teeth_ || called.effect->reads_teeth();
  if (reads_teeth_) teeth_.resize(setup.edge.size());
}

void EffectPlan::Solved(EffectSolved& solved) {
  solved.teeth = FindTeeth(solved.problem, solved.edge, solved.u);
  ForEach(solved_, [&](Effect& effect) { effect.Solved(solved); });
}

std::span<ToothLoad> EffectPlan::FindTeeth(const StepProblem& problem, const Edge& edge, const Twist& u) {
  if (!reads_teeth_) return {};
  const std::size_t count = problem.cutting.size();
  for (std::size_t i = 0; i < count; ++i) {
    const CuttingPoint& point = problem.cutting[i];
    const Edge::Contact& contact = edge.contacts()[i];
    const EdgePoint& place = shape_->edge[static_cast<std::size_t>(contact.point)];
    ToothLoad& load = teeth_[i];  // of an earlier step: each member is set
    const double speed = Dot(point.row, u), along_speed = Dot(point.along, u);
    load.e_T = point.FindOutwards(speed, along_speed);
    load.p_T = edge.Move(place.p_T) + glm::length(glm::dvec2(place.p_T)) * (load.e_T - edge.Turn(place.e_T));
    load.teeth = point.teeth;
    load.speed_mm_per_s = std::max(0.0, speed);
    const ToothMean mean = problem.MeanToothForce(point, speed, along_speed);
    load.thrust_N = point.teeth * mean.radial_N;
    load.thrust_on_way_N = point.teeth * problem.MeanThrustOnWay(point, speed, mean);
    load.cutting_N = problem.law.HasCutting() ? point.teeth * problem.MeanCuttingForce(point, speed, mean) : 0;
    load.cut = point.cut;
    load.region = contact.region;
    load.tangential_N = 0;
  }
  return std::span(teeth_).first(count);
}

const Effect* EffectPlan::Find(std::string_view name) const {
  for (const Entry& entry : entries_) {
    if (entry.info->name == name) return entry.effect.get();
  }
  return nullptr;
}
Effect* EffectPlan::Find(std::string_view name) {
  return const_cast<Effect*>(std::as_const(*this).Find(name));
}

std::vector<std::string> EffectPlan::ListChannels() const {
  std::vector<std::string> names;
  for (const Entry& entry : entries_) {
    for (const EffectChannel& channel : entry.info->channels) {
      names.push_back(std::string(entry.info->name) + "." + channel.name);
    }
  }
  return names;
}

void EffectPlan::Report(std::span<double> channels) const {
  for (const Entry& entry : entries_) {
    entry.effect->Report(channels.subspan(entry.first_channel, entry.info->channels.size()));
  }
}

EffectCapacity EffectPlan::capacity() const {
  EffectCapacity sum;
  for (const Entry& entry : entries_) {
    const EffectCapacity own = entry.effect->capacity();
    sum.solids += own.solids;
    sum.frictions += own.frictions;
  }
  return sum;
}

std::size_t EffectPlan::CalcMemoryBytes() const {
  std::size_t bytes = sizeof(*this) + entries_.capacity() * sizeof(Entry) + teeth_.capacity() * sizeof(ToothLoad);
  for (const Entry& entry : entries_) bytes += entry.effect->CalcMemoryBytes();
  return bytes;
}

}  // namespace kerf
