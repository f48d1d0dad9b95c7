// Building blocks of the scenarios: a loop that is run, observed and judged.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "experiment/stability/held_tool.h"
#include "experiment/stability/scenarios.h"
#include "experiment/stability/tick_watch.h"

namespace kerf {

inline constexpr double kYield_s = 0.5;  // Intention::yield_s of a hand that feeds

/// A subject's loop during one scenario. Records the motors' forces and the handle's positions, and checks the
/// conditions that hold in every scenario: all values finite, no force beyond the device's peak, no step beyond the
/// slew limit except to zero, no force in air.
class ScenarioRun {
 public:
  static constexpr double kNoiseFraction = 0.01;  // noise allowed, as a fraction of the force

  /// Starts at subject.X_WT_start, where the held tool is, or at X_WT.
  ScenarioRun(const StabilitySubject& subject, const Scenario& scenario);
  ScenarioRun(const StabilitySubject& subject, const Scenario& scenario, const HeldTool& held);
  ScenarioRun(const StabilitySubject& subject, const Scenario& scenario, Bone bone, const Pose& X_WT);

  ClosedLoop& loop() { return loop_; }
  const ClosedLoopTick& tick() const { return tick_; }
  const StabilitySubject& subject() const { return subject_; }
  const Pose& X_WT_start() const { return X_WT_start_; }
  double T() const { return subject_.setup.period_s; }
  double scale() const { return scale_; }  // device N per simulation N
  void set_rpm(double rpm) { rpm_ = rpm; }

  /// Returns the force on the device for a force in simulated newtons: at most 80 % of what the device and the coupling
  /// can sustain, plus the device's friction.
  double CalcPush_N(double simulated_N) const;
  /// Returns the push, on the device, of a hand that keeps the tool cutting for some time: CalcPush_N(), or what a feed
  /// of kFastFeed_mm_per_s takes of this hand if that is less. The result states a push that is less.
  ///
  /// A tool that needs less force would otherwise be through the bone, and the scenario would examine it in air.
  Vec3 FindCutPush_N(double simulated_N, const HandModel& hand);
  /// Returns the change of a force that one encoder step causes through the coupling, in just-noticeable differences.
  double CalcGrain(double force_N) const;
  /// The hand pushes the handle; its target position yields along the push.
  void Lean(const Vec3& push_W_N);
  /// The hand releases the handle.
  void Release();
  /// The hand grips the handle at its present position, which becomes its target.
  void Grip(const HandModel& hand);

  const ClosedLoopTick& Step();
  /// Processes the loop's tick as Step() does; tests call it with artificial ticks.
  const ClosedLoopTick& Take(const ClosedLoopTick& tick);
  void Run(double seconds);
  /// Does the same as Run(), but ends when the tool leaves the bone. Returns the end (as now()) of the samples whose
  /// force may be judged: a tenth of a second before the tool cut through, or before the force was absent for a tenth
  /// of a second.
  std::size_t RunInBone(double seconds);
  /// Returns true if the tool has come out on the far side of the bone: it has cut, has no bone within 2 mm ahead along
  /// the feed, and is still on its line. A tool that left its line sideways or that hops on the bone has not cut
  /// through.
  bool is_through() const { return result_.cut_through_s.has_value(); }
  /// Runs in air until the force is fully ramped in.
  void AwaitRamp();

  std::size_t now() const { return f_N_.size(); }  // samples so far
  std::span<const Vec3> forces_N(std::size_t from, std::size_t to = SIZE_MAX) const;
  std::span<const Vec3> positions_mm(std::size_t from, std::size_t to = SIZE_MAX) const;
  std::vector<double> ForcesAlong_N(const Vec3& direction_W, std::size_t from, std::size_t to = SIZE_MAX) const;
  double MeanForce_N(std::size_t from, std::size_t to = SIZE_MAX) const;

  void AtMost(const std::string& name, const std::string& unit, double value, double bound);
  void AtLeast(const std::string& name, const std::string& unit, double value, double bound);
  /// Adds the force above 20 Hz, which must be at most 20 mN or `fraction` of the force, whichever is larger. A window
  /// shorter than a quarter of a second (a tenth of a second if the tool is through) is not judged.
  void AddNoise(std::size_t from, std::size_t to = SIZE_MAX, double fraction = kNoiseFraction);
  /// Does the same for a cut without faults. Since a shaking tool breaks through early, the tool may be through before
  /// `from` or soon after it. In that case the whole cut is examined in parts of a tenth of a second, and the part with
  /// the median noise counts (of two parts, the louder one). A border between two kinds of bone shakes the tool in one
  /// part only, an unstable loop in most of them.
  void AddCutNoise(std::size_t from, std::size_t to = SIZE_MAX);
  /// Adds the check that the motors never output more energy than was put in, apart from what a held spring force can
  /// return (PortEnergy::held_mJ) and a small tolerance.
  void AddEnergy();
  void Say(const std::string& more) { result_.what += more; }
  /// Records why something could not be judged.
  void LeaveUnjudged(const std::string& why) { result_.unjudged = why; }
  /// Returns true if there was no force during the last `seconds`.
  bool IsOff(double seconds) const;

  ScenarioResult Finish();
  static ScenarioResult Skip(const Scenario& scenario, const std::string& why);
  /// Returns the result of a scenario in which nothing could be judged.
  static ScenarioResult NotJudged(const Scenario& scenario, const std::string& why);

 private:
  /// Returns the first sample (as now()) in which the tool cut, plus a settling time. From this sample on, the force
  /// may be judged if the tool breaks through before the scenario's own window.
  std::size_t FirstSteady() const;
  void AddNoiseFigure(double noise_N, double mean_N, double fraction);
  const StabilitySubject& subject_;
  Pose X_WT_start_;
  double scale_;
  double slew_N_per_s_;
  ClosedLoop loop_;
  ClosedLoopTick tick_;
  double rpm_;
  ScenarioResult result_;
  std::vector<Vec3> f_N_;
  std::vector<Vec3> p_mm_;
  TickWatch watch_;
  Bone initial_bone_;            // in which the run looks for bone ahead
  std::vector<Vec3> leading_T_;  // points of the edge that face along the feed, tool frame
  bool has_cut_ = false;
  std::size_t first_cut_ = 0;  // as now()
  bool left_line_ = false;  // sideways; a tool that moves around the bone also gets behind it, but has not cut through
                            // it
  bool was_released_ = false;
  double furthest_mm_ = 0;       // along the feed
  std::size_t last_search_ = 0;  // sample of the last search for bone ahead, as now()

  void CheckCutThrough();
  bool IsBoneAhead() const;
};

/// Returns points of the tool's edge, tool frame.
std::vector<Vec3> SampleEdge(const Tool& tool);
/// Returns the depth of the tool's edge in the bone, mm, limited to the bone's band; 0 or less if there is no contact.
double CalcBuried(const Bone& bone, const Tool& tool, const Pose& X_WT);
/// Returns the pose X_WT_start moved back against the feed until bone is in the way, by at most `max_mm`.
Pose BackOff(const StabilitySubject& subject, double max_mm);
/// Returns the thickness of the bone that the tool's edge crosses along the feed, mm; infinite if it is more than
/// `max_mm`.
double CalcThickness(const StabilitySubject& subject, double max_mm);

/// Appends a scenario to the list; `body` is called with subject, scenario (for its name and sentence) and seed.
template <typename Body>
void Add(std::vector<Scenario>& all, const char* name, const char* what, Body body) {
  all.push_back({name, what, [=](const StabilitySubject& subject, std::uint64_t seed) {
                   return body(subject, Scenario{name, what, {}}, seed);
                 }});
}

// The scenarios, by theme.
void AddContactScenarios(std::vector<Scenario>& all);
void AddCuttingScenarios(std::vector<Scenario>& all);
void AddFaultScenarios(std::vector<Scenario>& all);

}  // namespace kerf
