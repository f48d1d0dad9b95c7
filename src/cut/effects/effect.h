// Interface of an effect: callbacks at points of a tick. Only the callbacks that the effect lists are called.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "cut/contact/edge.h"
#include "cut/contact/faces.h"
#include "cut/contact/probe.h"
#include "cut/contact/step.h"
#include "cut/tool/drive.h"
#include "cut/tool/shape.h"
#include "kerf/bone.h"
#include "kerf/effects.h"
#include "kerf/own_effect.h"
#include "kerf/tool.h"

namespace kerf {

class EffectPlan;

/// Context in which an effect is created. The references outlive the effect.
///
/// Poses in the tick are in the field's frame F (BoneField), which is the world frame translated by p_WF: p_W = p_F +
/// p_WF.
struct EffectSetup {
  const Bone& bone;
  const BoneField& field;
  const Tool& tool;
  const ToolShape& shape;
  const Edge& edge;
  const ToothForce& law;
  const Faces* faces = nullptr;  // null: the tool follows a prescribed path
  Vec3 p_TC_mm{0};               // coupling point C, to which forces and motions refer, tool frame
  Vec3 p_WF_mm{0};
  std::span<const std::shared_ptr<const EffectFile>> files = {};  // as EffectChoice::files()
  EffectPlan* plan = nullptr;  // contains the effects before this one, so that this one can find those that it needs
};

/// Motion through air.
struct EffectFlight {
  const Pose& X_FT_from;
  const Pose& X_FT_to;
};

/// Step that is being set up at the tool's pose.
struct EffectStep {
  const Pose& X_FT;
  const Probe& probe;
  const Edge& edge;
  const Faces* faces = nullptr;       // as in EffectSetup
  double rpm = 0;                     // signed; 0: stopped
  bool reads_bone = true;             // false: the slab law has taken over, the bone is not read
  const DriveStep* stroke = nullptr;  // motion of an edge with a stroke, in which points of edge and faces take part
  /// Of an edge with a stroke on a path, whose loads are known before the step. They change from step to step, so that
  /// those of the last one would not do. Otherwise empty.
  std::span<ToothLoad> teeth = {};
  double reserve_mJ = 0;  // energy that springs may gain at the start of the step: it was lost before
};

/// Solved step.
struct EffectSolved {
  const Pose& X_FT;       // at its start
  const Pose& X_FT_next;  // at its end
  const Edge& edge;
  const Faces* faces = nullptr;
  const StepProblem& problem;
  const Twist& u;       // motion of the tool
  double fraction = 1;  // fraction of problem.tau_s that was completed
  double time_s = 0;    // completed time
  double rpm = 0;       // signed
  std::span<ToothLoad> teeth;
  const DriveStep* stroke = nullptr;  // as in EffectStep
};

/// End of a tick.
struct EffectEnd {
  double dt_s = 0;
  double set_rpm = 0;
  double rpm = 0;
  const Pose& X_FT;     // pose of the tool
  bool asleep = false;  // no bone was near
  double engaged_teeth = 0;
  double thrust_sum_N = 0;
  double thrust_W = 0;  // as TeethOutput::thrust_W
  double removed_mm3 = 0;
  Vec3 f_extra_W_N{0};  // force on the hand in addition to the coupling force; not in the energy balance
};

/// Maximum number of points that an effect adds to a step.
struct EffectCapacity {
  std::size_t solids = 0;
  std::size_t frictions = 0;
};

/// Base class of effects. Except for the constructor and the functions marked below, all functions are called in the
/// tick and must not allocate, lock, or do I/O.
class Effect {
 public:
  virtual ~Effect() = default;

  // Each of the following is called only if EffectInfo::hooks lists it.
  virtual void Begin(EffectBegin&) {}
  virtual bool Holds(const EffectFlight&) { return false; }
  virtual void Engage(const EffectStep&, StepProblem&) {}
  virtual void Solved(const EffectSolved&) {}
  virtual void End(EffectEnd&) {}

  /// Resets contact. Called when the tool no longer touches anything, or its contact points have changed.
  virtual void Release() {}
  /// Called after the tool has been set down elsewhere.
  virtual void Reset() { Release(); }
  /// Called after bone has been restored; Reset() follows.
  virtual void BoneRestored() {}
  /// Writes the values of EffectInfo::channels.
  virtual void Report(std::span<double>) const {}

  // ---- not in the tick
  /// Returns true if Solved() reads the loads of the teeth. The loads are computed only if an effect reads them.
  virtual bool reads_teeth() const { return true; }
  virtual EffectCapacity capacity() const { return {}; }
  virtual std::size_t CalcMemoryBytes() const = 0;

 protected:
  Effect() = default;
  Effect(const Effect&) = default;
  Effect& operator=(const Effect&) = default;
};

}  // namespace kerf
