// chips: the volume that a tick removes flies off as balls of one size.
//
//   number = volume removed / volume of a chip; the remainder is kept for the next tick.
//   velocity = velocity of the rim, w x p, or of the stroke, plus a random part of at most `spread` times its
//   magnitude.
//
// A tick only records position, velocity and time of each throw. All chips have the same lifetime, so they are removed
// in the order in which they were thrown, and a tick does not move them. Positions are computed on request
// (chips_flight.h), so the flight does not depend on the length of the tick.
#include "cut/effects/chips.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "base/core/hash.h"
#include "cut/effects/effects.h"
#include "cut/effects/parameters.h"

namespace kerf {
namespace {

double CalcBallVolume(double diameter_mm) {
  return std::numbers::pi / 6 * diameter_mm * diameter_mm * diameter_mm;
}

}  // namespace

ChipPool::ChipPool(const ChipsParams& params)
    : flight_(params.size_mm, params.drag, 1000.0 * params.gravity_W_m_per_s2),
      life_s_(params.life_s),
      starts_(static_cast<std::size_t>(params.max_chips)) {}

void ChipPool::Throw(const ChipMotion& start_F, double delay_s) {
  if (count_ == starts_.size()) {
    first_ = (first_ + 1) % starts_.size();
    --count_;
    ++cut_short_;
  }
  Start& start = starts_[(first_ + count_) % starts_.size()];
  for (int axis = 0; axis < 3; ++axis) {
    start.p_F_mm[axis] = static_cast<float>(start_F.p_mm[axis]);
    start.v_F_mm_per_s[axis] = static_cast<float>(start_F.v_mm_per_s[axis]);
  }
  start.thrown_s = now_s_ + delay_s;
  ++count_;
}

void ChipPool::Advance(double dt_s) {
  now_s_ += dt_s;
  while (count_ > 0 && now_s_ - starts_[first_].thrown_s >= life_s_) {
    first_ = (first_ + 1) % starts_.size();
    --count_;
  }
}

ChipPool::Chip ChipPool::CalcChip(std::size_t i) const {
  const Start& start = starts_[(first_ + i) % starts_.size()];
  const double age_s = now_s_ - start.thrown_s;
  ChipMotion motion;
  for (int axis = 0; axis < 3; ++axis) {
    motion.p_mm[axis] = static_cast<double>(start.p_F_mm[axis]);
    motion.v_mm_per_s[axis] = static_cast<double>(start.v_F_mm_per_s[axis]);
  }
  motion = flight_.CalcMotion(motion, age_s);
  return {motion.p_mm, motion.v_mm_per_s, age_s};
}

ChipsEffect::ChipsEffect(const ChipsParams& params, const EffectSetup& setup)
    : params_(params),
      p_WF_mm_(setup.p_WF_mm),
      shape_(&setup.shape),
      thickness_mm_(CalcThickness(setup.tool)),
      chip_mm3_(CalcBallVolume(params.size_mm)),
      pool_(params),
      random_state_(MixHash(params.seed)) {
  places_.reserve(setup.shape.edge.size());
}

double ChipsEffect::Draw() {
  return (static_cast<double>(MixHash(random_state_++) >> 11) + 0.5) * 0x1p-53;
}

void ChipsEffect::Solved(const EffectSolved& solved) {
  const auto& cutting = solved.problem.cutting;
  if (solved.rpm == 0 || cutting.empty()) return;
  places_.clear();
  double sum = 0;
  for (std::size_t i = 0; i < cutting.size(); ++i) {
    sum += cutting[i].teeth * std::max(0.0, Dot(cutting[i].row, solved.u));
    places_.push_back(Place{sum, solved.edge.contacts()[i].point});
  }
  if (!(sum > 0)) places_.clear();
  X_FT_ = solved.X_FT_next;
  rpm_ = solved.rpm;
  stroke_ = solved.stroke != nullptr ? *solved.stroke : DriveStep{};
  stride_ = solved.edge.stride();
}

/// Chips stay between the teeth until the disc's rim leaves the bone, at the end of the engaged arc in the direction of
/// rotation. A ball, or a rim that is entirely in bone, loses them where it cuts.
void ChipsEffect::FindWhereChipsLeave() {
  const std::size_t count = places_.size();
  for (Place& place : places_) place.exit_point = place.point;
  if (shape_->edge_form != EdgeForm::kRing) return;
  const auto size = static_cast<int>(shape_->edge.size());
  // Returns true if place i and the next in the list are neighbours on the rim.
  const auto up_from = [&](std::size_t i) { return i + 1 < count ? i + 1 : 0; };
  const auto down_from = [&](std::size_t i) { return i > 0 ? i - 1 : count - 1; };
  const auto joined = [&](std::size_t i) {
    const int next = places_[i].point + stride_ < size ? places_[i].point + stride_ : 0;
    return places_[up_from(i)].point == next;
  };
  // Points are in the order of a positive rotation.
  const bool up = rpm_ > 0;
  const auto after = [&](std::size_t i) { return up ? up_from(i) : down_from(i); };
  const auto before = [&](std::size_t i) { return up ? down_from(i) : up_from(i); };
  const auto goes_on = [&](std::size_t i) { return joined(up ? i : after(i)); };
  std::size_t end = 0;
  while (end < count && goes_on(end)) ++end;
  if (end == count) return;
  std::size_t i = end;
  for (std::size_t n = 1; n < count; ++n) {
    i = before(i);
    if (goes_on(i)) places_[i].exit_point = places_[after(i)].exit_point;
  }
}

void ChipsEffect::ThrowOne(const Place& place, double delay_s) {
  Vec3 p_T = shape_->edge[static_cast<std::size_t>(place.exit_point)].p_T;
  const double spindle_rad_per_s = 2 * std::numbers::pi / 60 * rpm_;
  Vec3 v_T = spindle_rad_per_s * Vec3(-p_T.y, p_T.x, 0);
  if (stroke_.speed_mm_per_s > 0) {
    // Each way is as likely as the part of the step in which the edge moved so.
    const bool forwards = 2 * Draw() < 1 + stroke_.velocity_mm_per_s / stroke_.speed_mm_per_s;
    p_T = shape_->motion.Move(p_T, stroke_.middle_mm);
    v_T = shape_->motion.CalcVelocity(p_T, forwards ? stroke_.speed_mm_per_s : -stroke_.speed_mm_per_s);
  }
  // A random point in a ball.
  const double z = 2 * Draw() - 1;
  const double phi = 2 * std::numbers::pi * Draw();
  const double r = params_.spread * glm::length(v_T) * std::cbrt(Draw());
  const double across = std::sqrt(1 - z * z);
  v_T += r * Vec3(across * std::cos(phi), across * std::sin(phi), z);
  p_T.z += thickness_mm_ * (Draw() - 0.5);
  pool_.Throw({X_FT_.Point(p_T), X_FT_.Vector(v_T)}, delay_s);
  ++thrown_;
}

void ChipsEffect::End(EffectEnd& end) {
  const bool removed = end.removed_mm3 > 0;
  if (!removed && pool_.empty()) return;
  if (removed) waiting_mm3_ += end.removed_mm3;
  if (!places_.empty() && waiting_mm3_ >= chip_mm3_) {
    const double number = std::floor(waiting_mm3_ / chip_mm3_);
    const int chips = static_cast<int>(std::min(number, static_cast<double>(params_.chips_per_tick)));
    dropped_mm3_ += (number - chips) * chip_mm3_;
    waiting_mm3_ = std::max(0.0, waiting_mm3_ - number * chip_mm3_);
    FindWhereChipsLeave();
    const double sum = places_.back().cumulative;
    for (int i = 0; i < chips; ++i) {
      const double at = sum * Draw();
      auto place = std::upper_bound(places_.begin(), places_.end(), at,
                                    [](double value, const Place& p) { return value < p.cumulative; });
      if (place == places_.end()) --place;
      ThrowOne(*place, end.dt_s * (i + 0.5) / chips);
    }
  }
  places_.clear();
  pool_.Advance(end.dt_s);
}

void ChipsEffect::Report(std::span<double> channels) const {
  channels[0] = static_cast<double>(pool_.size());
  channels[1] = thrown_mm3();
  channels[2] = dropped_mm3_;
  channels[3] = static_cast<double>(pool_.cut_short());
}

std::size_t ChipsEffect::CalcMemoryBytes() const {
  return sizeof(*this) + pool_.CalcMemoryBytes() + places_.capacity() * sizeof(Place);
}

const EffectInfo& Chips() {
  static const EffectInfo kEffect{
      .name = "chips",
      .summary = "chips that fly off the teeth, for display only; their volume is the removed volume",
      .source =
          "conservation of volume; drag of a ball after Schiller and Naumann 1933; size, spread and where chips leave "
          "the teeth are assumptions",
      .reads = "volume removed, teeth, their place and motion, spindle speed",
      .writes = "only its channels",
      .state = "where and when each chip in the air was thrown",
      .sleeps = "while nothing is cut and no chip is in the air",
      .hooks = kEffectSolved | kEffectEnd,
      .parameters = ListEffectParameters<ChipsParams>(),
      .channels = {{"chips", "chips in the air"},
                   {"emitted_mm3", "volume of the chips thrown so far"},
                   {"dropped_mm3", "volume of the chips dropped because of chips_per_tick"},
                   {"cut_short", "chips that disappeared early because max_chips were in the air"}},
      .make = [](std::span<const EffectValue> values, const EffectSetup& setup) -> std::unique_ptr<Effect> {
        return std::make_unique<ChipsEffect>(ReadEffectParameters<ChipsParams>(values), setup);
      }};
  return kEffect;
}

}  // namespace kerf
