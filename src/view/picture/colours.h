// Colours of tissues, regions, tools and bone surfaces, chosen to be distinguishable by people with red-green colour
// blindness (after Okabe and Ito, 2008).
#pragma once

#include <string>
#include <vector>

#include "bone/mesh/meshfile.h"
#include "kerf/bone.h"

namespace kerf {

/// Brightness of the window: of the background and of the panels.
enum class Theme : std::uint8_t { kLight, kDark };

/// Line of a legend: a colour and its meaning.
struct LegendEntry {
  std::string text;
  Rgb8 colour;
};

inline constexpr Rgb8 kBoneColour{241, 229, 206};
inline constexpr Rgb8 kSteelColour{168, 178, 190};
inline constexpr Rgb8 kForceColour{0, 114, 178};

Rgb8 TissueColour(Tissue tissue);
/// Returns the colour of a cortical region. Neighbouring ids have distinct colours, although not all 31 regions can be
/// distinguished. Other tissues keep TissueColour().
Rgb8 RegionColour(int region_id);
Rgb8 RegionColour(const Region& region);

enum class ColourBy { kPlain, kTissue, kRegion };

/// Colours of the points of a surface of `bone`, and the legend of the entries that occur in at least 0.1 % of the
/// points, most frequent first (regions sorted by id). Each point has the colour of the region just below it (along the
/// surface's normal), so the faces of a cut show the layers they expose.
struct SurfaceColours {
  std::vector<Rgb8> points;
  std::vector<LegendEntry> legend;
};
SurfaceColours CalcSurfaceColours(const Bone& bone, const TriangleMesh& mesh_W, ColourBy by);

}  // namespace kerf
