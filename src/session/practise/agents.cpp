#include "session/practise/agents.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <numbers>
#include <random>
#include <vector>

#include "kerf/error.h"

namespace kerf {
namespace {

constexpr double kDegree = std::numbers::pi / 180;
/// Height of the tool above the surface before and after the cut.
constexpr double kClear_mm = 3;
/// Speed in free air.
constexpr double kFree_mm_per_s = 12;
/// Time that the hand takes to turn the tool into the cut's direction.
constexpr double kTurn_s = 0.6;
/// Fraction to which the feed rate falls near the goal. The force decreases in the same way, but not below a fraction
/// of 0.3.
constexpr double kMinSpeedFraction = 0.12;
/// Time after which the agent stops waiting at the end of a step.
constexpr double kMaxWait_s = 25;
constexpr double kArrival_mm = 0.1;
/// Largest distance from the end of the line at which it begins to slow down.
constexpr double kLineLookahead_mm = 0.5;
constexpr double kMaxCorrection_mm = 6;
/// Number of sine components of the tremor per axis.
constexpr std::size_t kTones = 3;

constexpr std::array<std::string_view, 3> kNames{"novice", "intermediate", "expert"};

/// Tremor of 8 to 12 Hz along each axis, output as the force that moves the hand's mass with this amplitude.
class Tremor {
 public:
  Tremor(double rms_mm, std::uint64_t seed) : amplitude_mm_(rms_mm * std::sqrt(2.0) / kTones) {
    std::mt19937_64 random(seed);
    const auto draw = [&] { return static_cast<double>(random() >> 11) * 0x1p-53; };
    for (Tone& tone : tones_) tone = {2 * std::numbers::pi * (8 + 4 * draw()), 2 * std::numbers::pi * draw()};
  }
  Vec3 CalcForce(double t_s, double mass_kg) const noexcept {
    Vec3 f_N{0};
    for (std::size_t i = 0; i < tones_.size(); ++i) {
      const Tone& tone = tones_[i];
      f_N[static_cast<int>(i % 3)] +=
          1e-3 * mass_kg * tone.w * tone.w * amplitude_mm_ * std::sin(tone.w * t_s + tone.phase);
    }
    return f_N;
  }

 private:
  struct Tone {
    double w;  // rad/s
    double phase;
  };
  double amplitude_mm_;
  std::array<Tone, 3 * kTones> tones_{};
};

/// Delay line: stores past positions and returns the delayed one.
class Memory {
 public:
  explicit Memory(double delay_s)
      : delay_s_(delay_s), places_(static_cast<std::size_t>(kTickRateRange_hz.upper * kMaxAgentDelay_s)) {}
  void Put(const Vec3& p, double dt_s) noexcept {
    at_ = (at_ + 1) % places_.size();
    places_[at_] = p;
    kept_ = std::min(kept_ + 1, places_.size());
    dt_s_ = dt_s;
  }
  void Clear() noexcept { kept_ = 0; }
  Vec3 Get() const noexcept {
    if (kept_ == 0) return Vec3(0);
    const auto back = std::min(static_cast<std::size_t>(delay_s_ / dt_s_), kept_ - 1);
    return places_[(at_ + places_.size() - back) % places_.size()];
  }

 private:
  double delay_s_;
  double dt_s_ = 0.001;
  std::vector<Vec3> places_;
  std::size_t at_ = 0;
  std::size_t kept_ = 0;
};

/// A step of the exercise: the tool's lowest point moves straight to {s, t} of a cut.
struct Step {
  std::size_t cut;
  double s_mm;
  double t_mm;
  bool cuts;
};

/// Whether the tool moves along the line at depth.
bool MovesAlong(const WantedCut& cut) {
  return cut.length_mm > 0 && cut.plunges == 1;
}

class Agent final : public HandDriver {
 public:
  Agent(SimulatedDevice& device, const AgentParams& params, const Scene& scene, const Vec3& p_TC_mm,
        double felt_stiffness_N_per_mm, std::atomic<bool>* done)
      : device_(device),
        params_(params),
        cuts_(MakeWantedCuts(scene.exercise, MakeTool(scene))),
        feed_mm_per_s_(params.feed_share * scene.exercise.feed_mm_per_s),
        p_TC_mm_(p_TC_mm),
        felt_stiffness_N_per_mm_(felt_stiffness_N_per_mm),
        done_(done),
        tremor_(params.tremor_mm, params.seed),
        memory_(params.delay_s) {
    for (std::size_t i = 0; i < cuts_.size(); ++i) {
      cuts_[i] = Misplace(cuts_[i], params.offset_mm, params.roll_deg, params.yaw_deg);
      const double deep_mm = cuts_[i].depth_mm + params.deeper_mm;
      for (int plunge = 0; plunge < cuts_[i].plunges; ++plunge) {
        const double s_mm = plunge == 0 ? 0 : cuts_[i].length_mm * plunge / (cuts_[i].plunges - 1);
        steps_.push_back({i, s_mm, -kClear_mm, false});
        steps_.push_back({i, s_mm, deep_mm, true});
        for (int pass = 0; pass < params.passes && MovesAlong(cuts_[i]); ++pass) {
          steps_.push_back({i, pass % 2 == 0 ? cuts_[i].length_mm : 0, deep_mm, true});
        }
        steps_.push_back({i, steps_.back().s_mm, -kClear_mm, false});
      }
    }
    DeviceSample sample;
    const Pose X_start = device_.Read(sample) ? sample.X_WH : cuts_.front().CalcToolPose(0, 0);
    TakeUp(cuts_.front(), X_start.Point(p_TC_mm_), X_start.R_AB);
    device_.SetIntention({.X_WH = X_start});
  }

  void Advance(double dt_s) noexcept override {
    if (!(dt_s > 0)) return;
    time_s_ += dt_s;
    turned_ = std::min(turned_ + dt_s / kTurn_s, 1.0);
    const Quat R_WT = glm::slerp(R_start_, R_cut_, turned_);
    const Vec3 now = ToAim(device_.p_WC_mm(), R_WT);
    // The agent sees the tool, not the handle; the bone displaces the tool from the handle against the coupling's
    // spring.
    memory_.Put(ToAim(device_.p_WC_mm() + device_.force_N() / felt_stiffness_N_per_mm_, R_WT), dt_s);
    const Vec3 seen = memory_.Get();
    Vec3 before = aim_ + correction_;
    const WantedCut* const cut = cut_;
    if (step_ < steps_.size()) FollowStep(now, seen, dt_s);
    if (cut_ != cut) before = aim_ + correction_;  // the frame has changed
    const Vec3 wanted = aim_ + correction_;
    Intention intention;
    intention.X_WH = ToPose(wanted, R_WT);
    intention.v_W_mm_per_s = cut_->ToWorld((wanted - before) / dt_s) - cut_->start_W;
    intention.push_W_N = tremor_.CalcForce(time_s_, device_.profile().mass_kg + device_.hand().mass_kg);
    device_.SetIntention(intention);
  }

 private:
  /// Begins with a cut: turns the tool into its direction, and moves from the present place, of the coupling's point.
  void TakeUp(const WantedCut& cut, const Vec3& p_WC, const Quat& R_WT) noexcept {
    cut_ = &cut;
    R_start_ = R_WT;
    R_cut_ = cut.CalcToolPose(0, 0).R_AB;
    turned_ = 0;
    aim_ = from_ = ToAim(p_WC, R_WT);
    correction_ = Vec3(0);
    memory_.Clear();
  }

  /// Returns {s, t, w} of the lowest point of the tool in the cut's direction if the coupling's point of the handle is
  /// at p_WC.
  Vec3 ToAim(const Vec3& p_WC, const Quat& R_WT) const noexcept {
    const Vec3 p_WT = p_WC - R_WT * p_TC_mm_;
    return cut_->ToCut(p_WT) + Vec3(0, cut_->below_mm, 0);
  }
  Pose ToPose(const Vec3& aim, const Quat& R_WT) const noexcept {
    return {R_WT, cut_->ToWorld(aim - Vec3(0, cut_->below_mm, 0))};
  }

  void FollowStep(const Vec3& now, const Vec3& seen, double dt_s) noexcept {
    if (pause_s_ > 0) {
      pause_s_ -= dt_s;
      if (step_ > 0 && steps_[step_ - 1].cuts) Correct(from_ - seen, dt_s);
      return;
    }
    const Step& step = steps_[step_];
    const Vec3 to(step.s_mm, step.t_mm, 0);
    const Vec3 motion = to - from_;
    const double length_mm = glm::length(motion);
    step_s_ += dt_s;
    if (length_mm < 1e-9) return Next();
    const Vec3 u = motion / length_mm;
    const double left_mm = glm::dot(to - seen, u);
    // Near the goal the agent slows down and reduces its force. It does so late at the end of the line: where the feed
    // falls, less force lifts the tool against the coupling's spring, so that it sinks.
    double fraction = 1;
    const double lookahead_mm = u.y > 0.5 ? params_.lookahead_mm : std::min(params_.lookahead_mm, kLineLookahead_mm);
    if (step.cuts && lookahead_mm > 0) fraction = std::clamp(left_mm / lookahead_mm, kMinSpeedFraction, 1.0);
    const double speed_mm_per_s = step.cuts ? feed_mm_per_s_ * fraction : kFree_mm_per_s;
    const double stiffness_N_per_mm = std::max(device_.hand().stiffness_N_per_mm, 0.05);
    const double lead_mm = std::max(fraction, 0.3) * params_.push_N / stiffness_N_per_mm;
    // The agent keeps moving until it sees the tool at the goal, and waits while the tool lags behind.
    const double ahead_mm = glm::dot(aim_ + correction_ - now, u);
    if (!step.cuts || ahead_mm < lead_mm) aim_ += u * speed_mm_per_s * dt_s;
    // Perceived error perpendicular to the direction of motion.
    const Vec3 off = (to - seen) - glm::dot(to - seen, u) * u;
    Correct(off, dt_s);
    const bool arrived = !step.cuts && glm::dot(to - aim_, u) <= 0;
    if (left_mm <= kArrival_mm || arrived ||
        step_s_ > length_mm / (0.5 * speed_mm_per_s * kMinSpeedFraction) + kMaxWait_s) {
      Next();
    }
  }

  void Correct(const Vec3& off, double dt_s) noexcept {
    const Vec3 corrected = correction_ + params_.correction_Hz * dt_s * off;
    if (glm::length(corrected) < kMaxCorrection_mm) correction_ = corrected;
  }

  void Next() noexcept {
    const Step& step = steps_[step_];
    // If the hand overshot, return to the goal; keep the correction perpendicular to the direction of motion.
    const bool stays_in_cut = step_ + 1 < steps_.size() && steps_[step_ + 1].cuts && step.cuts;
    aim_ = from_ = Vec3(step.s_mm, step.t_mm, 0);
    if (!stays_in_cut) correction_ = Vec3(0);
    step_s_ = 0;
    pause_s_ = params_.pause_s;
    ++step_;
    if (step_ < steps_.size() && steps_[step_].cut != step.cut) {
      TakeUp(cuts_[steps_[step_].cut], device_.p_WC_mm(), R_cut_);
    }
    if (step_ >= steps_.size() && done_ != nullptr) done_->store(true);
  }

  SimulatedDevice& device_;
  AgentParams params_;
  std::vector<WantedCut> cuts_;
  const WantedCut* cut_ = nullptr;  // that of the present step
  double feed_mm_per_s_;
  Vec3 p_TC_mm_;
  double felt_stiffness_N_per_mm_;
  std::atomic<bool>* done_;
  Tremor tremor_;
  Memory memory_;
  std::vector<Step> steps_;
  std::size_t step_ = 0;
  Quat R_start_;
  Quat R_cut_;
  Vec3 from_{0};  // start of this step
  Vec3 aim_{0};   // {s, t, w}
  Vec3 correction_{0};
  double turned_ = 0;
  double time_s_ = 0;
  double step_s_ = 0;
  double pause_s_ = 0;
};

}  // namespace

std::span<const std::string_view> AgentNames() {
  return kNames;
}

AgentParams MakeAgentParams(std::string_view name, std::uint64_t seed) {
  AgentParams p;
  p.name = std::string(name);
  p.seed = seed;
  if (name == "novice") {
    p.push_N = 4;
    p.feed_share = 1.4;
    p.tremor_mm = 0.3;
    p.delay_s = 0.3;
    p.lookahead_mm = 0;
    p.offset_mm = 1.4;
    p.roll_deg = 6;
    p.yaw_deg = 4;
    p.deeper_mm = 0.8;
    p.pause_s = 2.5;
    p.passes = 3;
    p.correction_Hz = 0.6;
  } else if (name == "intermediate") {
    p.push_N = 3;
    p.feed_share = 1.2;
    p.tremor_mm = 0.15;
    p.delay_s = 0.22;
    p.lookahead_mm = 1;
    p.offset_mm = 0.6;
    p.roll_deg = 2.5;
    p.yaw_deg = 1.8;
    p.deeper_mm = 0.4;
    p.pause_s = 1;
    p.passes = 2;
    p.correction_Hz = 0.8;
  } else if (name == "expert") {
    p.offset_mm = 0.15;
    p.roll_deg = 0.6;
    p.yaw_deg = 0.5;
    p.deeper_mm = 0.05;
    p.correction_Hz = 4;
  } else {
    throw Error(
        fmt::format("there is no agent \"{}\"; the agents are {}", name.substr(0, 60), fmt::join(kNames, ", ")));
  }
  std::mt19937_64 random(seed);
  const auto vary = [&](double& value) { value *= 0.8 + 0.4 * (static_cast<double>(random() >> 11) * 0x1p-53); };
  const auto vary_with_sign = [&](double& value) {
    vary(value);
    if (random() % 2 == 0) value = -value;
  };
  vary(p.tremor_mm);
  vary(p.delay_s);
  vary(p.deeper_mm);
  vary(p.pause_s);
  vary_with_sign(p.offset_mm);
  vary_with_sign(p.roll_deg);
  vary_with_sign(p.yaw_deg);
  return p;
}

WantedCut Misplace(const WantedCut& wanted, double offset_mm, double roll_deg, double yaw_deg) {
  WantedCut cut = wanted;
  const Quat turn =
      glm::angleAxis(yaw_deg * kDegree, wanted.into_W) * glm::angleAxis(-roll_deg * kDegree, wanted.along_W);
  // A hole is tilted about its place on the surface.
  const double middle_mm = wanted.length_mm > 0 ? 0.5 * wanted.depth_mm : 0;
  const Vec3 about_W = wanted.ToWorld({0.5 * wanted.length_mm, middle_mm, 0});
  cut.start_W = about_W + turn * (wanted.start_W - about_W) + offset_mm * wanted.across_W;
  cut.along_W = turn * wanted.along_W;
  cut.into_W = turn * wanted.into_W;
  cut.across_W = turn * wanted.across_W;
  return cut;
}

double CalcAgentTime(const AgentParams& params, const Scene& scene) {
  const double feed_mm_per_s = params.feed_share * scene.exercise.feed_mm_per_s;
  const double slow_mm = params.lookahead_mm * (params.passes + 1);
  double time_s = 30;
  for (const WantedCut& cut : MakeWantedCuts(scene.exercise, MakeTool(scene))) {
    const double cut_mm = kClear_mm + cut.depth_mm + params.passes * cut.length_mm;
    time_s += cut.plunges *
              (3 * (cut_mm + slow_mm / kMinSpeedFraction) / feed_mm_per_s + (params.passes + 4) * params.pause_s);
  }
  return time_s;
}

MakeHand MakeAgent(const AgentParams& params, const Scene& scene, std::atomic<bool>* done) {
  if (!scene.exercise.given) throw Error(fmt::format("{}: is not an exercise: it has no [exercise]", scene.name));
  CheckParameters(params, "agent");
  return [params, scene, done](SimulatedDevice& device, const LoopSetup&, const Vec3& p_TC_mm,
                               double felt_stiffness_N_per_mm) -> std::unique_ptr<HandDriver> {
    return std::make_unique<Agent>(device, params, scene, p_TC_mm, felt_stiffness_N_per_mm, done);
  };
}

}  // namespace kerf
