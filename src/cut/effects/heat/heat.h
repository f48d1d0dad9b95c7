// heat: temperature of the bone around the kerf.
#pragma once

#include <vector>

#include "cut/effects/effect.h"
#include "cut/effects/heat/heat_grid.h"
#include "kerf/describe.h"

namespace kerf {

struct HeatParams {
  HeatGridParams grid;
  double share_into_bone = 0.1;
  bool irrigation = false;
  double irrigation_W_per_m2K = 2000;
};

template <typename V>
void Describe(HeatParams& p, V&& visit) {
  visit("share_into_bone", p.share_into_bone, Range{0, 1},
        "fraction of the cutting power that stays in the walls of the kerf; chips and tool take the rest. An "
        "assumption: no value was found");
  HeatGridParams& grid = p.grid;
  visit("voxel_mm", grid.spacing_mm, Range{0.05, 2}, "distance between nodes");
  visit("max_MB", grid.max_MB, Range{0.1, 4096},
        "memory for nodes; when it is used up, heat spreads to no further nodes");
  visit("conductivity_W_per_mK", grid.conductivity_W_per_mK, Range{0.1, 5},
        "thermal conductivity of bone; measured: 0.16 to 4.89");
  visit("density_kg_per_m3", grid.density_kg_per_m3, Range{500, 3000}, "of bone");
  visit("heat_capacity_J_per_kgK", grid.heat_capacity_J_per_kgK, Range{500, 5000}, "of bone");
  visit("perfusion_mL_per_min_kg", grid.perfusion_mL_per_min_kg, Range{0, 1000},
        "blood flow through bone; 0: none, as in a specimen");
  visit("body_C", grid.body_C, Range{0, 45}, "initial temperature of bone, and temperature of blood");
  visit("air_W_per_m2K", grid.air_W_per_m2K, Range{0, 1000},
        "heat transfer from bare surfaces to air, which is assumed to be as warm as the body; an assumption");
  visit("irrigation", p.irrigation, "coolant runs over surfaces within 1 mm of the turning tool");
  visit("irrigation_W_per_m2K", p.irrigation_W_per_m2K, Range{0, 100000},
        "heat transfer from bare surfaces to coolant; an assumption");
  visit("coolant_C", grid.coolant_C, Range{0, 45}, "temperature of the coolant; room temperature, an assumption");
  visit("water_mg_per_mm3", grid.water_mg_per_mm3, Range{0, 1},
        "water in bone, which boils off at 100 C; a fifth of the volume, an assumption; 0: none");
}

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
    Vec3 from_F{0};       // position at the start, in the middle of the stroke
  };
  void Flush(Gathered& point);
  void FlushAll();

  HeatParams params_;
  HeatGrid grid_;
  Vec3 p_WF_mm_;
  double wet_radius_mm_, wet_half_mm_;
  double wall_mm_;                  // distance from a blade's middle plane at which heat enters a wall; 0: a ball
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
