// The colours of tissues, regions and tools, and of a bone's surface. Chosen to be told apart by people who confuse red
// and green too (after Okabe and Ito, 2008).
#pragma once

#include <string>
#include <vector>

#include "bone/mesh/meshfile.h"
#include "kerf/bone.h"

namespace kerf {

/// One line of a legend: a swatch and what it stands for.
struct LegendEntry {
  std::string text;
  Rgb8 colour;
};

inline constexpr Rgb8 kBoneColour{241, 229, 206};
inline constexpr Rgb8 kSteelColour{168, 178, 190};
inline constexpr Rgb8 kForceColour{0, 114, 178};

Rgb8 TissueColour(Tissue tissue);
/// Of a cortical region: distinct for neighbouring ids; 31 colours can't all be told apart. Other tissues keep
/// TissueColour().
Rgb8 RegionColour(int region_id);
Rgb8 RegionColour(const Region& region);

enum class ColourBy { kPlain, kTissue, kRegion };

/// Colours for the points of a surface of `bone` and the legend of those that occur in at least 0.1 % of the points,
/// most frequent first (regions by id). Each point takes the region just below it (along the surface's normal), so the
/// faces of a cut show the layers they lay open.
struct SurfaceColours {
  std::vector<Rgb8> points;
  std::vector<LegendEntry> legend;
};
SurfaceColours CalcSurfaceColours(const Bone& bone, const TriangleMesh& mesh_W, ColourBy by);

}  // namespace kerf
