#include "device/drivers/device_check.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>
#include <numbers>
#include <numeric>
#include <utility>

#include "base/realtime/loop_clock.h"
#include "device/drivers/handle_at_rest.h"
#include "kerf/error.h"

namespace kerf {
namespace {

constexpr double kCommand_s = 0.001;
constexpr double kCircleTurns = 2;
constexpr double kRamp_s = 1;              // rise and fall time of the force
constexpr double kMaxBad = 0.01;           // maximum fraction of rounds without a good answer
constexpr double kMinSentFraction = 0.97;  // minimum fraction of the requested force; the gate withholds the rest
constexpr double kMinRate_hz = 50;         // minimum rate of samples
constexpr int kStillTries = 5;
constexpr double kTakeHold_s = 3;
constexpr double kMaxWait_s = 20;
constexpr double kStill_mm = 2;  // a larger motion is caused by a hand

class Check {
 public:
  Check(DeviceServo& servo, const DeviceCheckOptions& options) : servo_(servo), options_(options) {}

  DeviceCheckResult Run() {
    result_.homed = WaitForHandle();
    if (result_.homed) {
      MeasureAtRest();
      if (servo_.traits().makes_force && !result_.stopped && !gone_) MakeCircle();
      WatchButtons();
    }
    servo_.Command({});
    RelayMessages();
    result_.round = CalcPercentiles(servo_.round_times());
    const DeviceServo::Counts counts = servo_.counts();
    result_.rounds = counts.rounds;
    result_.closed_by = counts.closed_by;
    result_.largest_sent_N = counts.rounds.largest_N;
    Judge();
    return result_;
  }

 private:
  /// Waits until the next millisecond. Returns false if the test must end.
  bool Pass() {
    due_ns_ = std::max(due_ns_ + static_cast<std::int64_t>(1e9 * kCommand_s), clock_.Now());
    clock_.SleepUntil(due_ns_);
    RelayMessages();
    if (options_.goes_on && !options_.goes_on()) result_.stopped = true;
    gone_ = gone_ || servo_.state() == ServoState::kClosed;
    return !result_.stopped && !gone_;
  }
  double Now_s() { return 1e-9 * static_cast<double>(clock_.Now()); }
  void Say(const std::string& message) const {
    if (options_.say) options_.say(message);
  }
  void RelayMessages() {
    for (const std::string& message : servo_.TakeMessages()) Say(message);
  }

  bool WaitForHandle() {
    const double end_s = Now_s() + options_.homing_s;
    while (Pass()) {
      const ServoState state = servo_.state();
      if (state == ServoState::kWaiting || state == ServoState::kEngaged) return true;
      if (Now_s() < end_s) continue;
      result_.faults.push_back(fmt::format("the handle was not homed within {:g} s: {}", options_.homing_s,
                                           DescribeHoming(servo_.traits())));
      return false;
    }
    return false;
  }

  void MeasureAtRest() {
    if (servo_.traits().motion != DriverMotion::kPosition) return;
    Say(fmt::format("leave the handle alone for {:g} s", options_.still_s));
    // Measure again if the handle moved: after homing, the user may still hold it.
    for (int i = 0; i < kStillTries && !result_.stopped && !gone_ && Measure() > kStill_mm; ++i) {
    }
  }

  /// Returns the largest range of the handle's position along an axis, mm.
  double Measure() {
    double n = 0;
    Vec3 mean{0};
    Vec3 squares{0};
    Vec3 lower{std::numeric_limits<double>::infinity()};
    Vec3 upper{-std::numeric_limits<double>::infinity()};
    double min_step_mm = std::numeric_limits<double>::infinity();
    double last_at_s = -1;
    Vec3 last{0};
    const double begin_s = Now_s();
    while (Pass() && Now_s() < begin_s + options_.still_s) {
      const ServoSample sample = servo_.TakeSample();
      if (sample.at_s == last_at_s) continue;
      const Vec3 p = sample.sample.X_DH.p_AB;
      ++n;
      const Vec3 off = p - mean;
      mean += off / n;
      squares += off * (p - mean);
      lower = glm::min(lower, p);
      upper = glm::max(upper, p);
      for (int axis = 0; axis < 3 && last_at_s >= 0; ++axis) {
        const double step = std::abs(p[axis] - last[axis]);
        if (step > 1e-9) min_step_mm = std::min(min_step_mm, step);
      }
      last_at_s = sample.at_s;
      last = p;
    }
    result_.still_samples = static_cast<std::uint64_t>(n);
    if (n < 2) return 0;
    result_.rate_hz = n / (Now_s() - begin_s);
    result_.noise_mm = glm::sqrt(squares / n);
    result_.span_mm = upper - lower;
    result_.least_step_mm = std::isfinite(min_step_mm) ? min_step_mm : 0;
    return std::max({result_.span_mm.x, result_.span_mm.y, result_.span_mm.z});
  }

  /// Returns the direction of the force: one turn in the x-y plane, then one in the z-x plane.
  static Vec3 CalcForceDirection(double turn) {
    const double angle = 2 * std::numbers::pi * turn;
    return turn < 0.5 * kCircleTurns ? Vec3{std::cos(angle), std::sin(angle), 0}
                                     : Vec3{std::cos(angle), 0, std::sin(angle)};
  }

  void MakeCircle() {
    const double peak_N = options_.circle_fraction * servo_.profile().peak_force_N;
    Say(
        fmt::format("hold the handle loosely and keep it still in the middle, or press a button on it; after at least "
                    "{:g} s, a force of {:.2g} N {} for {:g} s; any key stops it",
                    kTakeHold_s, peak_N, options_.up ? "points up" : "turns in a circle", options_.circle_s));
    const double begin_wait_s = Now_s();
    HandleAtRest at_rest(servo_);
    while (servo_.state() != ServoState::kEngaged) {
      servo_.Command({});
      const bool still = at_rest.Update(servo_.TakeSample());
      const double waited_s = Now_s() - begin_wait_s;
      if (still && waited_s > kTakeHold_s) servo_.Agree();
      if (!Pass()) return;
      if (waited_s < kMaxWait_s) continue;
      result_.faults.emplace_back("the handle was never kept still in the middle, so no force was applied");
      return;
    }
    result_.made_force = true;
    const Vec3 start = servo_.TakeSample().sample.X_DH.p_AB;
    double along = 0;
    double across = 0;
    const double begin_s = Now_s();
    for (double t_s = 0; t_s < options_.circle_s && Pass(); t_s = Now_s() - begin_s) {
      const double ramp = std::clamp(std::min(t_s, options_.circle_s - t_s) / kRamp_s, 0.0, 1.0);
      const Vec3 force_direction =
          options_.up ? Vec3{0, 1, 0} : CalcForceDirection(kCircleTurns * t_s / options_.circle_s);
      // Read the state only once: if it changed between two reads, the loss would be reported twice.
      const ServoState state = servo_.state();
      if (state == ServoState::kClosed) {
        gone_ = true;
        break;
      }
      if (state != ServoState::kEngaged) {
        result_.faults.emplace_back("the connection to the device was lost during the force test");
        break;
      }
      DriverCommand command;
      command.f_D_N = ramp * peak_N * force_direction;
      servo_.Command(command);
      result_.largest_requested_N = std::max(result_.largest_requested_N, glm::length(command.f_D_N));
      const Vec3 moved = servo_.TakeSample().sample.X_DH.p_AB - start;
      result_.moved_mm = std::max(result_.moved_mm, glm::length(moved));
      along += glm::dot(moved, force_direction);
      across += glm::length(moved);
    }
    result_.followed = across > 0 ? along / across : 0;
  }

  void WatchButtons() {
    const DriverTraits& traits = servo_.traits();
    if (traits.buttons.empty() || !(options_.buttons_s > 0) || result_.stopped || gone_) return;
    Say(fmt::format("press each button ({}) within {:g} s", fmt::join(traits.buttons, ", "), options_.buttons_s));
    const auto all = static_cast<std::uint32_t>((1ull << traits.buttons.size()) - 1);
    const double end_s = Now_s() + options_.buttons_s;
    std::uint32_t before = 0;
    while (result_.buttons != all && Now_s() < end_s && Pass()) {
      servo_.Command({});
      const std::uint32_t now = servo_.TakeSample().sample.buttons;
      for (std::size_t i = 0; i < traits.buttons.size(); ++i) {
        if (((now & ~before) >> i & 1u) != 0) Say(fmt::format("button {}", traits.buttons[i]));
      }
      before = now;
      result_.buttons |= now & all;
    }
  }

  void Judge() {
    if (gone_) result_.faults.emplace_back("the device was disconnected during the test");
    if (result_.stopped || gone_) return;
    const ServoCounts& r = result_.rounds;
    const auto bad = static_cast<double>(r.no_answers + r.bad_answers);
    if (r.rounds > 0 && bad > kMaxBad * static_cast<double>(r.rounds)) {
      result_.faults.push_back(
          fmt::format("{} of {} rounds had no valid answer", r.no_answers + r.bad_answers, r.rounds));
    }
    if (result_.homed && servo_.traits().motion == DriverMotion::kPosition &&
        static_cast<double>(result_.still_samples) < kMinRate_hz * options_.still_s) {
      result_.faults.push_back(
          fmt::format("only {} samples arrived in {:g} s", result_.still_samples, options_.still_s));
    }
    if (std::max({result_.span_mm.x, result_.span_mm.y, result_.span_mm.z}) > kStill_mm) {
      result_.faults.emplace_back("the handle was never left alone: the values at rest are meaningless");
    }
    if (result_.made_force && result_.largest_sent_N < kMinSentFraction * result_.largest_requested_N) {
      std::string fault =
          fmt::format("of {:.2f} N requested, {:.2f} N was sent", result_.largest_requested_N, result_.largest_sent_N);
      if (result_.closed_by != GateReason::kNone) fault += fmt::format(" ({})", Describe(result_.closed_by));
      result_.faults.push_back(std::move(fault));
    }
  }

  DeviceServo& servo_;
  const DeviceCheckOptions& options_;
  MonotonicClock clock_;
  std::int64_t due_ns_ = 0;
  bool gone_ = false;
  DeviceCheckResult result_;
};

std::string NamePressed(const DriverTraits& traits, std::uint32_t buttons) {
  std::vector<std::string> names;
  for (std::size_t i = 0; i < traits.buttons.size(); ++i) {
    if ((buttons >> i & 1u) != 0) names.push_back(traits.buttons[i]);
  }
  return names.empty() ? "none" : fmt::format("{}", fmt::join(names, ", "));
}

/// Describes the position or deflection, the orientation and the buttons, according to what the device reports.
std::string DescribeSample(const DriverTraits& traits, const DriverSample& sample) {
  const Vec3& p = sample.X_DH.p_AB;
  const Quat& q = sample.X_DH.R_AB;
  std::string line = fmt::format("right {:+8.2f}  up {:+8.2f}  towards you {:+8.2f} mm", p.x, p.y, p.z);
  if (traits.motion == DriverMotion::kDeflection) {
    const std::array<double, 6>& d = sample.deflection;
    line = fmt::format(
        "right {:+5.2f}  up {:+5.2f}  towards you {:+5.2f}; rotation about these axes {:+5.2f} {:+5.2f} {:+5.2f}", d[0],
        d[1], d[2], d[3], d[4], d[5]);
  }
  if (traits.senses_orientation) line += fmt::format("; orientation {:.3f} {:.3f} {:.3f} {:.3f}", q.w, q.x, q.y, q.z);
  return fmt::format("{}; buttons {}", line, NamePressed(traits, sample.buttons));
}

}  // namespace

DeviceCheckResult CheckDevice(DeviceServo& servo, const DeviceCheckOptions& options) {
  CheckParameters(options);
  return Check(servo, options).Run();
}

void WatchDevice(DeviceServo& servo, const std::function<bool()>& goes_on,
                 const std::function<void(const std::string& line, bool transient)>& show) {
  constexpr std::int64_t kPeriod_ns = 100'000'000;
  MonotonicClock clock;
  const DriverTraits& traits = servo.traits();
  show(DescribeOpenDevice(servo.name(), servo), false);
  while (goes_on()) {
    for (const std::string& message : servo.TakeMessages()) show(message, false);
    const ServoSample s = servo.TakeSample();
    // Without a recent answer, the last sample is not the current position.
    const bool answers = 1e-9 * static_cast<double>(clock.Now()) - s.at_s < servo.options().servo.agree_s;
    std::string line = Describe(s.state);
    if (s.state != ServoState::kClosed) line += answers ? "; " + DescribeSample(traits, s.sample) : "; no answer";
    // Before the first round, the state is unknown.
    if (s.state != ServoState::kClosed || servo.state() == ServoState::kClosed) show(line, true);
    clock.SleepUntil(clock.Now() + kPeriod_ns);
  }
  const ServoCounts rounds = servo.counts().rounds;
  show(fmt::format("{} rounds, {} without an answer, {} with a bad one", rounds.rounds, rounds.no_answers,
                   rounds.bad_answers),
       false);
}

std::string DescribeOpenDevice(const std::string& name, const DeviceServo& servo) {
  const DeviceProfile& p = servo.profile();
  return servo.traits().makes_force ? fmt::format("{} ({}, up to {:g} N)", name, p.name, p.peak_force_N)
                                    : fmt::format("{} (outputs no force)", name);
}

std::string FormatDeviceCheckJson(const std::string& name, const DeviceServo& servo, const DeviceCheckResult& r) {
  const auto array = [](const Vec3& v) { return nlohmann::ordered_json{v.x, v.y, v.z}; };
  nlohmann::ordered_json j;
  j["device"] = name;
  j["profile"] = servo.profile().name;
  j["peak_force_N"] = servo.profile().peak_force_N;
  j["ok"] = r.faults.empty() && !r.stopped;
  j["stopped"] = r.stopped;
  j["homed"] = r.homed;
  j["still"] = {{"samples", r.still_samples},
                {"rate_hz", r.rate_hz},
                {"noise_mm", array(r.noise_mm)},
                {"span_mm", array(r.span_mm)},
                {"least_step_mm", r.least_step_mm}};
  j["force"] = {{"tried", r.made_force},
                {"asked_N", r.largest_requested_N},
                {"sent_N", r.largest_sent_N},
                {"moved_mm", r.moved_mm},
                {"followed", r.followed}};
  j["buttons"] = NamePressed(servo.traits(), r.buttons);
  j["round_us"] = {
      {"p50", r.round.p50_us}, {"p99", r.round.p99_us}, {"p99_9", r.round.p999_us}, {"max", r.round.max_us}};
  j["rounds"] = {{"all", r.rounds.rounds}, {"no_answer", r.rounds.no_answers}, {"bad_answer", r.rounds.bad_answers}};
  j["faults"] = r.faults;
  return j.dump(2) + "\n";
}

std::string FormatDeviceCheck(const std::string& name, const DeviceServo& servo, const DeviceCheckResult& r) {
  std::string text = DescribeOpenDevice(name, servo) + "\n";
  text += fmt::format("  homed     {}\n", r.homed ? "yes" : "no");
  if (r.still_samples > 1) {
    text += fmt::format(
        "  at rest   {} samples, {:.0f} a second; noise {:.4f} {:.4f} {:.4f} mm, span {:.3f} {:.3f} {:.3f} mm\n",
        r.still_samples, r.rate_hz, r.noise_mm.x, r.noise_mm.y, r.noise_mm.z, r.span_mm.x, r.span_mm.y, r.span_mm.z);
    text += r.least_step_mm > 0 ? fmt::format("            smallest step {:.4f} mm\n", r.least_step_mm)
                                : std::string("            no step: the handle did not move\n");
  }
  if (r.made_force) {
    text += fmt::format(
        "  force     up to {:.2f} N requested, {:.2f} N sent; the handle moved {:.1f} mm, {:.0f} % along the force\n",
        r.largest_requested_N, r.largest_sent_N, r.moved_mm, 100 * r.followed);
  } else if (!servo.traits().makes_force) {
    text += "  force     none: the device outputs none\n";
  }
  if (!servo.traits().buttons.empty()) {
    text += fmt::format("  buttons   {} of {}\n", NamePressed(servo.traits(), r.buttons),
                        fmt::join(servo.traits().buttons, ", "));
  }
  text += fmt::format(
      "  round     p50 {:.0f}  p99 {:.0f}  p99.9 {:.0f}  max {:.0f} us; {} rounds, {} without an answer, {} with a bad "
      "one\n",
      r.round.p50_us, r.round.p99_us, r.round.p999_us, r.round.max_us, r.rounds.rounds, r.rounds.no_answers,
      r.rounds.bad_answers);
  if (r.stopped) text += "  stopped   by a key\n";
  for (const std::string& fault : r.faults) text += fmt::format("  FAULT     {}\n", fault);
  return text;
}

}  // namespace kerf
