// heat: a fraction of the cutting power at each tooth,
//
//   P = share (F_t v_rim + F_n v_feed),   v_rim: of a stroke the mean of |ds/dt| over the step
//
// enters the bone around the kerf, is conducted there, and is carried off by blood and coolant (heat_grid.h).
#include "cut/effects/heat/heat.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/gtc/quaternion.hpp>
#include <glm/mat3x3.hpp>
#include <numbers>

#include "cut/effects/effects.h"
#include "cut/effects/parameters.h"

namespace kerf {
namespace {

constexpr double kWetMargin_mm = 1;  // extent of the coolant around the tool

}  // namespace

HeatEffect::HeatEffect(const HeatParams& params, const EffectSetup& setup)
    : params_(params),
      grid_(params.grid, setup.field),
      p_WF_mm_(setup.p_WF_mm),
      wet_radius_mm_(CalcReach(setup.tool) + kWetMargin_mm),
      wet_half_mm_((GetForm(setup.tool) == ToolForm::kRound ? CalcReach(setup.tool) : 0.5 * CalcCutWidth(setup.tool)) +
                   kWetMargin_mm),
      wall_mm_(IsBlade(setup.tool)
                   ? 0.5 * std::max(CalcCutWidth(setup.tool), setup.field.voxel_mm()) + 0.5 * params.grid.spacing_mm
                   : 0),
      gathered_(setup.edge.size()) {}

void HeatEffect::Solved(const EffectSolved& solved) {
  const double spindle_rad_per_s = 2 * std::numbers::pi / 60 * std::abs(solved.rpm);
  const double apart_mm = 0.5 * params_.grid.spacing_mm;
  const glm::dmat3 R_FT = glm::mat3_cast(solved.X_FT.R_AB);
  const auto to_F = [&](const Vec3& p_T) { return R_FT * p_T + solved.X_FT.p_AB; };
  for (std::size_t i = 0; i < solved.teeth.size(); ++i) {
    const ToothLoad& load = solved.teeth[i];
    const double rim_mm_per_s = solved.stroke != nullptr ? solved.stroke->speed_mm_per_s
                                                         : spindle_rad_per_s * glm::length(glm::dvec2(load.p_T));
    const double mW = load.tangential_N * rim_mm_per_s + load.thrust_N * load.speed_mm_per_s;
    const double mJ = params_.share_into_bone * mW * solved.time_s;
    if (!(mJ > 0)) continue;
    Gathered& point = gathered_[static_cast<std::size_t>(solved.edge.contacts()[i].point)];
    const Vec3 p_F = to_F(load.p_T);
    // The heat of several strokes is put in at its mean place.
    const Vec3 rest_F =
        solved.stroke != nullptr ? to_F(solved.edge.motion().Move(load.p_T, -solved.edge.slide_mm())) : p_F;
    if (point.mJ > 0 && glm::length(rest_F - point.from_F) > apart_mm) Flush(point);
    if (!(point.mJ > 0)) point.from_F = rest_F;
    point.mJ += mJ;
    point.p_mJ += mJ * p_F;
    point.e_F = R_FT * load.e_T;
    point.n_F = R_FT[2];
    any_gathered_ = true;
  }
}

void HeatEffect::Flush(Gathered& point) {
  const double H = params_.grid.spacing_mm;
  const Vec3 p_F = point.p_mJ / point.mJ;
  if (grid_.room() < 2) return;
  if (wall_mm_ > 0) {
    // Half of the heat goes into each wall of the kerf, one spacing behind the edge, because bone ahead of the edge is
    // about to be cut.
    const Vec3 back_F = p_F - H * point.e_F;
    grid_.Put(back_F + wall_mm_ * point.n_F, p_F, 0.5 * point.mJ);
    grid_.Put(back_F - wall_mm_ * point.n_F, p_F, 0.5 * point.mJ);
  } else {
    grid_.Put(p_F + 0.5 * H * point.e_F, p_F, point.mJ);
  }
  point.mJ = 0;
  point.p_mJ = Vec3(0);
}

void HeatEffect::FlushAll() {
  any_gathered_ = false;
  for (Gathered& point : gathered_) {
    if (!(point.mJ > 0)) continue;
    Flush(point);
    any_gathered_ = any_gathered_ || point.mJ > 0;
  }
}

void HeatEffect::End(EffectEnd& end) {
  if (any_gathered_ && (!grid_.awake() || end.dt_s > 0.25 * grid_.frame_s())) FlushAll();
  if (!grid_.awake()) return;
  HeatWet wet;
  if (end.rpm != 0) {
    wet = {end.X_FT.p_AB, end.X_FT.Vector({0, 0, 1}), wet_radius_mm_, wet_half_mm_};
  }
  const std::uint64_t frame = grid_.frames();
  grid_.Advance(end.dt_s, wet);
  if (any_gathered_ && grid_.frames() != frame) FlushAll();
}

void HeatEffect::Report(std::span<double> channels) const {
  const HeatFigures& f = grid_.figures();
  const double values[] = {f.hottest_C,   f.peak_C,        f.above_47_s,      f.cem43_min,
                           f.past_47_mm3, f.past_dose_mm3, f.full ? 1.0 : 0.0};
  std::copy(std::begin(values), std::end(values), channels.begin());
}

HeatBalance HeatEffect::CalcBalance() const {
  HeatBalance balance = grid_.CalcBalance();
  for (const Gathered& point : gathered_) {
    balance.put_in += point.mJ;
    balance.waiting += point.mJ;
  }
  return balance;
}

std::size_t HeatEffect::CalcMemoryBytes() const {
  return sizeof(*this) - sizeof(grid_) + grid_.CalcMemoryBytes() + gathered_.capacity() * sizeof(Gathered);
}

HeatSection CalcHeatSection(const HeatEffect& heat, const Vec3& p_W, const Vec3& u_W, const Vec3& v_W, double step_mm,
                            int columns, int rows) {
  HeatSection section{p_W, u_W, v_W, step_mm, columns, rows, {}, {}};
  section.C.reserve(static_cast<std::size_t>(columns) * static_cast<std::size_t>(rows));
  section.cem43_min.reserve(section.C.capacity());
  for (int row = 0; row < rows; ++row) {
    for (int column = 0; column < columns; ++column) {
      const Vec3 at_W = p_W + step_mm * (static_cast<double>(column) * u_W + static_cast<double>(row) * v_W);
      section.C.push_back(static_cast<float>(heat.CalcTemperature(at_W)));
      section.cem43_min.push_back(static_cast<float>(heat.CalcDose(at_W)));
    }
  }
  return section;
}

const EffectInfo& Heat() {
  static const EffectInfo kEffect{
      .name = "heat",
      .summary = "temperature of the bone around the kerf over time: conduction, blood and coolant",
      .source =
          "Pennes 1948; cortical bone from the IT'IS database, used for all bone; limits of Eriksson and Albrektsson "
          "1983, CEM43 of Sapareto and Dewey 1984; the fraction of heat that stays in the bone and both surface "
          "coefficients are assumptions",
      .reads = "forces of the teeth, spindle speed, motion, distances to the bone's surface",
      .writes = "only its channels",
      .state = "temperature, time above 47 C and dose of nodes near the kerf",
      .sleeps = "until the teeth cut, and once no node is 0.1 K warmer than the body",
      .needs = {"tangential_force"},
      .hooks = kEffectSolved | kEffectEnd,
      .parameters = ListEffectParameters<HeatParams>(),
      .channels = {{"hottest_C", "highest temperature of a node now"},
                   {"peak_C", "highest temperature of a node so far"},
                   {"above_47_s", "longest time of a node at 47 C or more"},
                   {"cem43_min", "largest thermal dose of a node, in minutes at 43 C"},
                   {"past_47_mm3", "volume of bone that was at 47 C or more for 1 min in total"},
                   {"past_dose_mm3", "volume of bone with a dose above 16 min, the dose of 47 C for 1 min"},
                   {"full", "1: max_MB is used up, and heat spreads to no further nodes"}},
      .make = [](std::span<const EffectValue> values, const EffectSetup& setup) -> std::unique_ptr<Effect> {
        auto params = ReadEffectParameters<HeatParams>(values);
        params.grid.irrigation_W_per_m2K = params.irrigation ? params.irrigation_W_per_m2K : 0;
        return std::make_unique<HeatEffect>(params, setup);
      }};
  return kEffect;
}

}  // namespace kerf
