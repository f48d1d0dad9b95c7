// Test whether bone is near the tool, before any access to the bone's grid.
#pragma once

#include <memory>

#include "bone/grid/field.h"
#include "kerf/geometry.h"
#include "kerf/tool.h"

namespace kerf {

/// Lower bound on the distance between tool and bone. Embree finds the leaf boxes nearest to a few balls that cover the
/// tool. Between queries the bound decreases by the tool's motion. The bone never grows beyond its initial state, so
/// the initial boxes stay valid.
class Clearance {
 public:
  /// Allocates.
  Clearance(const BoneField& field, const Tool& tool);
  ~Clearance();
  Clearance(Clearance&&) noexcept;
  Clearance& operator=(Clearance&&) noexcept;

  /// Returns true if bone may be within `margin_mm` of the tool at X_WT; false if it certainly is not. Tick-safe.
  bool IsNear(const Pose& X_WT, double margin_mm);
  /// The bound after IsNear(), mm; 0 if near. Tick-safe.
  double bound_mm() const;
  std::size_t CalcMemoryBytes() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace kerf
