#include "experiment/stability/adversary.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>
#include <span>
#include <vector>

#include "experiment/stability/measures.h"

namespace kerf {
namespace {

constexpr double kRampIn_s = 0.15;  // duration over which the push is ramped in; the motion begins afterwards
constexpr double kFade_s = 0.3;     // duration over which the motion fades out
constexpr double kListen_s = 0.7;
constexpr std::size_t kPieces = 7;  // parts of the force that are analysed separately
constexpr double kMinExchanged_mJ = 0.01;
constexpr std::size_t kParents = 4;
constexpr double kFirstStep = 0.25;  // first step of a gene; it shrinks to kLastStep
constexpr double kLastStep = 0.03;

double LogBetween(double lower, double upper, double gene) {
  return lower * std::pow(upper / lower, gene);
}

/// Returns a function of t that rises smoothly from 0 to 1.
double Smooth(double t) {
  const double held = std::clamp(t, 0.0, 1.0);
  return held * held * (3 - 2 * held);
}

/// Returns two directions that are perpendicular to `n` and to each other.
std::pair<Vec3, Vec3> Across(const Vec3& n) {
  const Vec3 a = glm::normalize(glm::cross(n, std::abs(n.z) < 0.7 ? Vec3(0, 0, 1) : Vec3(1, 0, 0)));
  return {a, glm::cross(n, a)};
}

/// Generates random numbers that are the same with every standard library.
class Random {
 public:
  explicit Random(std::uint64_t seed) : bits_(seed) {}
  double Unit() { return static_cast<double>(bits_() >> 11U) * 0x1p-53; }
  double Normal() {
    const double radius = std::sqrt(-2 * std::log(1 - Unit()));
    return radius * std::cos(2 * std::numbers::pi * Unit());
  }
  std::size_t Below(std::size_t count) { return static_cast<std::size_t>(Unit() * static_cast<double>(count)); }

 private:
  std::mt19937_64 bits_;
};

/// Reflects a gene at the ends of its range.
double Reflect(double gene) {
  const double folded = std::abs(std::fmod(gene, 2.0));
  return folded > 1 ? 2 - folded : folded;
}

/// Returns the hand's intention at a time.
Intention CalcIntention(const StabilitySubject& subject, const Attack& attack, double t_s) {
  const double on = Smooth((t_s - kRampIn_s) / 0.1) * (1 - Smooth((t_s - (kAttack_s - kFade_s)) / kFade_s));
  const double phase = 2 * std::numbers::pi * attack.saw_Hz * (t_s - kRampIn_s);
  const Vec3& p_TC = subject.setup.coupled.coupling.p_TC_mm;
  const Vec3 n_T(0, 0, 1);
  Intention wanted;
  const double tilt = attack.tilt_rad * Smooth((t_s - kRampIn_s) / 0.4);
  const Vec3 axis_W = glm::cross(subject.X_WT_start.Vector(n_T), subject.into_W);
  const double length = glm::length(axis_W);
  wanted.X_WH = subject.X_WT_start;
  if (length > 1e-6 && tilt != 0) {
    wanted.X_WH.R_AB = glm::normalize(glm::angleAxis(tilt, axis_W / length) * subject.X_WT_start.R_AB);
    wanted.X_WH.p_AB += subject.X_WT_start.Vector(p_TC) - wanted.X_WH.Vector(p_TC);
  }
  wanted.X_WH.p_AB += on * std::sin(phase) * attack.saw_W_mm;
  wanted.v_W_mm_per_s = on * 2 * std::numbers::pi * attack.saw_Hz * std::cos(phase) * attack.saw_W_mm;
  wanted.push_W_N = Smooth(t_s / kRampIn_s) * attack.push_N * attack.push_W;
  wanted.yield_s = 0.2;
  return wanted;
}

double CalcRpm(const Attack& attack, double t_s) {
  if (t_s > kAttack_s - kFade_s || attack.switch_s == 0) return attack.ends_on ? attack.rpm : 0;
  return std::fmod(t_s, 2 * attack.switch_s) < attack.switch_s ? attack.rpm : 0;
}

}  // namespace

Attack MakeAttack(const StabilitySubject& subject, const AttackGenes& g) {
  Attack attack;
  HandModel& hand = attack.hand;
  hand.name = "adversary";
  hand.mass_kg = LogBetween(0.02, 1, g[0]);
  hand.damping_Ns_per_mm = 1e-3 * LogBetween(0.5, 20, g[1]);
  hand.stiffness_N_per_mm = g[2] < 0.1 ? 0 : 1e-3 * LogBetween(1, 1000, (g[2] - 0.1) / 0.9);
  hand.torsion_Nmm_per_rad = 1000;
  hand.torsion_damping_Nmms = 10;
  const DeviceProfile& profile = subject.setup.profile;
  const double max_N = profile.continuous_force_N > 0 ? profile.continuous_force_N : profile.peak_force_N;
  attack.push_N = profile.friction_N + LogBetween(0.02, 1, g[3]) * std::min(max_N, 20.0);
  const auto [a, b] = Across(subject.into_W);
  const double lean = 80 * std::numbers::pi / 180 * g[4];
  const double azimuth = 2 * std::numbers::pi * g[5];
  attack.push_W = std::cos(lean) * subject.into_W + std::sin(lean) * (std::cos(azimuth) * a + std::sin(azimuth) * b);
  const double z = 2 * g[6] - 1;
  const double turn = std::numbers::pi * g[7];  // half the sphere, since the motion is back and forth
  const double flat = std::sqrt(1 - z * z);
  const Vec3 direction = z * subject.into_W + flat * (std::cos(turn) * a + std::sin(turn) * b);
  attack.saw_W_mm = LogBetween(0.01, 10, g[8]) * direction;
  attack.saw_Hz = LogBetween(0.5, 10, g[9]);
  attack.tilt_rad = (2 * g[10] - 1) * 10 * std::numbers::pi / 180;
  attack.rpm = g[11] < 0.3 ? 0 : (g[11] < 0.5 ? -1 : 1) * LogBetween(100, 60000, std::fmod(g[11], 0.5) / 0.5);
  attack.switch_s = g[12] < 0.5 ? 0 : LogBetween(0.01, 0.5, std::fmod(g[12] - 0.5, 0.25) / 0.25);
  attack.ends_on = g[12] < 0.75;
  return attack;
}

std::string ToText(const Attack& a) {
  const double length = glm::length(a.saw_W_mm);
  return fmt::format(
      "{:.3g} kg, {:.3g} N s/m, {:.3g} N/m; pushes with {:.3g} N along ({:.2f}, {:.2f}, {:.2f}); saws {:.3g} mm along "
      "({:.2f}, {:.2f}, {:.2f}) at {:.3g} Hz; tilts by {:.2g} degrees; {:.4g} rpm{}",
      a.hand.mass_kg, 1e3 * a.hand.damping_Ns_per_mm, 1e3 * a.hand.stiffness_N_per_mm, a.push_N, a.push_W.x, a.push_W.y,
      a.push_W.z, length, a.saw_W_mm.x / length, a.saw_W_mm.y / length, a.saw_W_mm.z / length, a.saw_Hz,
      a.tilt_rad * 180 / std::numbers::pi, a.rpm,
      a.switch_s > 0 ? fmt::format(", switched every {:.2g} s, finally {}", a.switch_s, a.ends_on ? "on" : "off")
                     : std::string(a.ends_on ? "" : ", finally off"));
}

double AttackResult::NoiseFraction() const {
  return noise_N / std::max(0.02, 0.01 * mean_N);
}

AttackResult TryAttack(const StabilitySubject& subject, const Attack& attack) {
  ClosedLoopSetup setup = subject.setup;
  setup.hand = attack.hand;
  setup.force_map.ramp_in_s = std::min(setup.force_map.ramp_in_s, kRampIn_s);
  ClosedLoop loop(subject.bone, setup, subject.X_WT_start);
  const int ticks = static_cast<int>((kAttack_s + kAfter_s) / setup.period_s);
  const int from = ticks - static_cast<int>(kListen_s / setup.period_s);
  std::vector<Vec3> f_N;
  f_N.reserve(static_cast<std::size_t>(ticks - from));
  AttackResult result;
  ClosedLoopTick tick;
  for (int i = 0; i < ticks; ++i) {
    const double t_s = i * setup.period_s;
    loop.device().SetIntention(CalcIntention(subject, attack, t_s));
    tick = loop.Step(CalcRpm(attack, t_s));
    if (i >= from) f_N.push_back(tick.f_device_N);
    const PortEnergy& e = tick.energy;
    if (e.exchanged_mJ < kMinExchanged_mJ) continue;
    result.min_kept = std::min(result.min_kept, (e.handle_mJ + e.spindle_mJ) / e.exchanged_mJ);
  }
  // A contact that begins or ends is a real change of the force and affects one piece; vibration affects most pieces.
  std::array<double, kPieces> noise_N;
  const std::size_t piece = f_N.size() / kPieces;
  Vec3 sum(0);
  for (std::size_t i = 0; i < kPieces; ++i) {
    noise_N[i] = CalcNoise(std::span(f_N).subspan(i * piece, piece), setup.period_s);
  }
  for (const Vec3& f : f_N) sum += f;
  std::sort(noise_N.begin(), noise_N.end());
  result.noise_N = noise_N[kPieces / 2];
  result.mean_N = glm::length(sum) / static_cast<double>(f_N.size());
  result.lowest_mJ = tick.energy.lowest_handle_mJ;
  result.exchanged_mJ = tick.energy.exchanged_mJ;
  result.spindle_mJ = tick.energy.spindle_mJ;
  return result;
}

Found Search(const std::function<double(const AttackGenes&)>& score, const AdversaryOptions& options) {
  Random random(options.seed);
  std::vector<Found> best;  // best first
  const int at_random = options.random_only ? options.tries : (options.tries + 2) / 3;
  for (int n = 0; n < options.tries; ++n) {
    Found found;
    found.at_try = n + 1;
    if (n < at_random) {
      for (double& gene : found.genes) gene = random.Unit();
    } else {
      // A child of one of the best, with some genes from another. The steps become smaller with time, except for a
      // random quarter of them.
      const AttackGenes& mother = best[random.Below(best.size())].genes;
      const AttackGenes& father = best[random.Below(best.size())].genes;
      const double done = static_cast<double>(n - at_random) / std::max(1, options.tries - at_random);
      const double step = random.Unit() < 0.25 ? kFirstStep : LogBetween(kFirstStep, kLastStep, done);
      for (std::size_t i = 0; i < kAttackGenes; ++i) {
        found.genes[i] = random.Unit() < 0.2 ? father[i] : mother[i];
        if (random.Unit() < 0.5) found.genes[i] = Reflect(found.genes[i] + step * random.Normal());
      }
    }
    found.score = score(found.genes);
    const auto place = std::find_if(best.begin(), best.end(), [&](const Found& f) { return found.score > f.score; });
    best.insert(place, found);
    if (best.size() > kParents) best.pop_back();
  }
  return best.empty() ? Found{} : best.front();
}

Worst FindWorst(const StabilitySubject& subject, AttackGoal goal, const AdversaryOptions& options) {
  Worst worst;
  worst.found = Search(
      [&](const AttackGenes& genes) {
        const AttackResult result = TryAttack(subject, MakeAttack(subject, genes));
        return goal == AttackGoal::kNoise ? result.NoiseFraction() : -result.min_kept;
      },
      options);
  worst.attack = MakeAttack(subject, worst.found.genes);
  worst.result = TryAttack(subject, worst.attack);
  return worst;
}

}  // namespace kerf
