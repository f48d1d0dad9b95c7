#include "session/run/loop_setup.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "base/core/append_format.h"
#include "base/files/files.h"
#include "bone/grid/field.h"
#include "cut/effects/tangential_force.h"
#include "cut/hand_sim/setup.h"
#include "cut/tool/shape.h"
#include "device/devices/profiles.h"
#include "kerf/error.h"

namespace kerf {
namespace {

constexpr std::size_t kMaxProfileBytes = std::size_t{1} << 20;
constexpr int kMaxSpareLeaves = 1 << 16;

DeviceProfile ReadProfile(const SceneDevice& device) {
  if (device.file.empty()) return FindDeviceProfile(device.profile);
  try {
    return FindDeviceProfile(ParseDeviceProfiles(ReadTextFile(device.file, kMaxProfileBytes), device.file),
                             device.profile);
  } catch (const Error& e) {
    if (device.file_place.empty()) throw;
    throw Error(fmt::format("{}: {}", device.file_place, e.what()));
  }
}

/// Formats a stiffness as simulated and as rendered on the device.
std::string FormatStiffness(double simulated_N_per_mm, double scale) {
  if (!std::isfinite(simulated_N_per_mm)) return "any";
  return fmt::format("{:.4g} N/mm ({:.4g} N/mm on the device)", simulated_N_per_mm, simulated_N_per_mm * scale);
}

/// Describes the lateral pull of the teeth if it is larger than has been measured for any saw; otherwise returns "".
std::string DescribeLateralPull(const Scene& scene, const LoopSetup& setup) {
  constexpr double kMinMeasuredRatio = 1.4;
  const auto effect = std::find_if(scene.effects.begin(), scene.effects.end(),
                                   [](const EffectChoice& e) { return std::string(e.name()) == "tangential_force"; });
  if (effect == scene.effects.end()) return "";
  const double ratio = std::get<double>(effect->values().front());
  if (ratio >= kMinMeasuredRatio) return "";
  // The hand and the coupling, in series, hold the tool against the pull. Values are in simulated newtons.
  const double hand_N_per_mm = setup.hand.stiffness_N_per_mm / setup.force_scale;
  const double K = setup.fitted.coupling.stiffness_N_per_mm;
  const std::string distance = hand_N_per_mm > 0 ? fmt::format("by {:.2g} mm", (1 / K + 1 / hand_N_per_mm) / ratio)
                                                 : std::string("without limit");
  return fmt::format(
      "[effects.tangential_force] ratio = {:g} is below the measured 1.4 to 1.8: for each newton of thrust the teeth "
      "pull the tool sideways with {:.2g} N, which moves it {} in this hand; if it passes the edge of the bone, "
      "the teeth pull it around the bone (docs/effects.md)",
      ratio, 1 / ratio, distance);
}

}  // namespace

LoopSetup MakeLoopSetup(const Scene& scene) {
  LoopSetup setup;
  if (FindChoice(scene.effects, "tangential_force") != nullptr) {
    CheckCuttingRatio(MakeToothForce(scene.force, MakeTool(scene)));
  }
  // Profile and hand in terms of the tool's motion.
  const double scale = scene.device.motion_scale;
  setup.profile = ScaleProfile(ReadProfile(scene.device), scale);
  setup.hand = FindHandModel(scene.hand.model);
  setup.hand.mass_kg /= scale;
  setup.hand.damping_Ns_per_mm /= scale;
  setup.hand.stiffness_N_per_mm /= scale;
  setup.force_map.expected_peak_N = scene.device.expected_peak_N;
  setup.force_map.expected_peak_torque_Nmm = scene.device.expected_peak_torque_Nmm;
  setup.force_map.slew_N_per_s = scene.device.slew_N_per_s;
  setup.force_map.ramp_in_s = scene.device.ramp_s;
  const ForceMap map(setup.profile, setup.force_map);
  setup.force_scale = map.force_scale();
  const CouplingParams asked = MakeCoupledParams(scene).coupling;
  setup.asked_stiffness_N_per_mm = asked.stiffness_N_per_mm;
  setup.asked_damping_Ns_per_mm = asked.damping_Ns_per_mm;
  if (asked.blade_bends) setup.bending_N_per_mm = CalcSideStiffness(MakeTool(scene));
  setup.fitted = FitCoupling(setup.profile, setup.hand, asked, map.force_scale(), map.torque_scale(),
                             1 / scene.loop.rate_hz, scene.device.delay_ticks);
  CoupledParams fitted = MakeCoupledParams(scene);
  fitted.coupling = setup.fitted.coupling;
  try {
    CheckParams(fitted);
  } catch (const Error& e) {
    throw Error(fmt::format("[coupling], fitted to the device {} in the hand {} at {:g} Hz: {}", setup.profile.name,
                            setup.hand.name, scene.loop.rate_hz, e.what()));
  }
  return setup;
}

int CountSpareLeaves(const Bone& bone) {
  return static_cast<int>(std::clamp<std::int64_t>(CountSparesForAll(bone), 256, kMaxSpareLeaves));
}

std::string DescribeCoupling(const LoopSetup& setup) {
  const FittedCoupling& f = setup.fitted;
  const std::string loop_fraction =
      fmt::format("{:.0f} % of the limit of a loop at this rate with this hand", 100 * kSampledFraction);
  const char* const by_device = "the limit of the device";
  std::string text = FormatStiffness(f.coupling.stiffness_N_per_mm, setup.force_scale);
  const bool softer = f.coupling.stiffness_N_per_mm < setup.asked_stiffness_N_per_mm;
  const bool damped_less = f.coupling.damping_Ns_per_mm < setup.asked_damping_Ns_per_mm;
  if (softer) {
    text +=
        fmt::format(", lowered from {:.4g} to {}", setup.asked_stiffness_N_per_mm,
                    f.lowered.by_loop ? loop_fraction + ": above it, the hand might oscillate strongly" : by_device);
  }
  if (f.lowered.torsion_by_loop || (f.lowered.by_device && !softer && !damped_less)) {
    text += fmt::format("; its torsion lowered to {:.4g} N mm/rad, {}", f.coupling.torsion_Nmm_per_rad,
                        f.lowered.torsion_by_loop ? loop_fraction : by_device);
  }
  if (damped_less) {
    text += fmt::format(
        "; its damping lowered from {:.4g} to {:.4g} N s/mm, {}", setup.asked_damping_Ns_per_mm,
        f.coupling.damping_Ns_per_mm,
        f.lowered.damping_by_loop ? "the limit of the loop at this rate for a delayed velocity" : by_device);
  }
  if (setup.bending_N_per_mm > 0) {
    AppendFormat(text, "; across the blade in series with {:.3g} N/mm, its bending", setup.bending_N_per_mm);
  }
  return text;
}

std::string DescribeLimits(const LoopSetup& setup) {
  const CouplingLimits& limits = setup.fitted.limits;
  return fmt::format("the limit of the device is {}; the limit of a loop at this rate with this hand is {}; {}",
                     FormatStiffness(limits.stiffness_N_per_mm, setup.force_scale),
                     FormatStiffness(limits.sampled_stiffness_N_per_mm, setup.force_scale),
                     setup.profile.friction_N > 0
                         ? fmt::format("the encoder's steps can't sustain an oscillation below {}",
                                       FormatStiffness(limits.quantum_stiffness_N_per_mm, setup.force_scale))
                         : std::string("the encoder's steps set no limit, as the device has no friction"));
}

std::vector<std::string> FindHandWarnings(const Scene& scene, const LoopSetup& setup) {
  std::vector<std::string> warnings;
  if (scene.coupling.at == CouplingPoint::kGrip && setup.profile.peak_torque_Nmm <= 0) {
    warnings.push_back(
        fmt::format("[coupling] at = \"grip\", but the device {} outputs no torques: the hand doesn't feel the force's "
                    "moment about the grip; set at = \"tool\"",
                    setup.profile.name));
  }
  if (const double s = setup.profile.peak_force_N / scene.device.slew_N_per_s; s > 0.1) {
    warnings.push_back(
        fmt::format("[device] slew_N_per_s = {:g}: the device's force takes {:.2g} s to reach its peak, so it lags, "
                    "and can return more energy than it absorbs; set at least {:.3g}",
                    scene.device.slew_N_per_s, s, 10 * setup.profile.peak_force_N));
  }
  if (scene.loop.rate_hz < 500) {
    warnings.push_back(fmt::format(
        "[loop] rate_hz = {:g}: below 500 ticks a second the steps of the force from tick to tick may be felt",
        scene.loop.rate_hz));
  }
  if (scene.coupling.params.blade_bends && setup.bending_N_per_mm == 0) {
    warnings.push_back("[coupling] blade_bends has no effect: the tool is rigid");
  }
  if (const std::string pull = DescribeLateralPull(scene, setup); !pull.empty()) warnings.push_back(pull);
  if (setup.fitted.lowered.any()) warnings.push_back("the coupling is " + DescribeCoupling(setup));
  return warnings;
}

}  // namespace kerf
