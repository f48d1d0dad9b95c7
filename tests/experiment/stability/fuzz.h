// Hard case 40: sequences of random calls, and the invariants that hold for all of them.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "cut/hand_sim/internals.h"
#include "experiment/stability/dice.h"
#include "kerf/bone.h"
#include "kerf/coupled.h"

namespace kerf::test {

// ---- elements of a sequence

/// Returns a small bone of a random difficult kind. Sets `voxel_mm`.
Bone MakeFuzzBone(Dice& dice, double& voxel_mm);

struct FuzzScene {
  Bone bone;
  double voxel_mm = 0.2;
  Box3 box;  // of the bone
  ComparedParams params;
  Pose start;
};
enum class FuzzTools { kDiscsAndBalls, kBursAndBlades };  // the latter: bur, drill, and the blades with a stroke
/// Returns a random scene: bone, tool, law and parameters, including their extremes.
FuzzScene MakeFuzzScene(Dice& dice, FuzzTools tools = FuzzTools::kDiscsAndBalls);
std::string ToText(const FuzzScene& scene);

/// One call of a sequence.
struct FuzzCall {
  enum class Kind { kTick, kSetDown, kRefill, kFidelity, kAccount };
  Kind kind = Kind::kTick;
  CoupledInput in;
  Fidelity fidelity = Fidelity::kFull;
};
std::string ToText(const FuzzCall& call);

/// A random hand that feeds, presses, rubs, leaps, rotates and releases, with failures of the device and of the host
/// program.
class FuzzHand {
 public:
  /// `max_leap_mm`: maximum leap in a tick.
  FuzzHand(Dice& dice, const FuzzScene& scene, double max_leap_mm = 100);
  FuzzCall Next(const Pose& X_WT);

 private:
  enum class Mode { kFeed, kPress, kHold, kRub, kTilt, kLeap, kTurn, kFar, kInside, kOut, kLetGo, kCount };
  void Choose(const Pose& X_WT);
  void Move(const Pose& X_WT);
  void Spoil(CoupledInput& in);

  Dice& dice_;
  Box3 box_;
  double voxel_mm_;
  double reach_mm_;
  CouplingParams coupling_;
  double max_leap_mm_;
  Mode mode_ = Mode::kFeed;
  int left_ = 0;  // ticks left in this mode
  Pose X_WH_;
  Pose X_mode_;  // start of the mode
  Vec3 v_mm_per_s_{0};
  Vec3 w_rad_per_s_{0};
  double amplitude_mm_ = 0;
  int tick_ = 0;
  double dt_s_ = 0.001;
  double rpm_ = 7500;
  int wrong_velocity_ = 0;  // 0: as the handle moves; 1: none; 2: random
};

// ---- invariants

/// Compares a bone's values before and after, leaf by leaf: bone is only removed (I5), and only near the tool (I6).
class BoneWitness {
 public:
  explicit BoneWitness(const Bone& bone);
  ~BoneWitness();
  /// Allows changes in `box`: the tool may have cut anywhere in it since the last Compare().
  void Allow(const Box3& box);
  /// Returns a message if an invariant is broken, otherwise an empty string. The next call compares with this `bone`.
  std::string Compare(const Bone& bone);

 private:
  struct State;
  std::unique_ptr<State> state_;
};

/// Returns a box around everything that a tool can cut or blur in `substeps` steps from one pose to the other.
Box3 CalcCutBox(const Tool& tool, const Pose& from, const Pose& to, int substeps, double voxel_mm);

/// A CoupledSimulation whose invariants are checked after each call.
class FuzzedSaw {
 public:
  explicit FuzzedSaw(const FuzzScene& scene);
  ~FuzzedSaw();
  /// Makes the call. Returns a message if an invariant is broken, otherwise an empty string.
  std::string Do(const FuzzCall& call);
  const Pose& X_WT() const;
  const CoupledOutput& last() const;
  /// Checks the volume, that phi only rises, and that changes are local. Returns a message as Do() does.
  std::string Account();
  std::uint64_t hash() const;  // of all outputs so far
  struct Counts {
    long ticks = 0, touched = 0, refused = 0, cut = 0, used_up = 0, unsolved = 0, out_of_leaves = 0, slab = 0;
  };
  const Counts& counts() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace kerf::test
