// What the scenarios are made of: a loop that is run, watched and judged.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "experiment/stability/held_tool.h"
#include "experiment/stability/scenarios.h"
#include "experiment/stability/tick_watch.h"

namespace kerf {

/// A subject's loop on its way through one scenario. It keeps what the motors made and where the handle was, and holds
/// all of it against what holds in any scenario: finite, no force beyond the device's peak, no step beyond the slew but
/// to zero, no force in air.
class ScenarioRun {
 public:
  static constexpr double kNoiseShare = 0.01;  // of the force, that its noise may be

  /// From X_WT_start, or where the held tool is.
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

  /// On the device, for so many newtons of the simulation: no more than it bears for long, and its friction on top.
  double CalcPush_N(double simulated_N) const;
  /// What a step of the device's encoder makes of a force, through the coupling, in just-noticeable differences.
  double CalcGrain(double force_N) const;
  /// The hand leans on the handle, the place that it wants giving way along the push.
  void Lean(const Vec3& push_W_N);
  /// The hand lets go.
  void Release();
  /// The hand takes the handle where it is, and wants it there.
  void Grip(const HandModel& hand);

  const ClosedLoopTick& Step();
  /// What Step() does with the loop's tick; of a test, with one that is made up.
  const ClosedLoopTick& Take(const ClosedLoopTick& tick);
  void Run(double seconds);
  /// Likewise, but no longer than the tool is in bone. Up to where (as now()) the force may be judged: a tenth of a
  /// second before the tool had cut through, or had nothing to cut for a tenth.
  std::size_t RunInBone(double seconds);
  /// The tool has come out behind the bone: it cut, has no bone within 2 mm ahead of it along the feed, and is still on
  /// its line. A tool that left its line sideways or that hops on the bone has not cut through.
  bool is_through() const { return result_.cut_through_s.has_value(); }
  /// In the air, until the force is no longer ramped in.
  void AwaitRamp();

  std::size_t now() const { return f_N_.size(); }  // samples so far
  std::span<const Vec3> forces_N(std::size_t from, std::size_t to = SIZE_MAX) const;
  std::span<const Vec3> positions_mm(std::size_t from, std::size_t to = SIZE_MAX) const;
  std::vector<double> ForcesAlong_N(const Vec3& direction_W, std::size_t from, std::size_t to = SIZE_MAX) const;
  double MeanForce_N(std::size_t from, std::size_t to = SIZE_MAX) const;

  void AtMost(const std::string& name, const std::string& unit, double value, double bound);
  void AtLeast(const std::string& name, const std::string& unit, double value, double bound);
  /// Force above 20 Hz: at most 20 mN, or that share of the force where it is more. Of less than a quarter of a second
  /// it is not judged.
  void AddNoise(std::size_t from, std::size_t to = SIZE_MAX, double share = kNoiseShare);
  /// The same of a cut without faults, whose tool may be through before `from`: a loop that shakes breaks through
  /// early. Then all that it cut for is looked at, in parts of a tenth of a second, and the middle one by noise counts,
  /// of two the louder: a border between two kinds of bone shakes one part, an unstable loop most of them.
  void AddCutNoise(std::size_t from, std::size_t to = SIZE_MAX);
  /// That the motors never gave more than was put in.
  void AddEnergy();
  void Say(const std::string& more) { result_.what += more; }
  /// Something could not be judged, for that reason.
  void LeaveUnjudged(const std::string& why) { result_.unjudged = why; }
  /// The tool meets no bone any more for so long at the end.
  bool IsOff(double seconds) const;

  ScenarioResult Finish();
  static ScenarioResult Skip(const Scenario& scenario, const std::string& why);
  /// Nothing of it could be judged.
  static ScenarioResult NotJudged(const Scenario& scenario, const std::string& why);

 private:
  /// The first sample (as now()) in which the tool cut, and a little later: from here on the force of a tool that
  /// breaks through before a scenario's own time may be judged.
  std::size_t FirstSteady() const;
  void AddNoiseFigure(double noise_N, double mean_N, double share);
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
  Bone begun_with_;              // to look ahead in
  std::vector<Vec3> leading_T_;  // points of the edge that lead along the feed, tool frame
  bool has_cut_ = false;
  std::size_t first_cut_ = 0;  // as now()
  bool left_line_ = false;     // of the feed, sideways: a tool that drives itself round the bone comes behind it too
  bool was_released_ = false;
  double furthest_mm_ = 0;  // along the feed
  std::size_t looked_ = 0;  // for bone ahead, as now()

  void LookAhead();
  bool IsBoneAhead() const;
};

/// Points of the tool's edge, tool frame.
std::vector<Vec3> SampleEdge(const Tool& tool);
/// How far the tool's edge reaches into the bone, mm; at most the bone's band. Not above 0: it does not touch.
double CalcBuried(const Bone& bone, const Tool& tool, const Pose& X_WT);
/// As far back from X against the feed as no bone is in the way, at most `most_mm`.
Pose BackOff(const StabilitySubject& subject, double most_mm);
/// Thickness of the bone that the tool's edge meets on the way of the feed; infinite when it is more than `most_mm`.
double CalcThickness(const StabilitySubject& subject, double most_mm);

/// Puts a scenario on the list; `body` is called with subject, scenario (for its name and sentence) and seed.
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
