#include "cut/slab_sim/resistance.h"

#include <algorithm>
#include <cmath>

namespace kerf {
namespace {

double CalcLayerForce(const SlabProfile::Layer& layer, const SlabParams& params) {
  if (!(layer.E_MPa > 0)) return 0;
  return CalcPaperToothForce(params.saw, params.contact_share_of_pitch, layer.E_MPa, layer.nu);
}

}  // namespace

SlabResistance::SlabResistance(const SlabProfile& profile, const SlabParams& params)
    : linear_(params.reading == PaperReading::kCorrected), end_mm_(profile.end_mm) {
  if (linear_) {
    AddTable(profile, params);
  } else {
    AddStairs(profile, params);
  }
  pieces_.shrink_to_fit();
}

void SlabResistance::AddStairs(const SlabProfile& profile, const SlabParams& params) {
  // Depths at which the paper's arc gains a whole tooth: d acos(1 - h / (2 d)) = n pitch.
  const double d = params.saw.diameter_mm;
  std::vector<double> tops;
  for (const SlabProfile::Layer& layer : profile.layers) tops.push_back(layer.top_mm);
  std::vector<double> tooth_depths;
  const double max_teeth = CalcPaperTeeth(params.saw, d, PaperReading::kAsComputed);
  for (double n = 1; n <= max_teeth; ++n) {
    tooth_depths.push_back(2 * d * (1 - std::cos(n * params.saw.pitch_mm() / d)));
    if (tooth_depths.back() < end_mm_) tops.push_back(tooth_depths.back());
  }
  std::sort(tops.begin(), tops.end());
  tops.erase(std::unique(tops.begin(), tops.end()), tops.end());
  for (const double top : tops) {
    const SlabProfile::Layer* layer = profile.Find(top);
    if (layer == nullptr) continue;
    const auto n =
        static_cast<double>(std::upper_bound(tooth_depths.begin(), tooth_depths.end(), top) - tooth_depths.begin());
    pieces_.push_back({top, {n * n * n * CalcLayerForce(*layer, params), n, layer->E_MPa}});
  }
}

void SlabResistance::AddTable(const SlabProfile& profile, const SlabParams& params) {
  const double d = params.saw.diameter_mm;
  const double pitch = params.saw.pitch_mm();
  std::vector<double> tooth_force;
  for (const SlabProfile::Layer& layer : profile.layers) tooth_force.push_back(CalcLayerForce(layer, params));
  const auto count = static_cast<std::size_t>(std::ceil(end_mm_ / kTableStep_mm)) + 1;
  pieces_.reserve(count);
  for (std::size_t i = 0; i < count; ++i) {
    const double depth = std::min(static_cast<double>(i) * kTableStep_mm, end_mm_);
    SlabLoad load;
    double E_sum = 0;
    // The arc between two depths of the bone is the arc to the lower depth less the arc to the upper depth.
    for (std::size_t k = 0; k < profile.layers.size() && profile.layers[k].top_mm < depth; ++k) {
      const double bottom = k + 1 < profile.layers.size() ? profile.layers[k + 1].top_mm : end_mm_;
      if (tooth_force[k] == 0 || depth - bottom >= d) continue;
      const double teeth = (CalcTrueArc(depth - profile.layers[k].top_mm, d) - CalcTrueArc(depth - bottom, d)) / pitch;
      load.force_N += teeth * tooth_force[k];
      load.teeth += teeth;
      E_sum += teeth * profile.layers[k].E_MPa;
    }
    if (load.teeth > 0) load.E_MPa = E_sum / load.teeth;
    pieces_.push_back({depth, load});
  }
}

SlabLoad SlabResistance::At(double depth_mm) const {
  if (!(depth_mm >= 0 && depth_mm <= end_mm_) || pieces_.empty()) return {};
  if (linear_) {
    // The last step is shorter than the others.
    const std::size_t i = std::min(static_cast<std::size_t>(depth_mm / kTableStep_mm), pieces_.size() - 2);
    const double width = pieces_[i + 1].top_mm - pieces_[i].top_mm;
    const double t = width > 0 ? std::min(1.0, (depth_mm - pieces_[i].top_mm) / width) : 0;
    const SlabLoad& a = pieces_[i].load;
    const SlabLoad& b = pieces_[i + 1].load;
    return {a.force_N + t * (b.force_N - a.force_N), a.teeth + t * (b.teeth - a.teeth),
            b.E_MPa > 0 ? b.E_MPa : a.E_MPa};
  }
  const auto after = std::upper_bound(pieces_.begin(), pieces_.end(), depth_mm,
                                      [](double depth, const Piece& piece) { return depth < piece.top_mm; });
  return after == pieces_.begin() ? SlabLoad{} : std::prev(after)->load;
}

}  // namespace kerf
