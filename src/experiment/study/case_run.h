// One pass of a case: the simulation that its settings select, and its inputs.
#pragma once

#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "experiment/study/case.h"
#include "kerf/error.h"

namespace kerf {

// Elastic constants for the material "uniform": those of the paper's region 24, as in scenes.
inline constexpr double kUniform_E_MPa = 19300;
inline constexpr double kUniform_nu = 0.28;

/// Input of a tick: pose of the handle (kHand) or the tool (kPath) at the end of the tick, and the handle's velocity
/// there.
struct CaseInput {
  Pose X_W;
  Vec3 v_W_mm_per_s{0};  // of the coupling point
  Vec3 w_W_rad_per_s{0};
  bool set_down = false;  // no motion: the tool is lifted out and set down at X_W
};
/// Returns one input for each tick of the path.
std::vector<CaseInput> MakeCaseInputs(const StudyPath& path, Holding holding, double rate_hz);

/// Times that differ by at most this much count as equal, so that rounding does not move the end of a stroke that
/// coincides with the end of a tick.
inline constexpr double kSameTime_s = 1e-9;
/// Returns true if the tool is lifted out and set down within from_s <= t < to_s.
bool HasLift(const StudyPath& path, double from_s, double to_s);

/// The simulation of one pass.
class CaseSubject {
 public:
  virtual ~CaseSubject() = default;
  /// Returns the force on the hand or on the tool, N. Only this function is timed.
  virtual Vec3 Tick(const CaseInput& in) = 0;
  /// Returns true if a tooth touched bone in the last tick.
  virtual bool has_contact() const = 0;
  virtual void SetDown(const Pose& X_W) = 0;
  virtual void BetweenTicks() {}
  /// Returns the temperature of the bone at a point, C, or NaN if there is no bone at the point or heat is not
  /// simulated. Throws Error if the heat grid was too small.
  virtual double CalcTemperature_C(const Vec3&) { return std::numeric_limits<double>::quiet_NaN(); }
  /// Returns the exact volume that the bone has lost. Call it at the end of the pass.
  virtual double CalcRemoved_mm3() { return 0; }
  virtual std::size_t CalcMemoryBytes() = 0;  // bone and simulation
  /// Returns nullopt if nothing is cut.
  virtual std::optional<Bone> TakeBone() { return std::nullopt; }
};

/// Thrown if creating a simulation shows that the settings make no sense for this path.
class Omission : public Error {
 public:
  using Error::Error;
};

/// Returns the reason why these settings make no sense for this path; empty if they do.
std::string FindOmission(const StudyPath& path, Holding holding, const StudySettings& settings);
/// Returns the law selected by the settings, with the path's parameters if it is the path's law. Throws Error for an
/// unknown law.
ForceLaw MakeCaseLaw(const StudyPath& path, const StudySettings& settings);
/// Returns the path's bone with the material selected by the settings. Throws Error if it cannot be made.
Bone MakeCaseBone(const StudyPath& path, const StudySettings& settings);
/// Creates the simulation that the settings select. Throws Omission if they make no sense for this path, and Error if
/// a parameter is out of range.
std::unique_ptr<CaseSubject> MakeCaseSubject(const StudyPath& path, Holding holding, const StudySettings& settings,
                                             Bone bone);

/// Returns the points next to the kerf of a path, in the world frame, at which temperatures are compared. Directly at
/// the edge, the temperature would not converge as the cells become finer, because the heat of a bite goes into the
/// cell in which it is produced.
std::vector<Vec3> MakeHeatProbes(const StudyPath& path, Holding holding);

/// All results of a pass.
struct CasePass {
  std::vector<Vec3> f_W_N;                   // by tick
  std::vector<bool> contact;                 // by tick: whether a tooth touched bone
  std::vector<double> probe_temperatures_C;  // at the end, at the points of MakeHeatProbes(); empty without heat
  double removed_mm3 = 0;
  std::optional<Bone> bone;
  std::uint64_t force_hash = 0;
  std::uint64_t bone_hash = 0;
};
CasePass RunCasePass(const StudyPath& path, Holding holding, const StudySettings& settings);
/// Like RunForErrors() in case.h, but also stores the result of the pass without heat in `pass`, unless `pass` is null.
CaseOutcome RunForErrors(const StudyPath& path, Holding holding, const StudySettings& settings,
                         const StudyReference& reference, CasePass* pass);

/// Updates a hash with the force of the next tick; the order of the ticks matters.
std::uint64_t MixForce(std::uint64_t hash, const Vec3& f_W_N);

}  // namespace kerf
