// tooth_vibration: the force of single teeth, as lines of a spectrum.
//
// The tick's force is a mean over many passages, as if the teeth were continuous along the rim. N single teeth that
// pass one after the other have the same mean and, in addition, lines at multiples of the spindle frequency:
//
//   passing  order N, 2 N   F(t) = sum over teeth k of f(theta + 2 pi k / N), with f the force of a tooth at a place on
//                           the rim. The Fourier coefficients of F are the sums of f over the rim times
//                           e^(-i m N alpha).
//   runout   order 1        A rim that is off centre by e makes tooth k bite deeper than the previous one by up to
//                           2 e sin(pi / N), once per turn. The change is limited to the bite: a bite cannot be
//                           negative, and the next teeth cut the rest.
//   set      order N / 2    Teeth that are bent to alternate sides press sideways alternately.
//
// With a stroke, tooth k is at y = s + k pitch, and theta = pi s / pitch takes the place of the spindle's angle, with
// N = 2: passing has the orders 2 and 4, set has 1, and there is no runout. The lines are then chirps: their frequency
// is that of theta at the speed of the moment. One enters the tick's force if its frequency and the stroke's rate
// together (Carson's rule for the bandwidth) are below the same limits, and none does if the period of the stroke is
// shorter than two ticks.
//
// The sums are over the points of the rim that a step has found engaged. Therefore no single tooth is tracked, and no
// line can alias with the tick: each line has its own frequency, and only lines that the tick can represent enter its
// force (in full below 0.4 of its rate, none above 0.45). Sample() returns all lines, for output at a higher rate.
#include "cut/effects/tooth_vibration.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <variant>

#include "cut/effects/effects.h"
#include "cut/effects/parameters.h"
#include "cut/tool/along_edge.h"

namespace kerf {
namespace {

constexpr double kTickPassBand = 0.4;  // of the tick's rate
constexpr double kTickStopBand = 0.45;
constexpr double kSilent_N = 1e-6;

using Complex = std::complex<double>;

/// Multiplies two finite numbers.
Complex Multiply(const Complex& a, const Complex& b) {
  return {a.real() * b.real() - a.imag() * b.imag(), a.real() * b.imag() + a.imag() * b.real()};
}

/// Returns z^order; order >= 0. For a z of magnitude 1 it is off by at most about `order` times the rounding error.
Complex RaiseTo(int order, Complex z) {
  Complex power = 1;
  for (; order > 0; order /= 2) {
    if (order % 2 == 1) power = Multiply(power, z);
    z = Multiply(z, z);
  }
  return power;
}

/// Returns e^(-i angle) with the angle of a direction about the spindle.
Complex FindPhase(double x, double y) {
  const double length = std::sqrt(x * x + y * y);
  return length > 0 ? Complex(x / length, -y / length) : Complex(1);
}

}  // namespace

double ToothVibrationEffect::Line::Magnitude() const {
  double sum = 0;
  for (const Complex& a : amplitude_N) sum += std::norm(a);
  return std::sqrt(sum);
}

ToothVibrationEffect::ToothVibrationEffect(const ToothVibrationParams& params, const EffectSetup& setup)
    : params_(params),
      teeth_(static_cast<int>(std::lround(setup.shape.passes_per_turn))),
      drive_(setup.tool),
      amplitude_mm_(0.5 * CalcStroke(setup.tool)),
      pitch_mm_(CalcTooth(setup.tool).pitch_mm) {
  if (drive_.strokes()) teeth_ = 2;
  lines_[kRunout].order = drive_.strokes() ? 0 : 1;
  lines_[kSet].order = teeth_ % 2 == 0 && (teeth_ > 2 || drive_.strokes()) ? teeth_ / 2 : 0;
  lines_[kPassing].order = teeth_ > 1 ? teeth_ : 0;
  lines_[kPassing2].order = 2 * teeth_;
}

void ToothVibrationEffect::Reset() {
  for (Line& line : lines_) line.amplitude_N = {};
  awake_ = false;
}

void ToothVibrationEffect::Solved(const EffectSolved& solved) {
  summed_s_ += solved.time_s;
  if (solved.rpm == 0 || solved.teeth.empty()) return;
  awake_ = true;
  const StepProblem& problem = solved.problem;
  const bool strokes = drive_.strokes();
  const double sign = strokes || solved.rpm > 0 ? 1 : -1;
  // Change of the bite due to runout, as an outward speed.
  const double more_mm_per_s = 2e-3 * params_.runout_um * std::sin(std::numbers::pi / teeth_) * problem.passes_per_s;
  for (const ToothLoad& tooth : solved.teeth) {
    if (!(tooth.speed_mm_per_s > 0)) continue;
    // The powers of one phase, instead of a sine and a cosine for each line.
    const Complex phase =
        strokes ? std::polar(1.0, -std::numbers::pi * CalcAlongEdge(solved.edge.motion(), tooth.p_T) / pitch_mm_)
                : FindPhase(tooth.e_T.x, sign * tooth.e_T.y);
    const bool is_even = teeth_ % 2 == 0;
    const Complex set = RaiseTo(is_even ? teeth_ / 2 : 0, phase);
    const Complex passing = is_even ? Multiply(set, set) : RaiseTo(teeth_, phase);
    const std::array<Complex, kLines> phases{phase, set, passing, Multiply(passing, passing)};
    const Vec3 along(-sign * tooth.e_T.y, sign * tooth.e_T.x, 0);
    const Vec3 direction = -tooth.e_T - params_.tangential_share * along;
    const double change_mm_per_s = strokes ? 0 : std::min(more_mm_per_s, tooth.speed_mm_per_s);
    const double faster_mm_per_s = tooth.speed_mm_per_s + change_mm_per_s;
    const double slower_mm_per_s = tooth.speed_mm_per_s - change_mm_per_s;
    const double turning_N =
        0.5 * tooth.teeth *
        (problem.ToothForceAt(faster_mm_per_s, tooth.cut) - problem.ToothForceAt(slower_mm_per_s, tooth.cut));
    const auto add = [&](int line, double thrust_N, const Vec3& d) {
      const Complex load = solved.time_s * thrust_N * phases[static_cast<std::size_t>(line)];
      for (int axis = 0; axis < 3; ++axis)
        sums_[static_cast<std::size_t>(line)][static_cast<std::size_t>(axis)] += load * d[axis];
    };
    // The law's own cutting force, or a fixed fraction of the thrust.
    const auto add_load = [&](int line, double factor, double thrust_N, double cutting_N) {
      if (problem.law.HasCutting()) {
        add(line, factor, -thrust_N * tooth.e_T - cutting_N * along);
      } else {
        add(line, factor * thrust_N, direction);
      }
    };
    const auto cutting_at = [&](double speed_mm_per_s) {
      if (!problem.law.HasCutting()) return 0.0;
      return problem.cutting_share * problem.law.Cutting(speed_mm_per_s / problem.passes_per_s, tooth.cut);
    };
    if (lines_[kRunout].order > 0)
      add_load(kRunout, 1, turning_N, 0.5 * tooth.teeth * (cutting_at(faster_mm_per_s) - cutting_at(slower_mm_per_s)));
    if (lines_[kSet].order > 0) add(kSet, params_.set_share * tooth.thrust_N, Vec3(0, 0, 1));
    // The factor of 2 combines both signs of the order in the Fourier series.
    if (lines_[kPassing].order > 0) add_load(kPassing, 2, tooth.thrust_N, tooth.cutting_N);
    add_load(kPassing2, 2, tooth.thrust_N, tooth.cutting_N);
  }
}

void ToothVibrationEffect::End(EffectEnd& end) {
  const double turns_per_s = end.rpm / 60;
  theta_rad_ = std::remainder(theta_rad_ + 2 * std::numbers::pi * std::fmod(std::abs(turns_per_s) * end.dt_s, 1),
                              2 * std::numbers::pi);
  spindle_Hz_ = std::abs(turns_per_s);
  if (drive_.strokes()) phase_rad_ = Drive::Advance(phase_rad_, end.rpm, end.dt_s);
  force_N_ = 0;
  if (spindle_Hz_ == 0) Reset();
  if (!awake_) {
    sums_ = {};
    summed_s_ = 0;
    return;
  }
  const double fresh = 1 - std::exp(-end.dt_s / (1e-3 * params_.smoothing_ms));
  double largest_N = 0;
  Vec3 f_T_N(0);
  const Angle angle = FindAngle(0);
  const bool is_mean = drive_.strokes() && spindle_Hz_ * 2 * end.dt_s > 1;
  for (std::size_t n = 0; n < kLines; ++n) {
    Line& line = lines_[n];
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const Complex now = summed_s_ > 0 ? sums_[n][axis] / summed_s_ : 0;
      line.amplitude_N[axis] += fresh * (now - line.amplitude_N[axis]);
    }
    largest_N = std::max(largest_N, line.Magnitude());
    if (line.order == 0 || is_mean) continue;
    // Relative to the tick's rate.
    const double fraction = line.order * angle.rate_Hz * end.dt_s + angle.modulation_Hz * end.dt_s;
    const double carried = std::clamp((kTickStopBand - fraction) / (kTickStopBand - kTickPassBand), 0.0, 1.0);
    if (carried == 0) continue;
    const Complex turn = std::polar(carried, line.order * angle.theta_rad);
    for (int axis = 0; axis < 3; ++axis)
      f_T_N[axis] += (line.amplitude_N[static_cast<std::size_t>(axis)] * turn).real();
  }
  f_T_N.y *= angle.way;
  sums_ = {};
  summed_s_ = 0;
  const double force_N = glm::length(f_T_N);
  if (force_N > params_.max_N) f_T_N *= params_.max_N / force_N;
  force_N_ = std::min(force_N, params_.max_N);
  end.f_extra_W_N += end.X_FT.Vector(f_T_N);
  if (largest_N < kSilent_N) Reset();
}

Vec3 ToothVibrationEffect::Sample(double delay_s) const {
  Vec3 f_T_N(0);
  if (!awake_) return f_T_N;
  const Angle angle = FindAngle(delay_s);
  for (const Line& line : lines_) {
    if (line.order == 0) continue;
    const Complex turn = std::polar(1.0, line.order * angle.theta_rad);
    for (int axis = 0; axis < 3; ++axis)
      f_T_N[axis] += (line.amplitude_N[static_cast<std::size_t>(axis)] * turn).real();
  }
  f_T_N.y *= angle.way;
  return f_T_N;
}

/// Returns the angle `delay_s` after the end of the tick.
ToothVibrationEffect::Angle ToothVibrationEffect::FindAngle(double delay_s) const {
  if (!drive_.strokes()) {
    return {theta_rad_ + 2 * std::numbers::pi * std::fmod(spindle_Hz_ * delay_s, 1), spindle_Hz_, 0, 1};
  }
  const double phase_rad = Drive::Advance(phase_rad_, 60 * spindle_Hz_, delay_s);
  const double rad_per_mm = std::numbers::pi / pitch_mm_;
  const double mm_per_rad = amplitude_mm_ * std::cos(phase_rad);  // of the phase
  return {rad_per_mm * drive_.CalcDisplacement(phase_rad), rad_per_mm * std::abs(mm_per_rad) * spindle_Hz_, spindle_Hz_,
          mm_per_rad < 0 ? -1.0 : 1.0};
}

void ToothVibrationEffect::Report(std::span<double> channels) const {
  channels[0] = force_N_;
  channels[1] = lines_[kRunout].Magnitude();
  channels[2] = lines_[kSet].Magnitude();
  channels[3] = lines_[kPassing].Magnitude();
  channels[4] = (drive_.strokes() ? drive_.passes_per_period() : teeth_) * spindle_Hz_;
}

const EffectInfo& ToothVibration() {
  static const EffectInfo kEffect{
      .name = "tooth_vibration",
      .summary = "single teeth passing, runout and set of the teeth, as lines at multiples of the spindle frequency",
      .source = "Fourier series of the engaged arc; runout, set and the tangential fraction are assumptions",
      .reads = "teeth, their thrust and position, spindle speed",
      .writes = "force on the hand, in lines that the tick can represent; all lines for sound",
      .state = "four lines and the spindle's angle",
      .sleeps = "while nothing is cut",
      .hooks = kEffectSolved | kEffectEnd | kEffectPush,
      .parameters = ListEffectParameters<ToothVibrationParams>(),
      .channels = {{"force_N", "contribution to the tick's force"},
                   {"runout_N", "amplitude of the line at the spindle frequency"},
                   {"set_N", "amplitude of the line at half the tooth-passing frequency"},
                   {"passing_N", "amplitude of the line at the tooth-passing frequency"},
                   {"passing_Hz", "teeth that pass a point per second, mean over a stroke"}},
      .make = [](std::span<const EffectValue> values, const EffectSetup& setup) -> std::unique_ptr<Effect> {
        return std::make_unique<ToothVibrationEffect>(ReadEffectParameters<ToothVibrationParams>(values), setup);
      }};
  return kEffect;
}

}  // namespace kerf
