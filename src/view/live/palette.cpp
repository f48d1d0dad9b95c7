#include "view/live/palette.h"

#include <fmt/format.h>

#include <algorithm>

namespace kerf {
namespace {

constexpr std::array kTissues{Tissue::kCortical, Tissue::kCancellous, Tissue::kTooth, Tissue::kCanal,
                              Tissue::kMetal,    Tissue::kLesion,     Tissue::kOther};

Rgb8 UncutColour(Tissue tissue) {
  return tissue == Tissue::kTooth || tissue == Tissue::kMetal ? TissueColour(tissue) : kBoneColour;
}

}  // namespace

Rgb8 CutColour(Tissue tissue) {
  // A little warmer than the bone's outside, and equally light.
  if (tissue == Tissue::kCortical) return {255, 217, 128};
  return TissueColour(tissue);
}

BonePalette MakePalette(const MaterialTable& materials, ColourBy by) {
  BonePalette palette{};
  for (std::size_t i = 0; i < palette.size(); ++i) {
    const int id = static_cast<int>(i % 256);
    const bool cut = i >= 256;
    const bool known = materials.Contains(id);
    const Tissue tissue = known ? materials.At(id).tissue : Tissue::kOther;
    Rgb8 colour = known ? CutColour(tissue) : TissueColour(Tissue::kOther);
    if (by == ColourBy::kRegion && known) colour = RegionColour(materials.At(id));
    if (by == ColourBy::kPlain && !cut) colour = UncutColour(tissue);
    const bool pores = tissue == Tissue::kCancellous && (cut || by != ColourBy::kPlain);
    palette[i] = {colour[0], colour[1], colour[2], static_cast<std::uint8_t>(pores ? 255 : 0)};
  }
  return palette;
}

std::string LegendTitle(ColourBy by) {
  switch (by) {
    case ColourBy::kPlain:
      return "Cut faces";
    case ColourBy::kTissue:
      return "Tissue";
    case ColourBy::kRegion:
      break;
  }
  return "Regions";
}

std::vector<LegendEntry> MakeLegend(const MaterialTable& materials, ColourBy by, const PaletteCounts& counts) {
  PaletteCounts by_id{};
  std::uint64_t all = 0;
  for (std::size_t i = by == ColourBy::kPlain ? 256 : 0; i < counts.size(); ++i) {
    by_id[i % 256] += counts[i];
    all += counts[i];
  }
  std::vector<LegendEntry> legend;
  if (by == ColourBy::kRegion) {
    for (const auto& [id, region] : materials.regions()) {
      const std::uint64_t count = by_id[static_cast<std::size_t>(id)];
      if (count == 0 || 1000 * count < all) continue;
      legend.push_back({fmt::format("{} {}, {:.3g} GPa", id, region.name, region.E_MPa / 1000), RegionColour(region)});
    }
    return legend;
  }
  for (const Tissue tissue : kTissues) {
    std::uint64_t count = 0;
    for (const auto& [id, region] : materials.regions()) {
      if (region.tissue == tissue) count += by_id[static_cast<std::size_t>(id)];
    }
    if (count == 0 || 1000 * count < all) continue;
    legend.push_back({ToString(tissue), CutColour(tissue)});
  }
  return legend;
}

}  // namespace kerf
