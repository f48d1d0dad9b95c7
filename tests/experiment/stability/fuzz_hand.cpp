#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "experiment/stability/fuzz.h"

namespace kerf::test {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr double kInf = std::numeric_limits<double>::infinity();
constexpr double kDenormal = std::numeric_limits<double>::denorm_min();

Vec3 InBox(Dice& dice, const Box3& box) {
  return box.centre() + 0.5 * box.size() * dice.InCube();
}

}  // namespace

std::string ToText(const FuzzCall& call) {
  const CoupledInput& in = call.in;
  const Pose& X = in.X_WH;
  const std::string pose = fmt::format("{{{{{:a}, {:a}, {:a}, {:a}}}, {{{:a}, {:a}, {:a}}}}}", X.R_AB.w, X.R_AB.x,
                                       X.R_AB.y, X.R_AB.z, X.p_AB.x, X.p_AB.y, X.p_AB.z);
  switch (call.kind) {
    case FuzzCall::Kind::kTick:
      return fmt::format(
          "Tick({{.X_WH = {}, .v_H_W_mm_per_s = {{{:a}, {:a}, {:a}}}, .w_H_W_rad_per_s = {{{:a}, {:a}, "
          "{:a}}}, .dt_s = {}, .rpm = {}}})",
          pose, in.v_H_W_mm_per_s.x, in.v_H_W_mm_per_s.y, in.v_H_W_mm_per_s.z, in.w_H_W_rad_per_s.x,
          in.w_H_W_rad_per_s.y, in.w_H_W_rad_per_s.z, in.dt_s, in.rpm);
    case FuzzCall::Kind::kSetDown:
      return fmt::format("SetDown({})", pose);
    case FuzzCall::Kind::kRefill:
      return "Refill()";
    case FuzzCall::Kind::kFidelity:
      return fmt::format("SetFidelity({})", ToString(call.fidelity));
    case FuzzCall::Kind::kAccount:
      return "bone()";
  }
  return "";
}

FuzzHand::FuzzHand(Dice& dice, const FuzzScene& scene, double max_leap_mm)
    : dice_(dice),
      box_(scene.box),
      voxel_mm_(scene.voxel_mm),
      reach_mm_(CalcReach(scene.params.tool)),
      coupling_(scene.params.coupling),
      max_leap_mm_(max_leap_mm),
      X_WH_(scene.start),
      X_mode_(scene.start) {}

void FuzzHand::Choose(const Pose& X_WT) {
  // Most of the time the hand works on the bone.
  mode_ = dice_.OneIn(2) ? dice_.One({Mode::kFeed, Mode::kFeed, Mode::kPress, Mode::kPress, Mode::kRub, Mode::kTilt})
                         : static_cast<Mode>(dice_.Below(static_cast<int>(Mode::kCount)));
  const bool short_one = mode_ == Mode::kLeap || mode_ == Mode::kTurn || mode_ == Mode::kFar;
  left_ = short_one ? 1 + dice_.Below(4) : 1 + dice_.Below(60);
  tick_ = 0;
  if (dice_.OneIn(3)) X_WH_ = X_WT;
  X_mode_ = X_WH_;
  v_mm_per_s_ = w_rad_per_s_ = Vec3(0);
  const Vec3 to_bone = InBox(dice_, box_) - X_WH_.p_AB;
  const double away = glm::length(to_bone);
  switch (mode_) {
    case Mode::kFeed:
      // The motion is towards the bone or along the disc's plane; it is slow, or whole voxels per tick.
      v_mm_per_s_ = away > 0 ? to_bone / away : Vec3(0, 0, -1);
      if (dice_.OneIn(2)) v_mm_per_s_ -= X_WH_.Vector({0, 0, 1}) * X_WH_.InverseVector(v_mm_per_s_).z;
      v_mm_per_s_ *= dice_.LogUniform(0.1, 200) * std::max(voxel_mm_, 0.2) / 0.2;
      break;
    case Mode::kPress:
      v_mm_per_s_ = dice_.LogUniform(1e-2, 3) * coupling_.max_force_N *
                    (dice_.OneIn(2) ? dice_.Direction() : X_WH_.Vector({0, 0, 1}));
      w_rad_per_s_ = (dice_.OneIn(2) ? 0.0 : dice_.LogUniform(1e-3, 1)) * dice_.Direction();
      break;
    case Mode::kRub:
      v_mm_per_s_ = dice_.Direction();
      amplitude_mm_ = voxel_mm_ * dice_.LogUniform(0.01, 20);
      break;
    case Mode::kTilt:
      w_rad_per_s_ = dice_.LogUniform(0.01, 10) * dice_.Direction();
      break;
    case Mode::kLeap:
      X_WH_.p_AB += dice_.LogUniform(0.1, max_leap_mm_) * dice_.Direction();
      if (dice_.OneIn(3)) X_WH_.R_AB = dice_.Rotation();
      break;
    case Mode::kTurn:
      X_WH_.R_AB = X_WH_.R_AB * glm::angleAxis(1.57079632679489661923 * dice_.One({1.0, -1.0, 2.0}),
                                               dice_.One({Vec3(1, 0, 0), Vec3(0, 1, 0), Vec3(0, 0, 1)}));
      X_WH_.R_AB = glm::normalize(X_WH_.R_AB);
      break;
    case Mode::kFar:
      X_WH_.p_AB += dice_.LogUniform(1, 50) * max_leap_mm_ * dice_.Direction();
      X_WH_.p_AB = glm::clamp(X_WH_.p_AB, Vec3(-kWorldReach_mm), Vec3(kWorldReach_mm));
      break;
    case Mode::kInside:
      X_WH_.p_AB = InBox(dice_, box_);
      break;
    case Mode::kOut:
      v_mm_per_s_ = (away > 0 ? -to_bone / away : Vec3(0, 0, 1)) * dice_.LogUniform(1, 500);
      break;
    case Mode::kHold:
    case Mode::kLetGo:
    case Mode::kCount:
      break;
  }
  // A hand that is too far away returns.
  if (glm::length(X_WH_.p_AB - box_.centre()) > 3 * (glm::length(box_.size()) + reach_mm_) && mode_ != Mode::kFar &&
      mode_ != Mode::kLeap) {
    X_WH_.p_AB = box_.centre() + dice_.Direction() * (0.5 * glm::length(box_.size()) + reach_mm_);
    X_mode_ = X_WH_;
  }
}

void FuzzHand::Move(const Pose& X_WT) {
  const double dt = std::min(dt_s_, 0.02);
  switch (mode_) {
    case Mode::kPress:
      X_WH_ = X_WT;
      X_WH_.p_AB += v_mm_per_s_ / coupling_.stiffness_N_per_mm;
      X_WH_.p_AB = glm::clamp(X_WH_.p_AB, Vec3(-kWorldReach_mm), Vec3(kWorldReach_mm));
      break;
    case Mode::kRub:
      X_WH_.p_AB = X_mode_.p_AB + amplitude_mm_ * std::sin(0.7 * tick_) * v_mm_per_s_;
      break;
    case Mode::kLetGo:
      X_WH_ = X_WT;
      break;
    default:
      X_WH_.p_AB += dt * v_mm_per_s_;
  }
  const double turn = glm::length(w_rad_per_s_) * (mode_ == Mode::kPress ? 1 : dt);
  if (turn > 0) X_WH_.R_AB = glm::normalize(X_WH_.R_AB * glm::angleAxis(turn, glm::normalize(w_rad_per_s_)));
  X_WH_.p_AB = glm::clamp(X_WH_.p_AB, Vec3(-kWorldReach_mm), Vec3(kWorldReach_mm));
  ++tick_;
}

/// Makes one number of an input invalid, or unusual but valid.
void FuzzHand::Spoil(CoupledInput& in) {
  const double bad = dice_.One({kNan, kInf, -kInf, 1e300, -1e18});
  const int axis = dice_.Below(3);
  switch (dice_.Below(14)) {
    case 0:
      in.X_WH.p_AB[axis] = bad;
      break;
    case 1:
      in.X_WH.R_AB = dice_.One({Quat(0, 0, 0, 0), Quat(2, 0, 0, 0), Quat(kNan, 0, 0, 0), Quat(1, 1, 0, 0),
                                Quat(0.99, 0, 0, 0), Quat(0, kInf, 0, 0)});
      break;
    case 2:
      in.v_H_W_mm_per_s[axis] = bad;
      break;
    case 3:
      in.w_H_W_rad_per_s[axis] = bad;
      break;
    case 4:
      in.dt_s = dice_.One({0.0, -0.0, 1e-9, 9.9e-7, kDenormal, -1e-9, -1e-3, kNan, kInf, 1.0000001, -kInf});
      break;
    case 5:
      in.rpm = dice_.One({kNan, kInf, 1.1e6, -1e300});
      break;
    case 6:
      in.X_WH.p_AB[axis] = dice_.One({kWorldReach_mm * (1 + 1e-9), -1.1 * kWorldReach_mm, 1e9});
      break;
    case 7:  // valid inputs from here on
      in.X_WH.p_AB[axis] = dice_.One({kDenormal, -kDenormal, 1e-310, -0.0});
      break;
    case 8:
      in.X_WH.R_AB = dice_.One(
          {Quat(1, kDenormal, -kDenormal, 0), Quat(-1, 0, 0, 0), Quat(0, 1e-200, 1, 0), Quat(-0.0, 0.6, -0.8, 0)});
      break;
    case 9:
      in.X_WH.R_AB *= dice_.One({1 - 9e-7, 1 + 9e-7});
      break;
    case 10:
      in.dt_s = dice_.One({1e-6, 1.0});
      break;
    case 11:
      in.rpm = dice_.One({1e6, -1e6, 0.999, -1.0, kDenormal});
      break;
    case 12:
      in.v_H_W_mm_per_s = 1e6 * dice_.InCube();
      break;
    case 13:
      in.w_H_W_rad_per_s = 1e6 * dice_.InCube();
      break;
    default:
      break;
  }
}

FuzzCall FuzzHand::Next(const Pose& X_WT) {
  FuzzCall call;
  if (left_-- <= 0) {
    Choose(X_WT);
    if (dice_.OneIn(4)) dt_s_ = dice_.One({1e-3, 1e-3, 1e-3, 2.5e-4, 4e-3, 0.02, 1e-6, 0.1, 1.0});
    if (dice_.OneIn(3)) rpm_ = dice_.One({7500.0, 7500.0, -7500.0, 0.0, 100.0, 60000.0, 1.0, 1e6});
    if (dice_.OneIn(4)) wrong_velocity_ = dice_.Below(3);
    if (dice_.OneIn(12)) {
      call.kind = FuzzCall::Kind::kFidelity;
      call.fidelity = dice_.One({Fidelity::kFull, Fidelity::kFull, Fidelity::kCoarse, Fidelity::kSlab});
      return call;
    }
    if (dice_.OneIn(16)) {
      call.kind = FuzzCall::Kind::kSetDown;
      call.in.X_WH = dice_.OneIn(2) ? X_WH_ : Pose{dice_.Rotation(), InBox(dice_, box_.Grown(reach_mm_))};
      if (dice_.OneIn(4)) Spoil(call.in);
      return call;
    }
    if (dice_.OneIn(16)) {
      call.kind = FuzzCall::Kind::kRefill;
      return call;
    }
    if (dice_.OneIn(40)) {
      call.kind = FuzzCall::Kind::kAccount;
      return call;
    }
  }
  const Vec3 from = X_WH_.Point(coupling_.p_TC_mm);
  Move(X_WT);
  CoupledInput& in = call.in;
  in.X_WH = X_WH_;
  in.dt_s = dt_s_;
  in.rpm = rpm_;
  if (wrong_velocity_ == 0) in.v_H_W_mm_per_s = (X_WH_.Point(coupling_.p_TC_mm) - from) / dt_s_;
  if (wrong_velocity_ == 2) in.v_H_W_mm_per_s = 1000.0 * dice_.InCube();
  in.v_H_W_mm_per_s = glm::clamp(in.v_H_W_mm_per_s, Vec3(-1e6), Vec3(1e6));
  in.w_H_W_rad_per_s = wrong_velocity_ == 1 ? Vec3(0) : w_rad_per_s_;
  if (dice_.OneIn(60)) Spoil(in);
  return call;
}

}  // namespace kerf::test
