// Unit of a surface's coordinates, which its file does not give.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "kerf/error.h"
#include "kerf/geometry.h"

namespace kerf {

/// The unit of a surface's coordinates must be stated.
class UnclearUnit : public Error {
 public:
  struct Choice {
    std::string unit;
    double side_mm;  // largest side of the surface, if the coordinates have this unit
  };
  /// `what`: for a terminal, with options of kerf import. `why`: the reason alone, in words. `choices`: the units that
  /// are plausible, the likeliest first.
  UnclearUnit(const std::string& what, std::string why, std::vector<Choice> choices)
      : Error(what), why_(std::move(why)), choices_(std::move(choices)) {}
  const std::string& why() const { return why_; }
  const std::vector<Choice>& choices() const { return choices_; }

 private:
  std::string why_;
  std::vector<Choice> choices_;
};

/// Returns the length of mm, cm, m, in or um in mm. Throws kerf::Error for another unit.
double CalcMmPerUnit(const std::string& unit);

/// Converts the surface to mm. If `unit` is empty, mm are assumed, unless the largest side is then not plausible for a
/// bone, or the surface is as plausible as a skull or a long bone in cm: then throws UnclearUnit, whose message begins
/// with `path` and lists the units to choose from. A surface larger than a metre is rejected in any unit.
void ScaleToMm(TriangleMesh& mesh, const std::string& unit, const std::string& path);

/// Throws kerf::Error, whose message begins with `path`, if the surface encloses more than can be voxelised with voxels
/// of `voxel_mm` within minutes.
void CheckEnclosed(const TriangleMesh& mesh, double voxel_mm, const std::string& path);

}  // namespace kerf
