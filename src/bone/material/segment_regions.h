// Regions that a segmentation adds to a table: numbered teeth, metal, a lesion.
#pragma once

#include "kerf/material.h"

namespace kerf {

inline constexpr int kMetalRegion = 35;
inline constexpr int kLesionRegion = 36;

/// Returns whether a number is that of a permanent or deciduous tooth after ISO 3950 (FDI).
constexpr bool IsToothNumber(int fdi) {
  const int quadrant = fdi / 10, n = fdi % 10;
  return (quadrant >= 1 && quadrant <= 4 && n >= 1 && n <= 8) || (quadrant >= 5 && quadrant <= 8 && n >= 1 && n <= 5);
}
/// Returns the id of a tooth's region: 136 for tooth 36.
constexpr int ToothRegion(int fdi) {
  return 100 + fdi;
}

/// Returns the number after ISO 3950 of a region of teeth that is named "tooth 36"; 0 for any other region.
int FindToothNumber(const Region& region);

/// These add the region if the table lacks it. Throw kerf::Error, with `name` in the message, if its id has another
/// meaning in the table. A tooth has the constants of kToothRegion, which the table must contain.
void AddTooth(int fdi, const std::string& name, MaterialTable& table);
void AddMetal(const std::string& name, MaterialTable& table);
void AddLesion(const std::string& name, MaterialTable& table);

}  // namespace kerf
