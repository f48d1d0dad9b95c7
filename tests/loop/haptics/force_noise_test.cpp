// Tests of the noise that the simulation adds, which is the force above 20 Hz during a steady push into bone.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cstdio>
#include <vector>

#include "base/core/high_pass.h"
#include "loop/haptics/held_saw.h"

namespace kerf {
namespace {

using test::HeldSaw;
using test::HeldSawOptions;
using test::kDt_s;

constexpr double kCutoff_Hz = 20;

struct Noise {
  double rms_mN = 0;  // RMS of the force commanded to the device, all three axes, in the simulation's newtons
  double mean_N = 0;  // mean of its component along the push, over the same time
  double feed_mm_per_s = 0;
  double teeth_rms = 0;  // RMS of the number of engaged teeth, also above 20 Hz
  std::uint32_t status = 0;
};

/// Pushes for 4 s and measures during the last 1.5 s; by then the transient of the push has decayed, even for the
/// lightest hand. `push_N` is in the simulation's newtons: the hand pushes with push_N times the force scale.
Noise Listen(const HeldSawOptions& options, double push_N) {
  HeldSaw saw(options);
  const double scale = saw.step.force_map().force_scale();
  IntentionStep push;
  push.seconds = 4;
  push.X_WH = saw.start;
  push.push_W_N = Vec3(0, 0, -push_N * scale);
  push.yield_s = 0.5;
  saw.device.SetScript(IntentionScript(saw.start, {push}));
  constexpr int kTicks = 4000;
  constexpr int kFrom = 2500;
  std::vector<double> f[3];
  std::vector<double> teeth;
  Noise noise;
  double z_from = 0;
  for (int i = 0; i < kTicks; ++i) {
    const HapticTick out = saw.Step();
    if (i == kFrom) z_from = saw.device.p_WC_mm().z;
    if (i < kFrom) continue;
    noise.status |= out.force.status | out.coupled.status;
    for (int k = 0; k < 3; ++k) f[k].push_back(out.force.f_H_W_N[k] / scale);
    teeth.push_back(out.coupled.engaged_teeth);
    noise.mean_N += out.force.f_H_W_N.z / scale / (kTicks - kFrom);
  }
  double sum = 0;
  for (const auto& axis : f) sum += std::pow(CalcHighPassRms(axis, kDt_s, kCutoff_Hz), 2);
  noise.rms_mN = 1000 * std::sqrt(sum);
  noise.teeth_rms = CalcHighPassRms(teeth, kDt_s, kCutoff_Hz);
  noise.feed_mm_per_s = (z_from - saw.device.p_WC_mm().z) / (kDt_s * (kTicks - kFrom));
  return noise;
}

struct Bench {
  const char* name;
  double resolution_mm;
  double stiffness_N_per_mm;
  double limit_mN;
};
// Limits of a device like the Omni, and of a better one. Their encoder steps correspond to 38 and 9 mN.
constexpr Bench kBenches[] = {{"55 um, 0.7 N/mm", 0.055, 0.7, 20}, {"6 um, 1.5 N/mm", 0.006, 1.5, 5}};

TEST(ForceNoise, OfAHeldPushIsBelowWhatAHandFeels) {
  std::string table = "force above 20 Hz, mN RMS, all axes (mean N, feed mm/s)\n";
  for (const Bench& bench : kBenches) {
    for (const char* hand : {"H1", "H2", "H3", "H4"}) {
      table += fmt::format("{:16} {}", bench.name, hand);
      for (const double push_N : {1.0, 5.0, 20.0}) {
        HeldSawOptions options;
        options.profile = test::MakeDevice(bench.resolution_mm, bench.stiffness_N_per_mm);
        options.stiffness_N_per_mm = bench.stiffness_N_per_mm;
        options.hand = hand;
        const Noise noise = Listen(options, push_N);
        EXPECT_LE(noise.rms_mN, bench.limit_mN) << bench.name << " " << hand << " " << push_N;
        // The push is steady and cuts. The force is lower than the push by the pull of the hand's spring as it yields,
        // up to k v 0.5 s.
        EXPECT_NEAR(noise.mean_N, push_N, 0.25 * push_N) << bench.name << " " << hand;
        EXPECT_GT(noise.feed_mm_per_s, 0.1);
        EXPECT_EQ(noise.status, 0u);
        table += fmt::format("  {:5.2f} ({:.2f}, {:.2f})", noise.rms_mN, noise.mean_N, noise.feed_mm_per_s);
      }
      table += "\n";
    }
  }
  std::puts(table.c_str());
}

// The remaining noise is the encoder's: if it is read every millisecond while the handle moves by many steps, it alone
// causes K Delta / sqrt(12), 11.1 and 2.6 mN. (The steps of a slow handle are partly below 20 Hz.)
TEST(ForceNoise, IsDueToTheEncoder) {
  for (const Bench& bench : kBenches) {
    HeldSawOptions options;
    options.profile = test::MakeDevice(bench.resolution_mm, bench.stiffness_N_per_mm);
    options.stiffness_N_per_mm = bench.stiffness_N_per_mm;
    const double encoder_mN = 1000 * bench.stiffness_N_per_mm * bench.resolution_mm / std::sqrt(12.0);
    EXPECT_NEAR(Listen(options, 20).rms_mN, encoder_mN, 0.05 * encoder_mN) << bench.name;
    options.quantise = false;
    EXPECT_LT(Listen(options, 20).rms_mN, 0.02) << bench.name;
  }
}

// Without encoder steps only the simulation's own noise remains. Whole voxels make the number of engaged teeth jump.
// Since cutting acts as a damper here and not as a spring, the hand feels at most a few mN of it; a spring of 1.5 N/mm
// against a voxel of 0.2 mm would release 300 mN at once.
TEST(ForceNoise, WholeVoxelRemovalIsNoisierThanFractionalRemoval) {
  std::string table =
      "above 20 Hz, RMS, H2, 1.5 N/mm, 0.2 mm voxels, no encoder steps: fractional / whole voxels\n"
      "push     force mN          engaged teeth\n";
  for (const double push_N : {1.0, 5.0, 20.0}) {
    HeldSawOptions options;
    options.block_mm.z = 200;  // at 20 N whole voxels are removed faster
    options.quantise = false;
    const Noise fractional = Listen(options, push_N);
    options.whole_voxels = true;
    const Noise whole = Listen(options, push_N);
    EXPECT_LT(fractional.rms_mN, 0.02) << push_N;
    EXPECT_LT(fractional.teeth_rms, 0.01) << push_N;
    EXPECT_GT(whole.rms_mN, 20 * fractional.rms_mN) << push_N;
    EXPECT_GT(whole.teeth_rms, 20 * fractional.teeth_rms) << push_N;
    table += fmt::format("{:4.0f} N  {:6.4f} / {:6.4f}   {:6.4f} / {:6.4f}\n", push_N, fractional.rms_mN, whole.rms_mN,
                         fractional.teeth_rms, whole.teeth_rms);
  }
  std::puts(table.c_str());
}

// The Omni itself outputs 3.3 N for 28 N, so its friction hides forces below 0.26 N * 28 / 3.3 = 2.2 N. The same 0.7
// N/mm at the device is 5.9 N/mm in the simulation, where an encoder step is 0.33 N.
TEST(ForceNoise, OfARealOmniIsPrintedForSimulationAndDevice) {
  HeldSawOptions options;
  options.profile = FindDeviceProfile("omni");
  std::string table = "Omni, H2, push 20 N of the simulation: K N/mm, noise mN of the simulation / of the device\n";
  for (const double K : {0.7, 0.7 * 28 / 3.3}) {
    options.stiffness_N_per_mm = K;
    const Noise noise = Listen(options, 20);
    EXPECT_LE(noise.rms_mN * 3.3 / 28, 20);
    table += fmt::format("{:5.2f}  {:.1f} / {:.1f}\n", K, noise.rms_mN, noise.rms_mN * 3.3 / 28);
  }
  std::puts(table.c_str());
}

}  // namespace
}  // namespace kerf
