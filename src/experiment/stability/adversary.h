// An adversary: looks for the passive hand and the path that make a loop tremble most, or get most energy out of it.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "experiment/stability/margins.h"

namespace kerf {

/// What the adversary may choose, each gene 0 to 1.
constexpr std::size_t kAttackGenes = 13;
using AttackGenes = std::array<double, kAttackGenes>;

/// A hand that holds the handle, and what it does: no faster than a hand goes, and nothing that is not passive.
///
/// First it pushes, saws to and fro, tilts and lets the spindle be switched; then, after kAttack_s, all that it wants
/// stands still but for the push, so that whatever still trembles trembles by itself.
struct Attack {
  HandModel hand;       // 0.02 to 1 kg, 0.5 to 20 N s/m, 1 to 1000 N/m (or none): each order of magnitude alike
  double push_N = 0;    // on the handle, 2 % to all of what the device bears for long
  Vec3 push_W{0};       // unit length, within 80 degrees of the feed
  Vec3 saw_W_mm{0};     // amplitude, 0.01 to 10 mm, any way
  double saw_Hz = 0;    // 0.5 to 10
  double tilt_rad = 0;  // of the tool about the feed's normal in its plane, up to 10 degrees
  double rpm = 0;       // 0 or 100 to 60000, either way round
  double switch_s = 0;  // the spindle goes on and off so often at first; 0: not
  bool ends_on = true;
};
Attack MakeAttack(const StabilitySubject& subject, const AttackGenes& genes);
std::string ToText(const Attack& attack);

constexpr double kAttack_s = 1.2;
constexpr double kAfter_s = 1.0;  // of which the last 0.7 s are listened to

struct AttackResult {
  double noise_N = 0;       // of the device's force above 20 Hz, once nothing that is wanted changes
  double mean_N = 0;        // the force meanwhile
  double lowest_mJ = 0;     // least of what the hand gave to the handle and the spindle put in, together
  double exchanged_mJ = 0;  // sum of what went to and fro
  double spindle_mJ = 0;
  /// Least of it as a share of what had been exchanged by then, once that is 0.01 mJ: what of it was not got back.
  /// Below 0, more came back than went in.
  double least_kept = 1;
  /// Of the bound, which is 20 mN or 1 % of the force: above 1 it is broken.
  double NoiseShare() const;
};
AttackResult TryAttack(const StabilitySubject& subject, const Attack& attack);

enum class AttackGoal { kNoise, kEnergy };

struct AdversaryOptions {
  int tries = 200;
  std::uint64_t seed = 1;
  bool random_only = false;  // for comparison: no search
};

struct Found {
  AttackGenes genes{};
  double score = 0;
  int at_try = 0;
};
/// Maximises a score over the genes: a third of the tries at random, the rest children of the best so far. An evolution
/// strategy of few parents and many children: the score is noisy and has plateaus (no contact, no noise), so slopes are
/// no use, and one run takes a tenth of a second, so that a model of the score can't be learned. Deterministic.
Found Search(const std::function<double(const AttackGenes&)>& score, const AdversaryOptions& options);

struct Worst {
  Attack attack;
  AttackResult result;
  Found found;
};
Worst FindWorst(const StabilitySubject& subject, AttackGoal goal, const AdversaryOptions& options);

}  // namespace kerf
