// One pass of a case: the simulation that its settings ask for, and what it is fed.
#pragma once

#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "experiment/study/case.h"
#include "kerf/error.h"

namespace kerf {

// Of settings with the material "uniform": the paper's region 24, as scenes have it.
inline constexpr double kUniform_E_MPa = 19300;
inline constexpr double kUniform_nu = 0.28;

/// What a tick is given: handle (kHand) or tool (kPath) at the end of the tick, and how fast the handle went there.
struct CaseInput {
  Pose X_W;
  Vec3 v_W_mm_per_s{0};  // of the coupling point
  Vec3 w_W_rad_per_s{0};
  bool set_down = false;  // no motion: the tool is lifted out and set down at X_W
};
/// One for each tick of the path.
std::vector<CaseInput> MakeCaseInputs(const StudyPath& path, Holding holding, double rate_hz);

/// Times that differ by no more are the same: a stroke that ends with a tick does so whatever the rounding.
inline constexpr double kSameTime_s = 1e-9;
/// The tool is lifted out and set down within from_s <= t < to_s.
bool HasLift(const StudyPath& path, double from_s, double to_s);

/// A simulation in the middle of its pass.
class CaseSubject {
 public:
  virtual ~CaseSubject() = default;
  /// The force on the hand or on the tool, N. This alone is timed.
  virtual Vec3 Tick(const CaseInput& in) = 0;
  /// Whether a tooth met bone in the last tick.
  virtual bool has_contact() const = 0;
  virtual void SetDown(const Pose& X_W) = 0;
  virtual void BetweenTicks() {}
  /// Of the bone at a point, C; NaN without bone there or without heat. Throws Error when the heat had no room.
  virtual double CalcTemperature_C(const Vec3&) { return std::numeric_limits<double>::quiet_NaN(); }
  /// At the end: exactly what the bone lost.
  virtual double CalcRemoved_mm3() { return 0; }
  virtual std::size_t CalcMemoryBytes() = 0;  // bone and simulation
  /// None where nothing is cut.
  virtual std::optional<Bone> TakeBone() { return std::nullopt; }
};

/// What only shows when a case's simulation is made: it means nothing on this path.
class Omission : public Error {
 public:
  using Error::Error;
};

/// Why these settings mean nothing on this path; empty: they do.
std::string FindOmission(const StudyPath& path, Holding holding, const StudySettings& settings);
/// The law that they name, with the path's parameters where it is the path's. Throws Error.
ForceLaw MakeCaseLaw(const StudyPath& path, const StudySettings& settings);
/// The path's bone with the material that they name. Throws Error.
Bone MakeCaseBone(const StudyPath& path, const StudySettings& settings);
/// Throws Omission, and Error, as the simulations do for parameters out of range.
std::unique_ptr<CaseSubject> MakeCaseSubject(const StudyPath& path, Holding holding, const StudySettings& settings,
                                             Bone bone);

/// Points beside the kerf of a path, W. Next to the edge itself the temperature has no limit as cells become finer: the
/// heat of a bite goes into the cell that it falls into.
std::vector<Vec3> MakeHeatProbes(const StudyPath& path, Holding holding);

/// All of a pass, as it was.
struct CasePass {
  std::vector<Vec3> f_W_N;       // by tick
  std::vector<bool> contact;     // by tick: a tooth met bone
  std::vector<double> beside_C;  // at the end, at MakeHeatProbes(); empty without heat
  double removed_mm3 = 0;
  std::optional<Bone> bone;
  std::uint64_t force_hash = 0;
  std::uint64_t bone_hash = 0;
};
CasePass RunCasePass(const StudyPath& path, Holding holding, const StudySettings& settings);
/// RunForErrors() that leaves what the pass without heat gave in `pass` as well; null: it does not.
CaseOutcome RunForErrors(const StudyPath& path, Holding holding, const StudySettings& settings,
                         const StudyReference& reference, CasePass* pass);

/// In the order of the ticks.
std::uint64_t MixForce(std::uint64_t hash, const Vec3& f_W_N);

}  // namespace kerf
