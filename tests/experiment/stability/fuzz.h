// Hard case 40: sequences of random calls, and what must hold whatever they are.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "experiment/stability/dice.h"
#include "kerf/bone.h"
#include "kerf/coupled.h"

namespace kerf::test {

// ---- what a sequence is made of

/// A small bone of each kind that is hard: its number stands for kind and voxel.
Bone MakeFuzzBone(Dice& dice, double& voxel_mm);

struct FuzzScene {
  Bone bone;
  double voxel_mm = 0.2;
  Box3 box;  // of the bone
  CoupledParams params;
  Pose start;
};
/// Bone, tool, law and parameters to their extremes.
FuzzScene MakeFuzzScene(Dice& dice);
std::string ToText(const FuzzScene& scene);

/// One call.
struct FuzzCall {
  enum class Kind { kTick, kSetDown, kRefill, kFidelity, kAccount };
  Kind kind = Kind::kTick;
  CoupledInput in;
  Fidelity fidelity = Fidelity::kFull;
};
std::string ToText(const FuzzCall& call);

/// A hand out of its mind: it feeds, presses, rubs, leaps, turns, lets go, and the machine around it fails.
class FuzzHand {
 public:
  /// `most_leap_mm`: how far it may leap in a tick.
  FuzzHand(Dice& dice, const FuzzScene& scene, double most_leap_mm = 100);
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
  double most_leap_mm_;
  Mode mode_ = Mode::kFeed;
  int left_ = 0;  // ticks of the mode
  Pose X_WH_;
  Pose X_mode_;  // where it began
  Vec3 v_mm_per_s_{0};
  Vec3 w_rad_per_s_{0};
  double amplitude_mm_ = 0;
  int tick_ = 0;
  double dt_s_ = 0.001;
  double rpm_ = 7500;
  int wrong_velocity_ = 0;  // 0: as it moves; 1: none; 2: nonsense
};

// ---- what must hold

/// A bone's values before and after, leaf by leaf: bone only gets less (I5), and only where the tool was (I6).
class BoneWitness {
 public:
  explicit BoneWitness(const Bone& bone);
  ~BoneWitness();
  /// The tool may have cut anywhere in the box since the last Compare().
  void Allow(const Box3& box);
  /// Empty when all is well. `bone` becomes the one to compare with.
  std::string Compare(const Bone& bone);

 private:
  struct State;
  std::unique_ptr<State> state_;
};

/// The box of all that a tool can cut or blur on its way from one pose to the other in so many steps.
Box3 CalcCutBox(const Tool& tool, const Pose& from, const Pose& to, int substeps, double voxel_mm);

/// A CoupledSimulation that is held to its word with each call.
class FuzzedSaw {
 public:
  explicit FuzzedSaw(const FuzzScene& scene);
  ~FuzzedSaw();
  /// Empty when all is well, else what is not.
  std::string Do(const FuzzCall& call);
  const Pose& X_WT() const;
  const CoupledOutput& last() const;
  /// Volume, monotone phi, locality.
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
