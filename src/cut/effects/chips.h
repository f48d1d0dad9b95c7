// chips: chips that fly off the teeth, for display. This is the interface for other code.
#pragma once

#include <cstdint>
#include <vector>

#include "cut/effects/chips_flight.h"
#include "cut/effects/effect.h"
#include "kerf/describe.h"

namespace kerf {

struct ChipsParams {
  double size_mm = 0.15;
  double spread = 0.15;
  double life_s = 0.4;
  int max_chips = 4096;
  int chips_per_tick = 32;
  double drag = 1;
  Vec3 gravity_W_m_per_s2{0, 0, -9.81};
  std::uint64_t seed = 1;
};

template <typename V>
void Describe(ChipsParams& p, V&& visit) {
  visit("size_mm", p.size_mm, Range{0.02, 5},
        "diameter of a ball with a chip's volume; an assumption: half of what a tooth removes in one pass, 0.004 mm3");
  visit("spread", p.spread, Range{0, 1},
        "maximum random part of a chip's velocity, as a fraction of the rim's speed; an assumption");
  visit("life_s", p.life_s, Range{0.001, 60}, "lifetime of a chip");
  visit("max_chips", p.max_chips, Range{1, 1e6},
        "maximum number of chips in the air; a further one replaces the oldest");
  visit("chips_per_tick", p.chips_per_tick, Range{1, 1e4},
        "maximum number of chips thrown in one tick; further ones are dropped");
  visit("drag", p.drag, Range{0, 100}, "drag, relative to that of a ball in air; 0: none");
  visit("gravity_m_per_s2", p.gravity_W_m_per_s2, Range{-100, 100},
        "gravity, world frame; [0, 9.81, 0] for a patient lying on their back");
  visit("seed", p.seed, Range{0, 1e9}, "seed of the random numbers");
}

/// Chips in the air: the position, velocity and time at which each was thrown. Current positions are computed only on
/// request.
class ChipPool {
 public:
  /// Allocates.
  explicit ChipPool(const ChipsParams& params);

  /// Adds a chip that is thrown `delay_s` from now. If `max_chips` are in the air, the oldest is removed. Tick-safe.
  void Throw(const ChipMotion& start_F, double delay_s);
  /// Advances the time and removes the chips whose life has ended. Tick-safe.
  void Advance(double dt_s);

  bool empty() const { return count_ == 0; }
  std::size_t size() const { return count_; }
  /// Number of chips that were removed before the end of their life.
  std::uint64_t cut_short() const { return cut_short_; }
  std::size_t CalcMemoryBytes() const { return starts_.capacity() * sizeof(Start); }

  // ---- for drawing; not for the tick: about 4 us per chip
  struct Chip {
    Vec3 p_F_mm;
    Vec3 v_F_mm_per_s;
    double age_s;
  };
  /// Returns the state of the i-th chip, the oldest first.
  Chip CalcChip(std::size_t i) const;

 private:
  struct Start {
    float p_F_mm[3];
    float v_F_mm_per_s[3];
    double thrown_s;
  };
  ChipFlight flight_;
  double life_s_;
  std::vector<Start> starts_;  // ring buffer
  std::size_t first_ = 0, count_ = 0;
  double now_s_ = 0;
  std::uint64_t cut_short_ = 0;
};

/// Throws chips of bone off the edge. It adds no force.
class ChipsEffect final : public Effect {
 public:
  ChipsEffect(const ChipsParams& params, const EffectSetup& setup);

  void Solved(const EffectSolved& solved) override;
  void End(EffectEnd& end) override;
  void Reset() override { places_.clear(); }
  void Report(std::span<double> channels) const override;
  bool reads_teeth() const override { return false; }
  std::size_t CalcMemoryBytes() const override;

  const ChipsParams& params() const { return params_; }
  const ChipPool& pool() const { return pool_; }
  Vec3 p_WF_mm() const { return p_WF_mm_; }
  double chip_mm3() const { return chip_mm3_; }
  /// Removed volume = thrown + dropped + waiting; the waiting volume is kept until it is enough for a chip.
  double thrown_mm3() const { return static_cast<double>(thrown_) * chip_mm3_; }
  double dropped_mm3() const { return dropped_mm3_; }
  double waiting_mm3() const { return waiting_mm3_; }

 private:
  /// Point of the edge that cut.
  struct Place {
    double cumulative;  // sum of the cut at this point and at those before it
    int point;
    int exit_point = 0;  // point of the edge at which its chips fly off
  };
  void FindWhereChipsLeave();
  void ThrowOne(const Place& place, double delay_s);
  double Draw();  // random number between 0 and 1, both excluded

  ChipsParams params_;
  Vec3 p_WF_mm_;
  const ToolShape* shape_;
  double thickness_mm_;  // disc only
  double chip_mm3_;
  ChipPool pool_;
  std::vector<Place> places_;  // of the last substep of this tick that cut
  Pose X_FT_;
  double rpm_ = 0;
  DriveStep stroke_;  // of that substep; of a turning edge all 0
  int stride_ = 1;
  std::uint64_t random_state_;
  std::uint64_t thrown_ = 0;
  double dropped_mm3_ = 0;
  double waiting_mm3_ = 0;
};

}  // namespace kerf
