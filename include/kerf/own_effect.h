// Interface for an effect that another program adds to kerf with RegisterEffect(): it may read what the teeth do,
// change the spindle's speed, and push the hand.
#pragma once

#include <cstddef>
#include <memory>
#include <span>

#include "kerf/bone.h"
#include "kerf/effects.h"
#include "kerf/force.h"
#include "kerf/geometry.h"
#include "kerf/tool.h"

namespace kerf {

/// Context in which an effect is created. The references are valid only during the call.
struct OwnEffectSetup {
  const Bone& bone;  // at the start
  const Tool& tool;
  bool in_hand = false;                                           // false: the tool follows a prescribed path
  std::span<const std::shared_ptr<const EffectFile>> files = {};  // as EffectChoice::files()
};

/// Start of a tick.
struct EffectBegin {
  double dt_s = 0;
  double set_rpm = 0;  // requested by the operator; the sign is the direction of rotation about +z
  double rpm = 0;      // used by the tick; an effect may change it. 0: the spindle is stopped
};

/// Teeth at a point of the edge, in a solved step.
struct ToothLoad {
  Vec3 p_T{0};                 // on the edge, mm
  Vec3 e_T{0};                 // outward direction
  double teeth = 0;            // number of teeth, a real number
  double thrust_N = 0;         // sum over the teeth, along -e
  double speed_mm_per_s = 0;   // outward
  double thrust_on_way_N = 0;  // mean over the way of the teeth; thrust_N, unless the edge has a stroke
  double cutting_N = 0;  // sum over the teeth, against their motion, mean over their way; 0 unless the law states one
  ToothCut cut;
  int region = 0;
  double tangential_N = 0;  // force that the effect tangential_force applies for these teeth; otherwise 0
};

/// Step of a tick in which teeth may have cut. A tick has one or more of them.
struct OwnEffectStep {
  Pose X_WT_from;  // pose of the tool at its start and at its end
  Pose X_WT_to;
  double time_s = 0;  // duration, >= 0
  double rpm = 0;     // signed; 0: stopped
  std::span<const ToothLoad> teeth;
};

/// End of a tick.
struct OwnEffectEnd {
  double dt_s = 0;
  double rpm = 0;  // signed; 0: stopped
  Pose X_WT;       // of the tool
  double engaged_teeth = 0;
  double thrust_sum_N = 0;
  double removed_mm3 = 0;
  Vec3 f_extra_W_N{0};  // to be set by an effect with kEffectPush: force on the hand in addition to that of the
                        // coupling, world frame; it is not in the energy balance
};

/// Effect of another program. Except for the constructor and the destructor, all functions are called in the tick: they
/// must not use heap memory, lock, wait, or do input or output. A program that is linked with kerf::heap_guard ends
/// with a message if they use heap memory. With the same calls they must give the same results, or recordings cannot be
/// replayed. A speed or a push that is not finite, or an exception of Begin(), Solved() or End(), ends the tick with
/// kerf::Error, which names the tick and the effect; so does a force law that gives a force which is not finite or
/// below 0, or that throws. The tool is then where it was before the tick, as after SetDown(). Bone that earlier steps
/// of the tick have removed stays removed, and what the effects have stored is kept.
class OwnEffect {
 public:
  virtual ~OwnEffect() = default;

  // Each of the following is called only if EffectInfo::hooks lists it: kEffectBegin, kEffectSolved, kEffectEnd.
  virtual void Begin(EffectBegin& /*begin*/) {}
  virtual void Solved(const OwnEffectStep& /*step*/) {}
  virtual void End(OwnEffectEnd& /*end*/) {}

  /// Called when the tool has been set down elsewhere or bone has been restored: forget the contact.
  virtual void Reset() noexcept {}
  /// Writes the values of EffectInfo::channels.
  virtual void Report(std::span<double> /*channels*/) const noexcept {}

  /// Memory of the object, bytes, for the cost that kerf shows for it. Not called in the tick.
  virtual std::size_t CalcMemoryBytes() const { return sizeof(*this); }

 protected:
  OwnEffect() = default;
  OwnEffect(const OwnEffect&) = default;
  OwnEffect& operator=(const OwnEffect&) = default;
};

}  // namespace kerf
