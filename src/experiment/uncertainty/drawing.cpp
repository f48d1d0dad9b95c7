#include "experiment/uncertainty/drawing.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>

#include "base/core/hash.h"

namespace kerf {
namespace {

// Streams of the materials; those of the law's parameters are their positions.
constexpr std::uint64_t kTissueStreams = 1000;
constexpr std::uint64_t kRegionStreams = 2000;
constexpr double kProbeSpeed_mm_per_s = 1000;

double ValueAt(double lower, double upper, double fraction) {
  return lower + fraction * (upper - lower);
}

/// Returns true if both give the same forces at all bites from 0.1 nm to 1 m.
bool HaveSameForces(const ToothForce& a, const ToothCut& cut_a, const ToothForce& b, const ToothCut& cut_b) {
  for (double bite_mm = 1e-7; bite_mm < 1e3; bite_mm *= 2) {
    if (a(bite_mm, cut_a) != b(bite_mm, cut_b)) return false;
    if (a.HasCutting() && a.Cutting(bite_mm, cut_a) != b.Cutting(bite_mm, cut_b)) return false;
  }
  return true;
}

/// Returns cuts of each region of the bone, in each direction against the osteons if that is known. Forces of laws are
/// linear in the tissues and the squared cosines, so that these stand for all cuts.
std::vector<ToothCut> MakeCuts(const MaterialTable& materials, const std::vector<int>& regions) {
  std::vector<OsteonShares> directions{{}};
  if (materials.osteon_direction()) directions = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  std::vector<ToothCut> cuts;
  for (const int id : regions) {
    const Region& region = materials.At(id);
    for (const OsteonShares& direction : directions) {
      cuts.push_back(MakeToothCut(region.E_MPa, region.E_MPa, region.tissue, kProbeSpeed_mm_per_s));
      cuts.back().osteon = direction;
    }
  }
  return cuts;
}

/// Returns true if the ends of a parameter's interval give the same forces in all these cuts.
bool HasNoEffect(const ForceLaw& law, const LawParameter& p, const Tool& tool, const std::vector<ToothCut>& cuts) {
  ForceLaw changed = law;
  changed.Set(p.key, p.interval_lower);
  const ToothForce lower = MakeToothForce(changed, tool);
  changed.Set(p.key, p.interval_upper);
  const ToothForce upper = MakeToothForce(changed, tool);
  return std::all_of(cuts.begin(), cuts.end(),
                     [&](const ToothCut& cut) { return HaveSameForces(lower, cut, upper, cut); });
}

/// Returns true if the law's forces in the region depend on E.
bool DependsOnE(const ToothForce& force, const Region& region) {
  return !HaveSameForces(force, MakeToothCut(region.E_lower_MPa, region.E_lower_MPa, region.tissue), force,
                         MakeToothCut(region.E_upper_MPa, region.E_upper_MPa, region.tissue));
}

void FindLawParameters(const ForceLaw& law, const Tool& tool, const std::vector<ToothCut>& cuts,
                       const std::vector<FitInterval>& fit, Drawing& drawing) {
  const std::vector<LawParameter>& parameters = law.info().parameters;
  std::vector<std::string> without_effect;
  for (std::size_t i = 0; i < parameters.size(); ++i) {
    LawParameter p = parameters[i];
    const double value = law.values()[i];
    if (const auto own = std::ranges::find(fit, p.key, &FitInterval::key); own != fit.end()) {
      p.default_value = value;
      p.interval_lower = own->lower;
      p.interval_upper = own->upper;
      p.interval_basis = own->basis.c_str();
    }
    if (!p.has_interval()) continue;
    if (value != p.default_value) {
      drawing.fixed.push_back({p.key, fmt::format("the scene sets {:g}; the default is {:g}", value, p.default_value)});
      continue;
    }
    if (HasNoEffect(law, p, tool, cuts)) {
      without_effect.emplace_back(p.key);
    } else {
      drawing.drawn.push_back({p.key, p.interval_lower, p.interval_upper, value, p.interval_basis, {}, i});
    }
  }
  if (!without_effect.empty()) {
    drawing.fixed.push_back({fmt::format("{}", fmt::join(without_effect, ", ")), "without effect in this bone"});
  }
}

/// Adds the region to the quantity of its stream.
void AddRegion(const Region& region, std::vector<DrawnQuantity>& drawn) {
  // Estimates of one tissue rest on the same few sources, so their errors are taken to have the same sign.
  const auto tissue = static_cast<std::uint64_t>(region.tissue);
  const std::uint64_t stream =
      region.estimate ? kTissueStreams + tissue : kRegionStreams + static_cast<std::uint64_t>(region.id);
  const double lower = region.E_lower_MPa / 1000;
  const double upper = region.E_upper_MPa / 1000;
  const double nominal = region.E_MPa / 1000;
  const auto found =
      std::find_if(drawn.begin(), drawn.end(), [&](const DrawnQuantity& q) { return q.stream == stream; });
  if (found == drawn.end()) {
    const std::string name = region.estimate ? fmt::format("E_GPa of estimated {} regions", ToString(region.tissue))
                                             : fmt::format("E_GPa of region {}", region.id);
    drawn.push_back({name, lower, upper, nominal, "the region table", {region.id}, stream});
    return;
  }
  found->lower = std::min(found->lower, lower);
  found->upper = std::max(found->upper, upper);
  if (found->nominal != nominal) found->nominal.reset();
  found->regions.push_back(region.id);
}

void FindRegions(const Scene& scene, const MaterialTable& materials, const std::vector<int>& regions,
                 const std::vector<int>& ct_regions, Drawing& drawing) {
  if (scene.material.kind == MaterialKind::kUniform) {
    drawing.fixed.push_back({"E_GPa", "the scene sets one E for the whole bone ([material] kind = \"uniform\")"});
    return;
  }
  const ToothForce force = MakeToothForce(scene.force, MakeTool(scene));
  std::vector<int> by_ct;
  std::vector<int> not_read;
  for (const int id : regions) {
    const Region& region = materials.At(id);
    if (!region.has_interval()) continue;
    if (std::find(ct_regions.begin(), ct_regions.end(), id) != ct_regions.end()) {
      by_ct.push_back(id);
    } else if (!DependsOnE(force, region)) {
      not_read.push_back(id);
    } else {
      AddRegion(region, drawing.drawn);
    }
  }
  const auto fix = [&](const std::vector<int>& ids, const std::string& why) {
    if (ids.empty()) return;
    drawing.fixed.push_back(
        {fmt::format("E_GPa of region{} {}", ids.size() > 1 ? "s" : "", fmt::join(ids, ", ")), why});
  };
  fix(by_ct, "E comes from the CT ([material] kind = \"ct\"), for which no interval is stated");
  fix(not_read, fmt::format("the law {} does not depend on E", scene.force.name()));
}

}  // namespace

Drawing FindDrawing(const Scene& scene, const Bone& bone, const std::vector<int>& ct_regions,
                    const std::vector<FitInterval>& fit) {
  const MaterialTable& materials = bone.materials();
  std::vector<int> regions;
  for (const auto& [id, volume_mm3] : bone.CalcRegionVolumes()) {
    if (materials.Contains(id)) regions.push_back(id);
  }
  Drawing drawing;
  FindLawParameters(scene.force, MakeTool(scene), MakeCuts(materials, regions), fit, drawing);
  FindRegions(scene, materials, regions, ct_regions, drawing);
  return drawing;
}

double DrawFraction(std::uint64_t seed, int sample, std::uint64_t stream) {
  const std::uint64_t mixed = MixHash(MixHash(MixHash(seed) + static_cast<std::uint64_t>(sample)) + stream);
  return static_cast<double>(mixed >> 11) * 0x1p-53;
}

std::vector<double> DrawFractions(const Drawing& drawing, std::uint64_t seed, int sample) {
  std::vector<double> fractions;
  for (const DrawnQuantity& q : drawing.drawn) fractions.push_back(DrawFraction(seed, sample, q.stream));
  return fractions;
}

ForceLaw ApplyToLaw(const Drawing& drawing, const std::vector<double>& fractions, const ForceLaw& law) {
  ForceLaw drawn = law;
  for (std::size_t i = 0; i < drawing.drawn.size(); ++i) {
    const DrawnQuantity& q = drawing.drawn[i];
    if (q.regions.empty()) drawn.Set(q.name, ValueAt(q.lower, q.upper, fractions[i]));
  }
  return drawn;
}

MaterialTable ApplyToMaterials(const Drawing& drawing, const std::vector<double>& fractions,
                               const MaterialTable& materials) {
  std::map<int, double> fraction_of_region;
  for (std::size_t i = 0; i < drawing.drawn.size(); ++i) {
    for (const int id : drawing.drawn[i].regions) fraction_of_region[id] = fractions[i];
  }
  MaterialTable drawn;
  for (const auto& [id, region] : materials.regions()) {
    Region changed = region;
    const auto found = fraction_of_region.find(id);
    if (found != fraction_of_region.end()) {
      changed.E_MPa = ValueAt(region.E_lower_MPa, region.E_upper_MPa, found->second);
    }
    drawn.Add(std::move(changed));
  }
  if (materials.osteon_direction()) drawn.SetOsteonDirection(*materials.osteon_direction());
  return drawn;
}

}  // namespace kerf
