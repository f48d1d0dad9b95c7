// Material of bone: a table from region id to elastic constants.
#pragma once

#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "kerf/describe.h"
#include "kerf/geometry.h"

namespace kerf {

/// No bone saw removes metal.
enum class Tissue { kCortical, kCancellous, kTooth, kCanal, kOther, kMetal, kLesion };
inline constexpr int kTissueCount = 5;  // of the first ones, which force laws distinguish: see CutTissue()
/// Returns the tissue as a force law sees it: a lesion, for which no law has forces of its own, is kOther. Metal is not
/// cut; it is kOther too.
constexpr Tissue CutTissue(Tissue tissue) {
  return static_cast<int>(tissue) < kTissueCount ? tissue : Tissue::kOther;
}
const char* ToString(Tissue tissue);
/// Valid names: "cortical", "cancellous", "tooth", "canal", "other", "metal" and "lesion". Returns nullopt for any
/// other name.
std::optional<Tissue> TissueFromString(const std::string& name);

/// Ids of regions. 0 means "no bone" in the region grid.
inline constexpr Range kRegionRange{1, 255};

/// Region: a part of the bone with uniform elastic constants.
struct Region {
  int id = 0;
  std::string name;
  Tissue tissue = Tissue::kOther;
  double E_MPa = 0;      // Young's modulus, MPa, > 0
  double nu = 0;         // Poisson's ratio
  bool estimate = true;  // true: the constants are assumed, not measured in this region
  std::string source;    // source of the constants
  /// Interval within which the true E is thought to lie, MPa. Both 0: none is stated.
  double E_lower_MPa = 0;
  double E_upper_MPa = 0;

  bool has_interval() const { return E_lower_MPa < E_upper_MPa; }
};

/// Regions ordered by id. Value type.
class MaterialTable {
 public:
  /// Throws kerf::Error if an id is out of range or already used, if E or nu is out of range, or if an interval of E
  /// is stated that does not contain E.
  void Add(Region region);
  bool Contains(int id) const { return regions_.count(id) != 0; }
  /// Throws kerf::Error if there is no region with this id.
  const Region& At(int id) const;
  const std::map<int, Region>& regions() const { return regions_; }
  bool empty() const { return regions_.empty(); }

  /// Direction of the osteons in the world frame, a unit vector whose sign does not matter; nullopt: unknown. One
  /// direction for the whole bone.
  const std::optional<Vec3>& osteon_direction() const { return osteon_direction_; }
  /// Normalises the direction. Throws kerf::Error if it is not finite or its length is below 1e-6.
  void SetOsteonDirection(const Vec3& direction_W);

 private:
  std::map<int, Region> regions_;
  std::optional<Vec3> osteon_direction_;
};

/// Returns the same regions with one E and nu for all: the "no variation at all" case of the paper. Throws kerf::Error
/// if E or nu is out of range.
MaterialTable MakeUniformTable(const MaterialTable& table, double E_MPa, double nu);

/// Parses CSV with the header `id,name,tissue,E_GPa,nu,estimate,source` and, optionally, the columns `E_lower_GPa` and
/// `E_upper_GPa`: both are empty, or they enclose E. '#' starts a comment line; a field with a
/// comma is in double quotes. `file` names the text in messages. Throws kerf::Error with file:line for the first fault.
MaterialTable ParseRegionTable(const std::string& text, const std::string& file);
/// Writes the columns of the interval only if a region has one.
std::string FormatRegionTable(const MaterialTable& table);

/// Returns volumes/mandible_regions.csv, which is built in: regions 1 to 31, the cortex after Schwartz-Dabney and
/// Dechow (four rows from the paper, the others estimates), 32 cancellous bone, 33 teeth, 34 the nerve canal.
const MaterialTable& DefaultMandibleTable();

/// Law from CT number to modulus: a calibration maps HU to density, and a piecewise power law maps density to E.
///
/// E = E0 + a rho^b, rho in g/cm3. Values outside the calibration or the bands are clamped to their ends. Accuracy:
/// none of the laws was measured on the cortex of a mandible. In cortical bone the CT number explains less than a fifth
/// of the variance of the modulus (docs/materials.md).
struct CtLaw {
  struct Point {
    double HU;
    double rho;  // g/cm3
  };
  struct Band {
    double lower, upper;  // g/cm3; a density on a border belongs to the upper band
    double E0_MPa;
    double a_MPa;
    double b;
  };
  std::string name;
  std::string tissue;              // tissue for which the law was derived, as text
  std::string density;             // "apparent", "ash", "qct" or "mass"
  std::vector<Point> calibration;  // piecewise linear, HU and rho both increasing; empty: depends on the scanner and
                                   // must be provided
  std::vector<Band> bands;         // increasing, without gaps: each begins where the previous one ends
  char tag = 'R';                  // S: coefficients read in the source; D: derived from it; R: recalled, unverified
  std::string source;

  double lower_rho() const { return bands.front().lower; }
  double upper_rho() const { return bands.back().upper; }
};

/// Throws kerf::Error with a description of the fault if a law is invalid: no band, bands that overlap or leave a gap,
/// a negative density, calibration points out of order, a modulus not above 0, or a calibration that does not overlap
/// the bands.
void CheckCtLaw(const CtLaw& law);

/// Returns the modulus at a density in g/cm3, MPa, clamped to the bands. Tick-safe.
double CalcModulus(const CtLaw& law, double rho);
/// Returns the density at a CT number, g/cm3, clamped to the calibration. The law must have a calibration. Tick-safe.
double CalcDensity(const CtLaw& law, double HU);
/// Returns the lowest and the highest CT number within both the calibration and the bands. The law must have a
/// calibration.
std::pair<double, double> CalcValidHu(const CtLaw& law);

/// Computes the reduced modulus E* of two bodies in contact, MPa: 1/E* = (1 - nu1^2)/E1 + (1 - nu2^2)/E2 (Hertz).
/// Tick-safe.
double CalcReducedModulus(double E1_MPa, double nu1, double E2_MPa, double nu2);

}  // namespace kerf
