// The material of bone: a table from region number to elastic constants.
#pragma once

#include <map>
#include <optional>
#include <string>
#include <utility>
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

/// The same regions with one E and nu for all: the "no variation at all" that the paper compares its regions with.
/// Throws Error when E or nu is out of range.
MaterialTable MakeUniformTable(const MaterialTable& table, double E_MPa, double nu);

/// A way from CT number to modulus: HU to density by a calibration, density to E by a power law in bands.
///
/// E = E0 + a rho^b, rho in g/cm3. What lies outside the calibration or the bands is held to their ends. Error: none of
/// the laws was measured on the cortex of a mandible; in cortical bone the CT number explains less than a fifth of the
/// modulus at all (docs/materials.md).
struct CtLaw {
  struct Point {
    double HU;
    double rho;  // g/cm3
  };
  struct Band {
    double lower, upper;  // g/cm3; a density on a border belongs to the band above
    double E0_MPa;
    double a_MPa;
    double b;
  };
  std::string name;
  std::string tissue;              // that it was made for, in words
  std::string density;             // "apparent", "ash", "qct" or "mass"
  std::vector<Point> calibration;  // piecewise linear, both rising; empty: it depends on the scanner and must be given
  std::vector<Band> bands;         // rising, each beginning where the one before ends
  char tag = 'R';                  // S: coefficients read in the source; D: derived from such; R: recalled, unverified
  std::string source;

  double lower_rho() const { return bands.front().lower; }
  double upper_rho() const { return bands.back().upper; }
};

/// Throws Error that says what is wrong with a law: bands that overlap or leave a gap, a negative density, points out
/// of order, a modulus not above 0, a calibration that never comes into the bands.
void CheckCtLaw(const CtLaw& law);

/// MPa at a density in g/cm3, held to the bands. Tick-safe.
double CalcModulus(const CtLaw& law, double rho);
/// g/cm3 at a CT number, held to the calibration. The law must have one. Tick-safe.
double CalcDensity(const CtLaw& law, double HU);
/// The CT numbers for which neither calibration nor bands are left, lower and upper. The law must have a calibration.
std::pair<double, double> CalcValidHu(const CtLaw& law);

/// Reduced modulus E* of two bodies in contact, MPa: 1/E* = (1 - nu1^2)/E1 + (1 - nu2^2)/E2 (Hertz). Tick-safe.
double CalcReducedModulus(double E1_MPa, double nu1, double E2_MPa, double nu2);

}  // namespace kerf
