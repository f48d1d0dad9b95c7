// The material of bone: a table from region number to elastic constants.
#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

namespace kerf {

enum class Tissue { kCortical, kCancellous, kTooth, kCanal, kOther };
const char* ToString(Tissue tissue);
/// "cortical", "cancellous", "tooth", "canal" or "other".
std::optional<Tissue> TissueFromString(const std::string& name);

/// One region: a part of the bone with uniform elastic constants.
struct Region {
  int id = 0;  // 1 to 255; 0 means "no bone" in the region grid
  std::string name;
  Tissue tissue = Tissue::kOther;
  double E_MPa = 0;      // Young's modulus, MPa, > 0
  double nu = 0;         // Poisson's ratio, 0 <= nu <= 0.5
  bool estimate = true;  // true: assumed, not measured at this place
  std::string source;    // where the figures come from
};

/// Regions by id, in order. Value type.
class MaterialTable {
 public:
  /// Throws Error when an id is out of range or taken, or E or nu out of range.
  void Add(Region region);
  bool Contains(int id) const { return regions_.count(id) != 0; }
  /// Throws Error for an unknown id.
  const Region& At(int id) const;
  const std::map<int, Region>& regions() const { return regions_; }
  bool empty() const { return regions_.empty(); }

 private:
  std::map<int, Region> regions_;
};

/// Reduced modulus E* of two bodies in contact, MPa: 1/E* = (1 - nu1^2)/E1 + (1 - nu2^2)/E2 (Hertz). Tick-safe.
double CalcReducedModulus(double E1_MPa, double nu1, double E2_MPa, double nu2);

}  // namespace kerf
