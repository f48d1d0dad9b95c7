// Force laws: the thrust and the cutting force on one tooth from its bite and what it cuts. Each law is one file in
// src/cut/force. Scenes, `kerf check`, the warnings and the tests all use the list of laws.
#pragma once

#include <array>
#include <limits>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "kerf/material.h"
#include "kerf/tool.h"

namespace kerf {

/// Direction of a cut relative to the osteons (the long axis of cortical bone), as squared cosines of the angles
/// between the osteons and three directions at the tooth. They add up to 1, or are all 0 if the direction of the
/// osteons is unknown.
struct OsteonShares {
  double along = 0;   // with the tooth's motion
  double into = 0;    // with the thrust
  double across = 0;  // with the width of the edge
};

/// What a tooth cuts, and how.
struct ToothCut {
  double E_star_MPa = 0;                      // reduced modulus of the tool on the bone
  double E_MPa = 0;                           // Young's modulus of the bone
  std::array<double, kTissueCount> tissue{};  // fractions of the tissues at the tooth, by Tissue; only if the law reads
                                              // them (kReadsTissue). Their sum is 1.
  double speed_mm_per_s = 0;                  // of the tooth along its path, >= 0
  OsteonShares osteon{};                      // only if the law reads them (kReadsOsteons)
};

/// Returns the cut of a single tissue with no known direction.
ToothCut MakeToothCut(double E_MPa, double E_star_MPa, Tissue tissue, double speed_mm_per_s = 0);

/// What a law reads of a ToothCut besides the moduli and the speed. The tick does not look up the rest.
enum LawReads : unsigned { kReadsTissue = 1u << 0, kReadsOsteons = 1u << 1 };

inline constexpr TextLimit kForceSourceLimit{1000};

/// A row of a force table: forces on a tooth 1 mm wide. Files and scenes have the same keys.
struct ForceLawRow {
  std::string tissue = "cortical";
  double bite_um = 1;
  double thrust_N_per_mm = 0;
  double cutting_N_per_mm = 0;
  std::string source;  // citation
};
template <typename V>
void Describe(ForceLawRow& p, V&& visit) {
  visit("tissue", p.tissue, Choices{{"cortical", "cancellous", "tooth", "canal", "other"}}, "tissue of the row");
  visit("bite_um", p.bite_um, Range{1e-3, 1000}, "bite; increases by at least 1 % from row to row of a tissue");
  visit("thrust_N_per_mm", p.thrust_N_per_mm, Range{0, 1e6},
        "thrust for each mm of the tooth's width; does not fall from row to row of a tissue");
  visit("cutting_N_per_mm", p.cutting_N_per_mm, Range{0, 1e6}, "cutting force for each mm of the tooth's width");
  visit("source", p.source, kForceSourceLimit, "source of the row");
}

/// Forces at several bites, for each tissue: the data of the law `tabulated`. Between bites the forces are interpolated
/// linearly. Below the first bite they fall linearly to 0; above the last bite the last segment is extended, but no
/// force falls below 0.
class ForceTable {
 public:
  struct Row {
    double bite_um;  // as stated, so that a written table reads back to the same bits
    double bite_mm;
    double thrust_N_per_mm;
    double cutting_N_per_mm;
    std::string source;
  };

  /// Adds a row after those of its tissue. Throws kerf::Error, without a place, if a value is not valid, the source is
  /// empty, or the row does not follow the previous one as Describe() states.
  void Add(const ForceLawRow& row);
  /// Throws kerf::Error if there are no rows, or only one for some tissue: call after the last Add().
  void CheckComplete() const;

  /// None, or at least two. A law refuses bone in which a tissue without rows occurs.
  const std::array<std::vector<Row>, kTissueCount>& rows() const { return rows_; }  // by Tissue
  bool Has(Tissue tissue) const { return !rows_[static_cast<std::size_t>(tissue)].empty(); }
  /// Returns all rows, in the order of the tissues.
  std::vector<ForceLawRow> ListRows() const;

 private:
  std::array<std::vector<Row>, kTissueCount> rows_;
};
/// Reads a force table (docs/formats.md, "A table of forces"). `name` is used in messages. Throws kerf::Error with the
/// line of the first fault.
ForceTable ParseForceTable(const std::string& text, const std::string& name);

/// Values of a law's parameters, in the order of ForceLawInfo::parameters.
using LawValues = std::array<double, 16>;
/// Coefficients of a law for one tool; their meaning is stated in the law's file.
using LawCoefficients = std::array<double, 16>;

/// Force law prepared for one tool, so that the tick needs no lookups. Rules that every law keeps, for any cut:
///   1. the thrust is 0 or more, and does not fall as the bite grows: the step of a tool in a hand stays convex;
///   2. both forces are finite for bites up to 1 m;
///   3. both are 0 for an empty ToothCut;
///   4. the same arguments give the same bits, at any time.
/// The cutting force may fall with the bite. A tick in which a law breaks rule 1 or 2 or throws ends with an Error.
struct ToothForce {
  using Function = double (*)(const ToothForce& law, double bite_mm, const ToothCut& cut);

  Function thrust = nullptr;   // N, for a bite of 0 or more; at 0 it is the limit from above
  Function cutting = nullptr;  // N, likewise; null: the law states no cutting force
  LawCoefficients c{};
  std::shared_ptr<const ForceTable> table = nullptr;  // of the law `tabulated`, otherwise null
  unsigned reads = 0;                                 // LawReads
  bool jumps = false;                                 // the thrust in the limit of bite 0 is above 0
  double least_thrust_per_cutting = 0;  // smallest ratio of thrust to cutting force at any bite; 0: no cutting force

  /// Returns the thrust, the force on the tooth against its bite: N, >= 0, and 0 for a bite of 0 or less. Tick-safe.
  double operator()(double bite_mm, const ToothCut& cut) const { return bite_mm > 0 ? thrust(*this, bite_mm, cut) : 0; }
  bool HasCutting() const { return cutting != nullptr; }
  /// Returns the cutting force, the force on the tooth against its motion: N, >= 0, and 0 for a bite of 0 or less. The
  /// law must have one. Tick-safe.
  double Cutting(double bite_mm, const ToothCut& cut) const { return bite_mm > 0 ? cutting(*this, bite_mm, cut) : 0; }
};

/// Parameter of a law: a key of [force] in a scene. The name includes the unit.
struct LawParameter {
  const char* key;
  double default_value;
  double lower;  // lower end of the valid range
  double upper;
  const char* meaning;
  /// Interval within which the true value is thought to lie, and its basis. Both ends equal: none is stated.
  double interval_lower = 0;
  double interval_upper = 0;
  const char* interval_basis = "";

  bool has_interval() const { return interval_lower < interval_upper; }
};

/// Range of bites that a law's measurements cover. `below` and `beyond` complete the warnings outside it; "": none.
struct LawValidity {
  double from_mm = 0;
  double to_mm = std::numeric_limits<double>::infinity();
  const char* below = "";
  const char* beyond = "";
};

/// Description of a force law.
struct ForceLawInfo {
  const char* name;     // name in scenes
  const char* summary;  // one line
  const char* source;   // sources of formula and constants
  LawValidity validity;
  std::vector<LawParameter> parameters;  // at most as many as LawValues holds
  /// `values` must be in the order of `parameters`, each in its range. `table` is null unless the law has one.
  ToothForce (*make)(const LawValues& values, const Tooth& tooth, const std::shared_ptr<const ForceTable>& table);
  bool has_cutting = false;  // states a cutting force
  bool has_table = false;    // reads a ForceTable
};

/// Returns all laws, the default first. To add one to kerf, add a file to src/cut/force and a line to
/// src/cut/force/laws.h; a program adds its own with RegisterForceLaw().
const std::vector<const ForceLawInfo*>& ForceLaws();
/// Adds a law of the calling program. From then on it can be chosen by name like kerf's own laws, also in scenes.
/// Throws kerf::Error if the name is taken or not made of lower-case letters, digits and "_", or if the law breaks one
/// of the rules of ToothForce; these are checked for bites from 1 pm to 1 m, for every tissue, with the defaults of the
/// parameters and both ends of their ranges. In a program that is linked with kerf::heap_guard, a law that uses heap
/// memory ends the program here. Call it before scenes are read and simulations are made; not thread-safe.
void RegisterForceLaw(ForceLawInfo info);

/// Force law chosen by name, with its parameters.
class ForceLaw {
 public:
  /// The default law.
  ForceLaw();
  /// Sets all parameters to their defaults. Throws kerf::Error if there is no law of that name.
  explicit ForceLaw(std::string_view name);

  const ForceLawInfo& info() const { return *info_; }
  const char* name() const { return info_->name; }
  /// Values in the order of info().parameters.
  const LawValues& values() const { return values_; }
  LawValues& values() { return values_; }
  /// Both throw kerf::Error if the law has no such parameter.
  double Get(std::string_view key) const { return values_[FindParameter(key)]; }
  void Set(std::string_view key, double value) { values_[FindParameter(key)] = value; }
  /// Table of a law with `has_table`: the one that comes with kerf, unless another has been set. Otherwise null.
  const std::shared_ptr<const ForceTable>& table() const { return table_; }
  /// Returns true if a table other than the one that comes with kerf has been set.
  bool has_own_table() const { return has_own_table_; }
  /// Throws kerf::Error if the law reads no table.
  void SetTable(std::shared_ptr<const ForceTable> table);

 private:
  std::size_t FindParameter(std::string_view key) const;

  const ForceLawInfo* info_;
  LawValues values_{};
  std::shared_ptr<const ForceTable> table_;
  bool has_own_table_ = false;
};

/// Prepares a law for a tool. Throws kerf::Error if a parameter is out of range.
ToothForce MakeToothForce(const ForceLaw& law, const Tool& tool);

/// Throws kerf::Error if the law has no forces for a tissue of these materials.
void CheckTissues(const ForceLaw& law, const MaterialTable& materials);

}  // namespace kerf
