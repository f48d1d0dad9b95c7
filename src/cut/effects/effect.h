// What an effect is to the tick: calls at the moments that it names, and no other.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "cut/contact/edge.h"
#include "cut/contact/faces.h"
#include "cut/contact/probe.h"
#include "cut/contact/step.h"
#include "cut/tool/shape.h"
#include "kerf/bone.h"
#include "kerf/effects.h"
#include "kerf/tool.h"

namespace kerf {

class EffectPlan;

/// What there is when a simulation is made. The references outlive the effect.
///
/// Poses in the tick are those of the field's frame F (BoneField), which is the world moved by p_WF: p_W = p_F + p_WF.
struct EffectSetup {
  const Bone& bone;
  const BoneField& field;
  const Tool& tool;
  const ToolShape& shape;
  const Edge& edge;
  const Faces* faces = nullptr;  // null: a tool that follows its path
  Vec3 p_TC_mm{0};               // where forces and motions are taken, tool frame
  Vec3 p_WF_mm{0};
  std::span<const std::shared_ptr<const EffectFile>> files = {};  // as EffectChoice::files()
  EffectPlan* plan = nullptr;  // has those effects that stand before: where an effect finds whom it needs
};

/// A tick that begins.
struct EffectBegin {
  double dt_s = 0;
  double set_rpm = 0;  // that the operator asks for; its sign is the direction of turning, about +z
  double rpm = 0;      // that the tick works with: an effect may change it. 0: the spindle stands still
};

/// A way through air.
struct EffectFlight {
  const Pose& X_FT_from;
  const Pose& X_FT_to;
};

/// A step that is set up at the tool's pose.
struct EffectStep {
  const Pose& X_FT;
  const Probe& probe;
  const Edge& edge;
  const Faces* faces = nullptr;  // as in EffectSetup
  double rpm = 0;                // signed; 0: stopped
  bool looks = true;             // false: the slab's law has taken over, nothing is looked up in the bone
};

/// Teeth at a point of the edge, in the step that was made.
struct ToothLoad {
  Vec3 p_T{0};                // on the edge, mm
  Vec3 e_T{0};                // outwards
  double teeth = 0;           // a real number
  double thrust_N = 0;        // of them all, along -e
  double speed_mm_per_s = 0;  // outwards
  double E_star_MPa = 0;
  int region = 0;
  double tangential_N = 0;  // of them all, against the teeth's way: an effect's, 0 without it
};

/// A step that has been made.
struct EffectSolved {
  const Pose& X_FT;       // at its start
  const Pose& X_FT_next;  // at its end
  const Edge& edge;
  const Faces* faces = nullptr;
  const StepProblem& problem;
  const Twist& u;     // the motion
  double share = 1;   // of problem.tau_s that was made good
  double time_s = 0;  // the same, s
  double rpm = 0;     // signed
  std::span<ToothLoad> teeth;
};

/// A tick that is over.
struct EffectEnd {
  double dt_s = 0;
  double set_rpm = 0;
  double rpm = 0;
  const Pose& X_FT;     // the tool
  bool asleep = false;  // nothing was near
  double engaged_teeth = 0;
  double thrust_sum_N = 0;
  double removed_mm3 = 0;
  Vec3 f_more_W_N{0};  // an effect adds what goes to the hand beside the coupling: it is in no account of energy
};

/// How many points an effect adds to a step at most.
struct EffectCapacity {
  std::size_t solids = 0;
  std::size_t frictions = 0;
};

/// All calls but the constructor's are made in the tick: no allocation, no lock, no I/O.
class Effect {
 public:
  virtual ~Effect() = default;

  // Each is called only when EffectInfo::hooks names it.
  virtual void Begin(EffectBegin&) {}
  virtual bool Holds(const EffectFlight&) { return false; }
  virtual void Engage(const EffectStep&, StepProblem&) {}
  virtual void Solved(const EffectSolved&) {}
  virtual void End(EffectEnd&) {}

  /// The tool touches nothing any more, or its contact points have changed: what was borne is forgotten.
  virtual void Release() {}
  /// The tool was set down elsewhere.
  virtual void Reset() { Release(); }
  /// There may be bone again where there was none; Reset() follows.
  virtual void BoneCameBack() {}
  /// As many as EffectInfo::channels.
  virtual void Report(std::span<double>) const {}

  // ---- not in the tick
  /// Whether Solved() looks at the teeth. They are worked out for those that do.
  virtual bool reads_teeth() const { return true; }
  virtual EffectCapacity capacity() const { return {}; }
  virtual std::size_t CalcMemoryBytes() const = 0;

 protected:
  Effect() = default;
  Effect(const Effect&) = default;
  Effect& operator=(const Effect&) = default;
};

}  // namespace kerf
