// Colours of the bone's surface and their legend. Pure.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "kerf/material.h"
#include "view/picture/colours.h"

namespace kerf {

/// Colours by region; entries from 256 on are for cut faces. The fourth component is 255 for tissue drawn with pores.
using BonePalette = std::array<std::array<std::uint8_t, 4>, 512>;

/// In plain mode, uncut bone has the colour of bone, and cut faces show their tissue. By tissue or by region, the
/// colours apply everywhere.
BonePalette MakePalette(const MaterialTable& materials, ColourBy by);
/// Returns the colour of a cut face in the modes plain and by tissue.
Rgb8 CutColour(Tissue tissue);

/// Number of vertices for each entry of the palette.
using PaletteCounts = std::array<std::uint64_t, 512>;
/// Returns the entries that occur in at least 0.1 % of the coloured vertices.
std::vector<LegendEntry> MakeLegend(const MaterialTable& materials, ColourBy by, const PaletteCounts& counts);
std::string LegendTitle(ColourBy by);

}  // namespace kerf
