// heat: how warm cutting makes the bone around the kerf.
#pragma once

#include <vector>

#include "cut/effects/effect.h"
#include "cut/effects/heat/heat_grid.h"

namespace kerf {

struct HeatParams {
  HeatGridParams grid;
  double share_into_bone = 0.1;  // of the power of cutting
};

class HeatEffect final : public Effect {
 public:
  HeatEffect(const HeatParams& params, const EffectSetup& setup);

  void Solved(const EffectSolved& solved) override;
  void End(EffectEnd& end) override;
  void BoneCameBack() override { grid_.BoneCameBack(); }
  void Report(std::span<double> channels) const override;
  std::size_t CalcMemoryBytes() const override;

  // ---- between ticks
  const HeatFigures& figures() const { return grid_.figures(); }
  /// With what is gathered and not yet in the grid.
  HeatBalance CalcBalance() const;
  const HeatGrid& grid() const { return grid_; }
  const HeatParams& params() const { return params_; }
  Vec3 p_WF_mm() const { return p_WF_mm_; }
  /// C; NaN where there is no bone.
  double CalcTemperature(const Vec3& p_W) const { return grid_.CalcTemperature(p_W - p_WF_mm_); }
  double CalcDose(const Vec3& p_W) const { return grid_.CalcDose(p_W - p_WF_mm_); }

 private:
  /// Heat of a point of the edge over some ticks.
  struct Gathered {
    double mJ = 0;
    Vec3 p_mJ{0};         // place times heat
    Vec3 e_F{0}, n_F{0};  // outwards, and along the spindle
    Vec3 from_F{0};       // where it began
  };
  void Flush(Gathered& point);
  void FlushAll();

  HeatParams params_;
  HeatGrid grid_;
  Vec3 p_WF_mm_;
  double wet_radius_mm_, wet_half_mm_;
  double wall_mm_;                  // from a disc's middle plane to where the heat of a wall goes in; 0: a ball
  std::vector<Gathered> gathered_;  // by point of the edge
  bool any_gathered_ = false;
};

/// Temperatures and doses on a plane through the bone, for a picture. Allocates.
struct HeatSection {
  Vec3 p_W{0};                      // of the first value
  Vec3 u_W{1, 0, 0}, v_W{0, 1, 0};  // unit length, across each other
  double step_mm = 0;
  int columns = 0, rows = 0;  // along u and along v
  std::vector<float> C;       // by row; NaN: no bone
  std::vector<float> cem43_min;
};
HeatSection CalcHeatSection(const HeatEffect& heat, const Vec3& p_W, const Vec3& u_W, const Vec3& v_W, double step_mm,
                            int columns, int rows);

}  // namespace kerf
