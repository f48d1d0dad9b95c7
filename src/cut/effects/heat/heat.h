// heat: temperature of the bone around the kerf.
#pragma once

#include <vector>

#include "cut/effects/effect.h"
#include "cut/effects/heat/heat_grid.h"

namespace kerf {

struct HeatParams {
  HeatGridParams grid;
  double share_into_bone = 0.1;  // fraction of the cutting power
};

/// Puts a fraction of the cutting power into the bone around the kerf, and computes temperatures and thermal dose.
class HeatEffect final : public Effect {
 public:
  HeatEffect(const HeatParams& params, const EffectSetup& setup);

  void Solved(const EffectSolved& solved) override;
  void End(EffectEnd& end) override;
  void BoneRestored() override { grid_.BoneRestored(); }
  void Report(std::span<double> channels) const override;
  std::size_t CalcMemoryBytes() const override;

  // ---- between ticks
  const HeatFigures& figures() const { return grid_.figures(); }
  /// Computes the heat balance, including heat that has been gathered but is not in the grid yet.
  HeatBalance CalcBalance() const;
  const HeatGrid& grid() const { return grid_; }
  const HeatParams& params() const { return params_; }
  Vec3 p_WF_mm() const { return p_WF_mm_; }
  /// Returns the temperature, C; NaN where there is no bone.
  double CalcTemperature(const Vec3& p_W) const { return grid_.CalcTemperature(p_W - p_WF_mm_); }
  double CalcDose(const Vec3& p_W) const { return grid_.CalcDose(p_W - p_WF_mm_); }

 private:
  /// Heat gathered at a point of the edge over several ticks.
  struct Gathered {
    double mJ = 0;
    Vec3 p_mJ{0};         // position times heat
    Vec3 e_F{0}, n_F{0};  // outward direction, and direction along the spindle
    Vec3 from_F{0};       // position at the start
  };
  void Flush(Gathered& point);
  void FlushAll();

  HeatParams params_;
  HeatGrid grid_;
  Vec3 p_WF_mm_;
  double wet_radius_mm_, wet_half_mm_;
  double wall_mm_;                  // distance from a disc's middle plane at which heat enters a wall; 0: a ball
  std::vector<Gathered> gathered_;  // by point of the edge
  bool any_gathered_ = false;
};

/// Temperatures and doses on a plane through the bone, for a picture. Allocates.
struct HeatSection {
  Vec3 p_W{0};                      // position of the first value
  Vec3 u_W{1, 0, 0}, v_W{0, 1, 0};  // unit length, perpendicular to each other
  double step_mm = 0;
  int columns = 0, rows = 0;  // along u, along v
  std::vector<float> C;       // row by row; NaN: no bone
  std::vector<float> cem43_min;
};
HeatSection CalcHeatSection(const HeatEffect& heat, const Vec3& p_W, const Vec3& u_W, const Vec3& v_W, double step_mm,
                            int columns, int rows);

}  // namespace kerf
