// Whether bone is anywhere near the tool, before anything is looked up in it.
#pragma once

#include <memory>

#include "bone/grid/field.h"
#include "kerf/geometry.h"
#include "kerf/tool.h"

namespace kerf {

/// A lower bound of the distance between tool and bone. Embree finds the leaf boxes nearest to a few balls that cover
/// the tool; between queries the bound is lowered by how far the tool has moved. Bone only gets less, so the boxes of
/// the start stay true.
class Clearance {
 public:
  /// Allocates.
  Clearance(const BoneField& field, const Tool& tool);
  ~Clearance();
  Clearance(Clearance&&) noexcept;
  Clearance& operator=(Clearance&&) noexcept;

  /// True when bone may be within `margin_mm` of the tool at X_WT; false: surely not. Tick-safe.
  bool IsNear(const Pose& X_WT, double margin_mm);
  /// The bound itself, mm, after IsNear(); 0 when near. Tick-safe.
  double bound_mm() const;
  std::size_t CalcMemoryBytes() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace kerf
