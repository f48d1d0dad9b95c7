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

double ValueAt(double lower, double upper, double fraction) {
  return lower + fraction * (upper - lower);
}

void FindLawParameters(const ForceLaw& law, Drawing& drawing) {
  const std::vector<LawParameter>& parameters = law.info().parameters;
  for (std::size_t i = 0; i < parameters.size(); ++i) {
    const LawParameter& p = parameters[i];
    if (!p.has_interval()) continue;
    const double value = law.values()[i];
    if (value != p.default_value) {
      drawing.fixed.push_back({p.key, fmt::format("the scene sets {:g}; the default is {:g}", value, p.default_value)});
      continue;
    }
    drawing.drawn.push_back({p.key, p.interval_lower, p.interval_upper, value, p.interval_basis, {}, i});
  }
}

/// Adds the region to the quantity of its stream.
void AddRegion(const Region& region, std::vector<DrawnQuantity>& drawn) {
  // Estimates of one tissue come from the same few measured rows, so they err in the same direction.
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

void FindRegions(const Scene& scene, const Bone& bone, const std::vector<int>& ct_regions, Drawing& drawing) {
  if (scene.material.kind == MaterialKind::kUniform) {
    drawing.fixed.push_back({"E_GPa", "the scene sets one E for the whole bone ([material] kind = \"uniform\")"});
    return;
  }
  std::vector<int> by_ct;
  for (const auto& [id, volume_mm3] : bone.CalcRegionVolumes()) {
    if (!bone.materials().Contains(id)) continue;
    const Region& region = bone.materials().At(id);
    if (!region.has_interval()) continue;
    if (std::find(ct_regions.begin(), ct_regions.end(), id) != ct_regions.end()) {
      by_ct.push_back(id);
    } else {
      AddRegion(region, drawing.drawn);
    }
  }
  if (!by_ct.empty()) {
    drawing.fixed.push_back({fmt::format("E_GPa of regions {}", fmt::join(by_ct, ", ")),
                             "E comes from the CT ([material] kind = \"ct\"), for which no interval is stated"});
  }
}

}  // namespace

Drawing FindDrawing(const Scene& scene, const Bone& bone, const std::vector<int>& ct_regions) {
  Drawing drawing;
  FindLawParameters(scene.force, drawing);
  FindRegions(scene, bone, ct_regions, drawing);
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
