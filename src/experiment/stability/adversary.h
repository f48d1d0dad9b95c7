// Adversarial search: finds the passive hand and the path that produce the most noise, or that extract the most energy
// from a loop.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "experiment/stability/margins.h"

namespace kerf {

/// Parameters that the adversary may choose; each gene is 0 to 1.
constexpr std::size_t kAttackGenes = 13;
using AttackGenes = std::array<double, kAttackGenes>;

/// A hand that holds the handle, and its motion. The hand is passive and no faster than a human hand.
///
/// At first it pushes, saws back and forth, tilts and switches the spindle. After kAttack_s all inputs, including the
/// push, are constant, so that any remaining vibration is self-excited.
struct Attack {
  HandModel hand;       // 0.02 to 1 kg, 0.5 to 20 N s/m, 1 to 1000 N/m (or 0): on logarithmic scales
  double push_N = 0;    // on the handle: the device's friction plus 2 % to 100 % of its continuous force (of its peak
                        // force if no continuous force is given; of 20 N if that is less)
  Vec3 push_W{0};       // unit length, within 80 degrees of the feed
  Vec3 saw_W_mm{0};     // amplitude, 0.01 to 10 mm, any direction
  double saw_Hz = 0;    // 0.5 to 10
  double tilt_rad = 0;  // of the tool about the perpendicular to the feed that lies in the tool's plane, up to 10
                        // degrees either way
  double rpm = 0;       // 0 or 100 to 60000, in either direction
  double switch_s = 0;  // interval at which the spindle is switched on and off at first; 0: it is not switched
  bool ends_on = true;
};
Attack MakeAttack(const StabilitySubject& subject, const AttackGenes& genes);
std::string ToText(const Attack& attack);

constexpr double kAttack_s = 1.2;
constexpr double kAfter_s = 1.0;  // the last 0.7 s are analysed

struct AttackResult {
  double noise_N = 0;       // of the device force above 20 Hz, after all inputs have become constant
  double mean_N = 0;        // magnitude of the mean force in the same time
  double lowest_mJ = 0;     // minimum of the energy from the hand to the handle plus that from the spindle
  double exchanged_mJ = 0;  // sum of the absolute energies in both directions
  double spindle_mJ = 0;
  /// Minimum of that energy as a fraction of the energy exchanged so far, i.e. the fraction that was not returned, once
  /// at least 0.01 mJ has been exchanged. Below 0, more energy came out than went in.
  double min_kept = 1;
  /// Returns the noise divided by its bound, which is the larger of 20 mN and 1 % of the force. Above 1, the bound is
  /// violated.
  double NoiseFraction() const;
};
AttackResult TryAttack(const StabilitySubject& subject, const Attack& attack);

enum class AttackGoal { kNoise, kEnergy };

struct AdversaryOptions {
  int tries = 200;
  std::uint64_t seed = 1;
  bool random_only = false;  // only random tries without a search, for comparison
};

struct Found {
  AttackGenes genes{};
  double score = 0;
  int at_try = 0;
};
/// Maximises a score over the genes: a third of the tries are random, the others are children of the best so far. This
/// is an evolution strategy with few parents and many children. The score is noisy and has plateaus (no contact, no
/// noise), so gradients are of no use. One run takes a tenth of a second, so there are too few tries to learn a model
/// of the score. Deterministic.
Found Search(const std::function<double(const AttackGenes&)>& score, const AdversaryOptions& options);

struct Worst {
  Attack attack;
  AttackResult result;
  Found found;
};
Worst FindWorst(const StabilitySubject& subject, AttackGoal goal, const AdversaryOptions& options);

}  // namespace kerf
