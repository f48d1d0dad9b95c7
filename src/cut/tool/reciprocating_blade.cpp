#include "cut/tool/reciprocating_blade.h"

#include <fmt/format.h>

namespace kerf {

PlanarBlade ToolKind<ReciprocatingBlade>::Make(const ReciprocatingBlade& blade) {
  PlanarBlade planar;
  planar.edge_mm = blade.length_mm;
  planar.back_low = {-blade.width_mm, -0.5 * blade.length_mm};
  planar.back_high = {-blade.taper * blade.width_mm, 0.5 * blade.length_mm};
  planar.has_tip = true;
  planar.thickness_mm = blade.thickness_mm;
  planar.kerf_mm = blade.kerf_mm();
  planar.pitch_mm = blade.pitch_mm;
  planar.stroke_mm = blade.stroke_mm;
  return planar;
}

std::string ToolKind<ReciprocatingBlade>::Name(const ReciprocatingBlade& blade) {
  return fmt::format("reciprocating blade {:g} x {:g} x {:g} mm, teeth {:g} mm apart, stroke {:g} mm", blade.length_mm,
                     blade.width_mm, blade.thickness_mm, blade.pitch_mm, blade.stroke_mm);
}

std::string ToolKind<ReciprocatingBlade>::ShortName(const ReciprocatingBlade& blade) {
  return fmt::format("{:g} mm reciprocating blade", blade.length_mm);
}

}  // namespace kerf
