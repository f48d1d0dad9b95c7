#include "experiment/stability/held_tool.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <vector>

#include "cut/tool/shape.h"
#include "experiment/stability/scenario_run.h"
#include "experiment/stability/swings.h"
#include "kerf/error.h"
#include "loop/haptics/coupling_limits.h"

namespace kerf {
namespace {

constexpr double kPush_N = kHardPush_N;
constexpr double kMinPush_N = 0.5;       // simulated newtons
constexpr double kSidePush_N = 2;        // simulated newtons, on the wall of a kerf
constexpr double kSideways_mm = 1;       // maximum deflection of the coupling on the wall of a kerf
constexpr double kFractionOfPeak = 0.3;  // maximum push as a fraction of the peak force of device or coupling
constexpr double kApproach_mm_per_s = kFastFeed_mm_per_s;
constexpr double kStretch_mm = 1;  // way of the handle over which its feed and that of the tool are compared
constexpr double kFollows = 0.9;   // fraction of the handle's feed at which the tool follows it steadily
constexpr double kTouches_N = 0.02;
constexpr double kTick_s = 0.001;  // of the approach
constexpr int kMaxTicks = 40000;   // of the approach
constexpr double kKick_rad = 1e-5;
constexpr double kLongestWindow_mm = 100;  // an encoder step so large that no sample leaves the velocity window
constexpr double kMinFaceCosine = 0.985;  // cosine between feed and contact direction; below it the contact is an edge,
                                          // not a face
constexpr double kMaxDrift_mm = 0.3;      // a tool that has moved further than this has left its place
constexpr double kOffBone = 0.1;          // fraction of the push; if the force is lower, the tool is off the bone

/// Returns the width of a blade that is not round, from its edge to its back; of any other tool, its reach. mm.
double CalcExtent(const Tool& tool) {
  const ConvexOutline outline = MakeToolOutline(tool);
  if (outline.empty()) return CalcReach(tool);
  double extent_mm = 0;
  for (int i = 0; i < outline.size(); ++i) extent_mm = std::max(extent_mm, -outline.corner(i).x);
  return extent_mm;
}

/// Returns the depth at which the tool is held in a state, mm along the feed from the first contact.
double CalcDepth(const StabilitySubject& subject, HeldState state) {
  const double voxel_mm = subject.bone.voxel_mm();
  if (state == HeldState::kCutting) return std::max(1.0, 2 * voxel_mm);
  // The walls of a kerf hold a rotating disc only at depths of 3.25 voxels or more.
  return std::max(6 * voxel_mm, 0.5 * CalcExtent(subject.setup.coupled.tool));
}

/// Returns a direction perpendicular to the feed, along the spindle if possible.
Vec3 CalcSideways(const StabilitySubject& subject) {
  for (const Vec3& axis_T : {Vec3(0, 0, 1), Vec3(1, 0, 0)}) {
    const Vec3 axis = subject.X_WT_start.Vector(axis_T);
    const Vec3 across = axis - glm::dot(axis, subject.into_W) * subject.into_W;
    if (glm::length(across) > 0.3) return glm::normalize(across);
  }
  throw Error("the direction of the feed is not a unit vector");
}

/// Returns the direction from a disc's or ball's centre to the point of its edge that is deepest in the bone or nearest
/// to it; of another tool, the mean outward direction of its edge there. Unit length.
Vec3 FindContact(const Bone& bone, const Tool& tool, const Pose& X_WT) {
  const ToolShape shape = MakeToolShape(tool, {});
  const std::vector<EdgePoint>& edge = shape.edge;
  std::vector<double> depths;
  for (const EdgePoint& point : edge) depths.push_back(-bone.SignedDistance(X_WT.Point(point.p_T)));
  const auto deepest = std::max_element(depths.begin(), depths.end());
  if (GetForm(tool) != ToolForm::kRound && shape.edge_form != EdgeForm::kChain) {
    return glm::normalize(X_WT.Vector(edge[static_cast<std::size_t>(deepest - depths.begin())].p_T));
  }
  Vec3 sum_T(0);
  for (std::size_t i = 0; i < edge.size(); ++i) {
    if (depths[i] > *deepest - 0.5 * bone.voxel_mm()) sum_T += edge[i].e_T;
  }
  return glm::normalize(X_WT.Vector(sum_T));
}

/// Magnitudes that result from the push, the spring and the handle of a loop.
struct Sizes {
  double scale = 1;               // device N per simulation N
  double push_N = 0;              // on the device
  double compression_mm = 0;      // of the coupling under the push
  double stiffness_N_per_mm = 0;  // that the device feels
  double mass = 0;                // of handle and hand, N s^2 / mm
  double period_s = 0;            // of the oscillation on that spring
};

Sizes CalcSizes(const HeldTool& held, const ClosedLoopSetup& setup) {
  Sizes z;
  z.scale = ForceMap(setup.profile, setup.force_map).force_scale();
  const double K = setup.coupled.coupling.stiffness_N_per_mm;
  // Friction pulls the tool along a wall with a fraction of the normal force, so with a soft spring the tool would come
  // out of the kerf.
  const double bears_N = held.slips ? kSideways_mm * K : held.push_N;
  const double push_N = std::min({held.push_N, bears_N, kFractionOfPeak * setup.profile.peak_force_N / z.scale,
                                  kFractionOfPeak * setup.coupled.coupling.max_force_N});
  z.push_N = push_N * z.scale;
  z.compression_mm = push_N / (setup.loop_gain * K);
  z.stiffness_N_per_mm = setup.loop_gain * z.scale * K;
  z.mass = 1e-3 * (setup.profile.mass_kg + setup.hand.mass_kg);
  z.period_s = 2 * std::numbers::pi * std::sqrt(z.mass / (z.stiffness_N_per_mm + setup.hand.stiffness_N_per_mm));
  return z;
}

enum class Grip {
  kOwn,   // the hand of the setup
  kCalm,  // with the hand's spring, but overdamped
};

/// The tool held in that loop, pushed, and at rest except for the feed.
class Held {
 public:
  Held(const HeldTool& held, const ClosedLoopSetup& setup, const Sizes& sizes, Grip grip = Grip::kOwn)
      : held_(held), sizes_(sizes), loop_(held.bone, setup, CalcStart(held, sizes)) {
    loop_.simulation().SetDown(held.X_WT);
    // The calm hand is damped so strongly that the spring soon comes to rest and no oscillation of the loop remains.
    const double K = sizes.stiffness_N_per_mm;
    const double lag_s = setup.period_s * (1 + 2 * setup.delay_ticks);
    const double m = 1e-3 * setup.profile.mass_kg;
    HandModel calm = setup.hand;
    calm.mass_kg = 0;
    calm.stiffness_N_per_mm = 0;
    calm.damping_Ns_per_mm = std::max(8 * K * lag_s, 2.0 * std::sqrt(K * m));
    calm.torsion_damping_Nmms *= 8;
    loop_.device().SetHand(calm);
    loop_.device().SetIntention({.X_WH = loop_.X_WH_start(), .push_W_N = sizes.push_N * held.push_W});
    const double b = calm.damping_Ns_per_mm;
    const double rate = (b - std::sqrt(std::max(0.0, b * b - 4 * K * m))) / (2 * m);
    const int ticks = static_cast<int>(std::clamp(10 / rate, 20 * setup.period_s, 0.5) / setup.period_s);
    for (int i = 0; i < ticks; ++i) {
      tick_ = loop_.Step(held.rpm);
      // Friction on the rotating disc, or an oblique edge, would move the tool from its place, so the hand compensates
      // these forces.
      const Vec3 across = tick_.f_device_N - glm::dot(tick_.f_device_N, held.push_W) * held.push_W;
      balance_N_ -= 0.2 * (balance_N_ + across);
      loop_.device().SetIntention({.X_WH = loop_.X_WH_start(), .push_W_N = sizes.push_N * held.push_W + balance_N_});
    }
    calm.stiffness_N_per_mm = setup.hand.stiffness_N_per_mm;
    loop_.device().SetHand(grip == Grip::kCalm ? calm : setup.hand);
    X_WH_ = loop_.X_WH_start();
    X_WH_.p_AB = tick_.p_WC_mm - X_WH_.Vector(setup.coupled.coupling.p_TC_mm);
    Intend(Vec3(0), 0);
  }

  /// Runs one tick, with an additional force `kick_N` along the push and the hand rotated by `turn_rad` about all three
  /// axes.
  const ClosedLoopTick& Step(double kick_N = 0, double turn_rad = 0) {
    if (kick_N != 0 || turn_rad != 0) Intend(kick_N * held_.push_W, turn_rad);
    tick_ = loop_.Step(held_.rpm);
    if (kick_N != 0 || turn_rad != 0) Intend(Vec3(0), 0);
    return tick_;
  }

  double position_mm() const { return glm::dot(tick_.p_WC_mm, held_.push_W); }
  double force_N() const { return -glm::dot(tick_.f_device_N, held_.push_W); }
  const Vec3& tool_mm() const { return tick_.out.coupled.X_WT.p_AB; }
  /// Returns how far the tool has moved along the push since it was first held in place.
  double travel_mm() const { return glm::dot(tool_mm() - held_.X_WT.p_AB, held_.push_W); }
  const ClosedLoopTick& tick() const { return tick_; }

 private:
  static Pose CalcStart(const HeldTool& held, const Sizes& sizes) {
    Pose X = held.X_WT;
    X.p_AB += sizes.compression_mm * held.push_W;
    return X;
  }

  void Intend(const Vec3& kick_N, double turn_rad) {
    Pose X = X_WH_;
    if (turn_rad != 0) X.R_AB = X.R_AB * glm::angleAxis(turn_rad, glm::normalize(Vec3(1)));
    loop_.device().SetIntention({.X_WH = X,
                                 .push_W_N = sizes_.push_N * held_.push_W + balance_N_ + kick_N,
                                 .yield_s = held_.feeds ? kYield_s : 0});
  }

  const HeldTool& held_;
  Sizes sizes_;
  ClosedLoop loop_;
  ClosedLoopTick tick_;
  Vec3 balance_N_{0};  // across the push
  Pose X_WH_;
};

ClosedLoopSetup MakeLinear(ClosedLoopSetup setup) {
  setup.profile.friction_N = 0;
  // Without quantisation, positions are exact. With an encoder, however, the velocity is an average over a time window,
  // which is longest for the smallest motions and delays the coupling's damper accordingly. Here the window always has
  // its maximum length, which keeps the loop linear. If the encoder steps are negligible, there is no window.
  setup.profile.resolution_mm = setup.profile.resolution_mm > 1e-4 ? kLongestWindow_mm : 0;
  setup.quantise = false;
  setup.force_map.ramp_in_s = 0;
  return setup;
}

double CalcRotationAngle(const Quat& a, const Quat& b) {
  const Quat q = b * glm::conjugate(a);
  return 2 * std::sqrt(q.x * q.x + q.y * q.y + q.z * q.z);
}

/// Returns the maximum distance of `x` in [from, to) from its least-squares line.
double CalcSway(const std::vector<double>& x, std::size_t from, std::size_t to) {
  const double n = static_cast<double>(to - from);
  const double middle = 0.5 * (n - 1);
  double mean = 0;
  double slope = 0;
  for (std::size_t i = from; i < to; ++i) mean += x[i] / n;
  for (std::size_t i = from; i < to; ++i) slope += (static_cast<double>(i - from) - middle) * (x[i] - mean);
  slope /= std::max(1.0, n * (n * n - 1) / 12);
  double max = 0;
  for (std::size_t i = from; i < to; ++i) {
    max = std::max(max, std::abs(x[i] - mean - slope * (static_cast<double>(i - from) - middle)));
  }
  return max;
}

/// Returns true if, with an overdamped hand, the tool stays in the place where a loop appeared unstable, for a duration
/// of `seconds` and a distance of `travel_mm` along the push. If it leaves its place then too, the cause is the bone's
/// shape (an edge that the tool slid off, or bone that it cut through), and the result says nothing about the loop.
bool StaysInPlace(const HeldTool& held, ClosedLoopSetup setup, double seconds, double travel_mm) {
  constexpr double kLonger = 4;       // an overdamped hand feeds more slowly, and slides off more slowly
  constexpr double kBeyond_mm = 0.2;  // margin, since `travel_mm` is the furthest place to which the tool was pushed,
                                      // not the one at which it came off
  constexpr double kGone_s = 0.02;
  setup.force_map.ramp_in_s = 0;
  setup.loop_gain = std::min(setup.loop_gain, 1.0);
  setup.delay_ticks = 0;
  const Sizes sizes = CalcSizes(held, setup);
  Held calm(held, setup, sizes, Grip::kCalm);
  const Vec3 start_mm = calm.tool_mm();
  const int gone = std::max(static_cast<int>(kGone_s / setup.period_s), 2);
  const int ticks = std::max(static_cast<int>(kLonger * seconds / setup.period_s), 2 * gone);
  int off = 0;
  for (int i = 0; i < ticks; ++i) {
    calm.Step();
    off = calm.force_N() < kOffBone * sizes.push_N ? off + 1 : 0;
    const Vec3 moved = calm.tool_mm() - start_mm;
    const Vec3 across = moved - glm::dot(moved, held.push_W) * held.push_W;
    if (off >= gone || glm::length(held.feeds ? across : moved) > kMaxDrift_mm) return false;
    if (held.feeds && off == 0 && calm.travel_mm() > travel_mm + kBeyond_mm) return true;
  }
  return true;
}

/// Observes the result of a kick, either with friction and encoder steps or, in a linear loop, after it has been found
/// to be unstable.
Behaviour WatchKick(const HeldTool& held, ClosedLoopSetup setup, double kick_mm, double min_sway_mm, double& seconds,
                    double& travel_mm) {
  setup.force_map.ramp_in_s = 0;
  const Sizes sizes = CalcSizes(held, setup);
  Held run(held, setup, sizes);
  const double T = setup.period_s;
  const double kick_N = setup.profile.friction_N + sizes.mass * kick_mm * 2 * std::numbers::pi / (sizes.period_s * T);
  const double window_s = std::max(1.5 * sizes.period_s, 0.04);
  const std::size_t window = static_cast<std::size_t>(window_s / T);
  constexpr std::size_t kWindows = 8;
  std::vector<double> x;
  x.reserve(kWindows * window);
  double min_N = 1e300;
  double max_N = 0;
  run.Step(kick_N);
  seconds = static_cast<double>(kWindows * window) * T;
  std::vector<double> sway;
  for (std::size_t w = 0; w < kWindows; ++w) {
    min_N = 1e300;
    max_N = 0;
    for (std::size_t i = 0; i < window; ++i) {
      run.Step();
      x.push_back(run.position_mm());
      travel_mm = std::max(travel_mm, run.travel_mm());
      min_N = std::min(min_N, run.force_N());
      max_N = std::max(max_N, run.force_N());
    }
    sway.push_back(CalcSway(x, w * window, (w + 1) * window));
    // A tool that is off the bone does not oscillate, but it is not stable either.
    if (max_N < kOffBone * sizes.push_N) return Behaviour::kUnstable;
    if (sway.back() <= min_sway_mm) return Behaviour::kStable;
    if (w >= 3 && sway[w] < 0.5 * sway[w - 2] && sway[w] < 0.5 * kick_mm) return Behaviour::kStable;
  }
  // The tool bounces off the bone and back, or reaches the maximum force of the device. Nothing else limits the growth.
  const bool hammers = min_N < 0.05 * sizes.push_N || max_N > 0.95 * setup.profile.peak_force_N;
  if (hammers && sway.back() > 2 * kick_mm) return Behaviour::kUnstable;
  if (sway.back() < 0.9 * sway[kWindows / 2]) return Behaviour::kStable;
  if (sway.back() > 1.1 * sway[kWindows / 2] && sway.back() > 2 * kick_mm) return Behaviour::kUnstable;
  return Behaviour::kLimitCycle;
}

/// Does the same as WatchKick(), but returns kNotHeld if the bone's shape is the cause of the result.
Behaviour Watch(const HeldTool& held, const ClosedLoopSetup& setup, double kick_mm, double min_sway_mm) {
  double seconds = 0;
  double travel_mm = -1e300;
  const Behaviour behaviour = WatchKick(held, setup, kick_mm, min_sway_mm, seconds, travel_mm);
  if (behaviour == Behaviour::kStable || StaysInPlace(held, setup, seconds, travel_mm)) return behaviour;
  return Behaviour::kNotHeld;
}

}  // namespace

HeldTool HoldTool(const StabilitySubject& subject, HeldState state) {
  HeldTool held;
  held.feeds = state == HeldState::kCutting;
  held.rpm = state == HeldState::kStoppedOnBone ? 0 : std::abs(subject.rpm) >= 1 ? subject.rpm : 7500;
  held.slips = state == HeldState::kInKerf;
  held.push_N = held.slips ? kSidePush_N : kPush_N;
  held.push_W = state == HeldState::kInKerf ? CalcSideways(subject) : subject.into_W;

  Vec3 along_W = subject.into_W;  // of the approach

  CoupledParams params = subject.setup.coupled;
  params.coupling = {};
  const double lead_mm = kPush_N / params.coupling.stiffness_N_per_mm;
  const double depth_mm = CalcDepth(subject, state);
  CoupledSimulation simulation(subject.bone, params, subject.X_WT_start);
  CoupledInput in;
  in.X_WH = subject.X_WT_start;
  in.dt_s = kTick_s;
  in.rpm = held.rpm;
  Vec3 start_mm = subject.X_WT_start.p_AB;
  double travel_mm = 0;    // of the handle from `start_mm`
  double touched_mm = -1;  // travel of the tool at the first contact
  double removed_mm3 = 0;
  int resting = 0;
  double before_mm = 0;
  double push_N = 0;
  CoupledOutput out;
  for (int i = 0; i < kMaxTicks; ++i) {
    in.X_WH.p_AB = start_mm + travel_mm * along_W;
    out = simulation.Tick(in);
    removed_mm3 += out.removed_mm3;
    const double tool_mm = glm::dot(out.X_WT.p_AB - start_mm, along_W);
    push_N = -glm::dot(out.f_H_W_N, along_W);
    const bool first = touched_mm < 0 && push_N > kTouches_N;
    if (first) touched_mm = tool_mm;
    if (held.rpm != 0 && touched_mm >= 0 && tool_mm - touched_mm >= depth_mm) break;
    resting = std::abs(tool_mm - before_mm) < 1e-6 ? resting + 1 : 0;
    if (held.rpm == 0 && push_N > 0.99 * kPush_N && resting > 20) break;
    before_mm = tool_mm;
    travel_mm = std::min(travel_mm + kApproach_mm_per_s * kTick_s, tool_mm + lead_mm);
    if (!first || held.rpm != 0) continue;
    // On an edge the tool is pushed along the contact normal, because along the feed it would slide off.
    const Vec3 contact_W = FindContact(simulation.UpdateBone(), params.tool, out.X_WT);
    if (glm::dot(contact_W, along_W) >= kMinFaceCosine) continue;
    held.push_W = along_W = contact_W;
    start_mm = in.X_WH.p_AB;
    travel_mm = 0;
  }
  if (touched_mm < 0) {
    throw Error(removed_mm3 > 0
                    ? fmt::format("the tool cuts bone with less than {} N, which is too little to examine", kTouches_N)
                    : "the tool touches no bone along the feed from its start");
  }
  // The push is at most the force of the slow approach: a faster tool would cut through the bone before the result is
  // known.
  if (held.feeds) held.push_N = std::clamp(push_N, kMinPush_N, kPush_N);
  held.X_WT = out.X_WT;
  held.bone = std::move(simulation).TakeBone();
  return held;
}

std::optional<double> FindFeedForce_N(const StabilitySubject& subject) {
  CoupledParams params = subject.setup.coupled;
  params.coupling = {};
  CoupledSimulation simulation(subject.bone, params, subject.X_WT_start);
  CoupledInput in;
  in.X_WH = subject.X_WT_start;
  in.dt_s = kTick_s;
  in.rpm = subject.rpm;
  bool touched = false;
  double handle_mm = 0;  // travel along the feed
  // Travel of both at the beginning of the present stretch.
  double handle_before_mm = 0;
  double tool_before_mm = 0;
  for (int i = 0; i < kMaxTicks; ++i) {
    in.X_WH.p_AB = subject.X_WT_start.p_AB + handle_mm * subject.into_W;
    const CoupledOutput out = simulation.Tick(in);
    const double tool_mm = glm::dot(out.X_WT.p_AB - subject.X_WT_start.p_AB, subject.into_W);
    const double push_N = -glm::dot(out.f_H_W_N, subject.into_W);
    if (touched && push_N < kTouches_N) return std::nullopt;  // through the bone, or off it
    if (params.coupling.stiffness_N_per_mm * (handle_mm - tool_mm) > kHardPush_N) return std::nullopt;
    const double way_mm = handle_mm - handle_before_mm;
    const bool first = !touched && push_N > kTouches_N;
    if (touched && way_mm >= kStretch_mm && tool_mm - tool_before_mm >= kFollows * way_mm) return push_N;
    if (first || way_mm >= kStretch_mm) {
      handle_before_mm = handle_mm;
      tool_before_mm = tool_mm;
    }
    touched = touched || first;
    handle_mm += kFastFeed_mm_per_s * kTick_s;
  }
  return std::nullopt;
}

std::optional<double> FindGrowth(const HeldTool& held, const ClosedLoopSetup& asked) {
  const ClosedLoopSetup setup = MakeLinear(asked);
  const Sizes sizes = CalcSizes(held, setup);
  Held unkicked(held, setup, sizes);
  Held kicked(held, setup, sizes);
  // The kick is so small that only the linear part of the difference is visible, but far larger than rounding errors.
  const double kick_mm = std::min(1e-3 * sizes.compression_mm, 1e-3);
  const double kick_N = sizes.mass * kick_mm * 2 * std::numbers::pi / (sizes.period_s * setup.period_s);
  const bool turns = setup.profile.degrees_of_freedom == 6 && setup.hand.torsion_Nmm_per_rad > 0;
  unkicked.Step();
  kicked.Step(kick_N, turns ? kKick_rad : 0);

  constexpr double kPeriods = 6;
  constexpr std::size_t kFirst = 1;  // first swing that counts, since the one before it still contains the kick
  constexpr double kGone = 1e-6;     // fraction of the kick's speed; smaller swings are rounding
  const int ticks = static_cast<int>(std::max(kPeriods * sizes.period_s, 0.1) / setup.period_s);
  Swings swings;
  double fastest = 0;
  double travel_mm = -1e300;
  bool lost = false;
  std::vector<double> speed;
  std::vector<double> turn;
  speed.reserve(static_cast<std::size_t>(ticks));
  turn.reserve(static_cast<std::size_t>(ticks));
  const auto max_in = [](const std::vector<double>& values, double from, double to) {
    const double n = static_cast<double>(values.size());
    double result = 0;
    for (auto i = static_cast<std::size_t>(from * n); i < static_cast<std::size_t>(to * n); ++i) {
      result = std::max(result, values[i]);
    }
    return result;
  };
  for (int i = 0; i < ticks; ++i) {
    const ClosedLoopTick& a = unkicked.Step();
    const ClosedLoopTick& b = kicked.Step();
    const double t_s = i * setup.period_s;
    const double v = glm::dot(b.v_WC_mm_per_s - a.v_WC_mm_per_s, held.push_W);
    travel_mm = std::max(travel_mm, unkicked.travel_mm());
    lost = unkicked.force_N() < kOffBone * sizes.push_N;
    if (lost) break;  // the tool is through the bone, or it hammers
    fastest = std::max(fastest, std::abs(v));
    const std::size_t before = swings.size();
    swings.Add(t_s, v);
    // With a strong damper the handle creeps back without a swing.
    if (swings.size() > before && swings.log_swing(before) < std::log(kGone * fastest)) {
      return std::log(kGone) / std::max(t_s, setup.period_s);
    }
    speed.push_back(std::abs(v));
    turn.push_back(CalcRotationAngle(a.out.X_WH.R_AB, b.out.X_WH.R_AB));
    if (swings.size() == before || swings.size() < kFirst + 4) continue;
    // Stop if the result is clear.
    const double change = swings.log_swing(swings.size() - 1) - swings.log_swing(kFirst);
    if (std::abs(change) > 2) break;
  }
  const double length_s = static_cast<double>(speed.size()) * setup.period_s;
  const auto reported = [&](double growth) -> std::optional<double> {
    if (growth < 0 || StaysInPlace(held, setup, length_s, travel_mm)) return growth;
    return std::nullopt;
  };
  // No growth rate is fitted to the rotation: it either comes to rest within a few ticks or grows up to the limit of
  // the torque.
  const double turned = max_in(turn, 0, 1);
  if (turned > 30 * kKick_rad) return reported(std::log(turned / kKick_rad) / length_s);
  if (swings.size() >= kFirst + 3) return reported(swings.CalcGrowth(kFirst));
  if (speed.size() < 8) return lost ? reported(0) : 0;
  const double late = std::max(max_in(speed, 0.75, 1), 1e-300);
  const double growth = std::log(late / std::max(max_in(speed, 0.25, 0.5), 1e-300)) / (0.5 * length_s);
  // An unstable loop oscillates; a tool whose motion grows without reversing is sliding.
  if (growth >= 0 && swings.size() < 2 && !lost) return std::nullopt;
  return reported(growth);
}

Behaviour TryHeld(const HeldTool& held, const ClosedLoopSetup& setup, bool linear) {
  if (linear) {
    const std::optional<double> growth = FindGrowth(held, setup);
    if (!growth) return Behaviour::kNotHeld;
    if (*growth < 0) return Behaviour::kStable;
    const ClosedLoopSetup without = MakeLinear(setup);
    const double kick_mm = 1e-2 * CalcSizes(held, without).compression_mm;
    const Behaviour behaviour = Watch(held, without, kick_mm, 0);
    return behaviour == Behaviour::kStable ? Behaviour::kLimitCycle : behaviour;
  }
  const double step_mm = setup.quantise ? setup.profile.resolution_mm : 0;
  const double compression_mm = CalcSizes(held, setup).compression_mm;
  const double kick_mm = std::min(0.3 * compression_mm, std::max(10 * step_mm, 0.03 * compression_mm));
  // During the feed the handle passes encoder steps, each of which moves it a little; without friction, nothing holds
  // the handle within one step. In both cases, motion of up to one encoder step is not an oscillation.
  const bool rests = !held.feeds && setup.profile.friction_N > 0;
  const double min_mm = std::max(rests ? 0.02 * step_mm : step_mm, 1e-4 * kick_mm);
  return Watch(held, setup, kick_mm, min_mm);
}

Margins FindHeldMargins(const HeldTool& held, const ClosedLoopSetup& setup, bool linear, double max_gain) {
  enum class Verdict { kStable, kNotStable, kNotHeld };
  const auto find = [&](double gain, int delay_ticks) {
    ClosedLoopSetup tried = setup;
    tried.loop_gain *= gain;
    tried.delay_ticks += delay_ticks;
    if (linear) {
      const std::optional<double> growth = FindGrowth(held, tried);
      return !growth ? Verdict::kNotHeld : *growth < 0 ? Verdict::kStable : Verdict::kNotStable;
    }
    const Behaviour behaviour = TryHeld(held, tried, false);
    return behaviour == Behaviour::kStable    ? Verdict::kStable
           : behaviour == Behaviour::kNotHeld ? Verdict::kNotHeld
                                              : Verdict::kNotStable;
  };
  constexpr double kGainStep = 1.25;
  constexpr double kMinGain = 1.0 / 64;
  constexpr double kGainTolerance = 1.02;
  Margins margins;
  const Verdict as_it_is = find(1, 0);
  if (as_it_is == Verdict::kNotHeld) {
    margins.unjudged =
        held.feeds ? "the tool cuts through the bone too soon" : "the tool does not stay in place on the bone";
    return margins;
  }
  // The search starts at the gain given by the rule for a sampled spring.
  const double scale = ForceMap(setup.profile, setup.force_map).force_scale();
  const CouplingLimits limits = CalcCouplingLimits(setup.profile, setup.hand, setup.coupled.coupling, scale, 0,
                                                   setup.period_s, setup.delay_ticks);
  const double rule = limits.sampled_stiffness_N_per_mm / setup.coupled.coupling.stiffness_N_per_mm / setup.loop_gain;
  // The largest gain known to be stable and the smallest one known to be unstable; 0 if there is none. The search ends
  // if the tool cannot be held.
  double low = as_it_is == Verdict::kStable ? 1 : 0;
  double high = as_it_is == Verdict::kStable ? 0 : 1;  // if already unstable, no higher gain is tried
  bool is_held = true;
  const auto try_gain = [&](double gain) {
    const Verdict found = find(gain, 0);
    is_held = found != Verdict::kNotHeld;
    if (found == Verdict::kStable) low = gain;
    if (found == Verdict::kNotStable) high = gain;
  };
  if (low > 0 && low < max_gain) try_gain(std::clamp(rule / std::sqrt(kGainStep), kGainStep, max_gain));
  while (is_held && high == 0 && low < max_gain) try_gain(std::min(low * kGainStep, max_gain));
  while (is_held && low == 0 && high > kMinGain) try_gain(std::max(high / kGainStep, kMinGain));
  while (is_held && low > 0 && high > kGainTolerance * low) try_gain(std::sqrt(low * high));
  if (!is_held && low == 0) {
    margins.unjudged = "the tool does not stay in place on the bone";
    return margins;
  }
  margins.gain_beyond = high == 0 || !is_held;
  margins.gain = margins.gain_beyond ? low : std::sqrt(low * high);
  // Tries 1, 2, 4, ... ticks until one is too many, then bisects.
  const int max_ticks = kMaxDelay_ticks - setup.delay_ticks;
  int too_many = max_ticks + 1;
  const auto try_delay = [&](int ticks) {
    const Verdict found = find(1, ticks);
    margins.delay_beyond = found == Verdict::kNotHeld;
    if (found == Verdict::kStable) margins.delay_ticks = ticks;
    if (found == Verdict::kNotStable) too_many = ticks;
  };
  for (int ticks = 1; ticks <= max_ticks && too_many > max_ticks && !margins.delay_beyond;
       ticks = std::min(2 * ticks, max_ticks)) {
    try_delay(ticks);
    if (ticks == max_ticks) break;
  }
  while (too_many > margins.delay_ticks + 1 && !margins.delay_beyond && too_many <= max_ticks) {
    try_delay((margins.delay_ticks + too_many) / 2);
  }
  margins.delay_beyond = margins.delay_beyond || margins.delay_ticks == max_ticks;
  return margins;
}

}  // namespace kerf
