// What the colours of the bone's surface mean. Pure.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "kerf/material.h"
#include "view/picture/colours.h"

namespace kerf {

/// By region; from 256 on where it was cut. The fourth figure is 255 for what is drawn with pores.
using BonePalette = std::array<std::array<std::uint8_t, 4>, 512>;

/// Plain: bone is bone, but what was cut shows its tissue. By tissue and by region: everywhere.
BonePalette MakePalette(const MaterialTable& materials, ColourBy by);
/// Of a cut face, plain or by tissue.
Rgb8 CutColour(Tissue tissue);

/// How many vertices have each entry of the palette.
using PaletteCounts = std::array<std::uint64_t, 512>;
/// Entries that occur in at least 0.1 % of the vertices that a colour is given to.
std::vector<LegendEntry> MakeLegend(const MaterialTable& materials, ColourBy by, const PaletteCounts& counts);
std::string LegendTitle(ColourBy by);

}  // namespace kerf
