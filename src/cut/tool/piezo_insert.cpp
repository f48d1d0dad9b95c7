#include "cut/tool/piezo_insert.h"

#include <fmt/format.h>

namespace kerf {
void PiezoInsert::Validate() const {
  CheckParameters(*this);
}

PlanarBlade ToolKind<PiezoInsert>::Make(const PiezoInsert& insert) {
  PlanarBlade planar;
  planar.edge_mm = insert.width_mm;
  planar.back_low = {-insert.length_mm, -0.5 * insert.taper * insert.width_mm};
  planar.back_high = {-insert.length_mm, 0.5 * insert.taper * insert.width_mm};
  planar.thickness_mm = insert.thickness_mm;
  planar.kerf_mm = insert.kerf_mm();
  planar.pitch_mm = insert.pitch_mm;
  planar.stroke_mm = insert.stroke_mm;
  return planar;
}

std::string ToolKind<PiezoInsert>::Name(const PiezoInsert& insert) {
  return fmt::format("piezo insert {:g} x {:g} x {:g} mm, teeth {:g} mm apart, stroke {:g} mm", insert.length_mm,
                     insert.width_mm, insert.thickness_mm, insert.pitch_mm, insert.stroke_mm);
}

std::string ToolKind<PiezoInsert>::ShortName(const PiezoInsert& insert) {
  return fmt::format("{:g} mm wide piezo insert", insert.width_mm);
}

}  // namespace kerf
