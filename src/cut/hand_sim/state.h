// State of a coupled simulation between its ticks, and the parts of a tick.
#pragma once

#include <algorithm>
#include <array>
#include <memory>
#include <variant>

#include "bone/grid/field.h"
#include "bone/grid/leaf_history.h"
#include "cut/contact/edge.h"
#include "cut/contact/faces.h"
#include "cut/contact/step.h"
#include "cut/effects/plan.h"
#include "cut/force/laws.h"
#include "cut/hand_sim/coupling.h"
#include "cut/hand_sim/internals.h"
#include "cut/hand_sim/setup.h"
#include "cut/hand_sim/slab_guide.h"
#include "cut/path_sim/teeth_sums.h"
#include "cut/proximity/clearance.h"
#include "cut/removal/paced_cutter.h"
#include "cut/tool/drive.h"
#include "cut/tool/shape.h"
#include "kerf/coupled.h"

namespace kerf {

struct CoupledSimulation::State {
  static constexpr double kFaceSpacing_mm = 1.4;
  /// Below this speed, friction sticks; also the range of the ramp of a law with a force at zero bite.
  static constexpr double kCreep_mm_per_s = 0.02;
  static constexpr double kMaxReserve_mJ = 5;

  State(Bone the_bone, const ComparedParams& the_params, const Pose& X_WT_start)
      : bone(std::move(the_bone)),
        params(the_params),
        field(bone, params.spare_leaves),
        h(bone.voxel_mm()),
        is_blade(IsBlade(params.tool)),
        drive(params.tool),
        is_round(GetForm(params.tool) == ToolForm::kRound),
        shape(
            MakeToolShape(params.tool, {params.rim_samples_per_pitch, kFaceSpacing_mm,
                                        Faces::CalcRimMargin(CalcReach(params.tool), h), Faces::CalcStoppedMargin(h)})),
        coupling(params.coupling, CalcSideStiffness(params.tool)),
        edge(field, bone, params.tool, shape, params.coupling.p_TC_mm),
        faces(field, shape, params.coupling.p_TC_mm),
        cutter(field, params.tool, CutWith::kEdge, params.whole_voxel_removal, params.precision_bits),
        paced(cutter, params.tool, shape.reach_mm, h, params.carve_interval_ticks),
        clearance(field, params.tool),
        problem(MakeStepProblem(MakeToothForce(params.law, params.tool))),
        slab(params.tool, params.coupling.p_TC_mm, params.slab_reading),
        effects(params.effects,
                {bone, field, params.tool, shape, edge, problem.law, &faces, params.coupling.p_TC_mm, field.p_WF_mm()}),
        solver(edge.size() + faces.size() + effects.capacity().solids + effects.capacity().frictions + 8),
        has_own_law(IsOwnLaw(params.law)),
        X_WT(Local(X_WT_start)),
        X_WH(X_WT) {
    last.X_WT = X_WT_start;
    problem.ramp_mm_per_s = problem.law.jumps ? kCreep_mm_per_s : 0;
    problem.creep_mm_per_s = kCreep_mm_per_s;
    problem.cutting.reserve(edge.size());
    problem.solids.reserve(edge.size() + (is_blade ? 0 : faces.size()) + effects.capacity().solids + 8);
    problem.yields.reserve(1);
    problem.flats.reserve(faces.size());
    problem.frictions.reserve(effects.capacity().frictions + 1);
  }

  /// Sums over the substeps of a tick. Forces and means are weighted by time; energies are not.
  struct Sums {
    double time_s = 0;    // time covered by the substeps
    double drawn_mJ = 0;  // energy put into the coupling's springs by the handle's motion
    double given_mJ = 0;  // work of the coupling and contact springs on the tool: force at a step's end times motion
    Vec3 f_cut_W{0}, f_face_W{0}, f_friction_W{0};
    TeethSums teeth;
    Vec3 f_damper_W{0}, tau_damper_W{0};  // on the hand, in the last substep; not weighted by time
    bool touched = false;                 // true if the tool touched anything
  };

  CoupledOutput Tick(const CoupledInput& input, TickObserver* observer);
  bool Accepts(const CoupledInput& in) const;
  CoupledOutput Repeat() const;
  /// Within a tick all poses are in the field's frame F, which replaces W.
  Pose Local(const Pose& X) const { return {X.R_AB, X.p_AB - field.p_WF_mm()}; }
  Pose World(const Pose& X) const { return {X.R_AB, X.p_AB + field.p_WF_mm()}; }
  void StepFidelity(const CoupledInput& in, CoupledOutput& out);
  void CutAtStart(CoupledOutput& out);
  void CutWaiting(CoupledOutput& out);
  void CutPath(CoupledOutput& out);
  void FinishPath();
  void EndSlab() {
    slab.End();
    blend = bone_fraction = 1;
  }
  void Release();
  /// Result of a motion through air.
  enum class Flight { kNear, kUnderWay, kArrived };
  Flight Fly(const CoupledInput& in, CoupledOutput& out);
  void Stroke(const CoupledInput& in, double time_s);
  const DriveStep* StrokeOrNull() const { return drive.strokes() ? &stroke : nullptr; }
  /// Pose of the blade where its stroke has taken it; of a turning tool, that of the tool.
  Pose EdgePose() const { return drive.strokes() ? shape.motion.Move(X_WT, edge.slide_mm()) : X_WT; }
  void Engage(const CoupledInput& in, double time_s, TickObserver* observer);
  void MoveHandle(const Pose& X_to, Sums& sums, CoupledOutput& out);
  bool Follow(const CoupledInput& in, int max_substeps, TickObserver* observer, Sums& sums, CoupledOutput& out);
  double CalcStepFraction(const Twist& motion, double time_s) const;
  void AddUp(double time_s, Sums& sums, CoupledOutput& out);
  void Move(const Pose& X_next, double fraction);
  /// Returns the energy in the springs of the problem's solids from `first` to `end`, after `fraction` of the step, mJ.
  double CalcSolidsEnergy(std::size_t first, std::size_t end, double fraction) const;
  /// Returns the stored energy less the energy put in. It decreases by the energy that is lost to the bone and to the
  /// finite length of the steps.
  double CalcBalance(const CoupledOutput& out) const {
    return coupling_mJ + contact_mJ - out.hand_mJ - out.spindle_mJ + out.damping_mJ;
  }
  void Reserve(double lost_mJ) { reserve_mJ = std::clamp(reserve_mJ + lost_mJ, 0.0, kMaxReserve_mJ); }
  void Publish(const Sums& sums, CoupledOutput& out) const;

  Bone bone;
  ComparedParams params;
  BoneField field;
  double h;
  bool is_blade;
  Drive drive;
  double phase_rad = 0;  // of a stroke
  DriveStep stroke;      // of the substep
  double tick_s = 0;     // duration of this tick
  bool is_round;
  ToolShape shape;
  Coupling coupling;
  Edge edge;
  Faces faces;
  Cutter cutter;
  PacedCutter paced;
  Clearance clearance;
  StepProblem problem;
  SlabGuide slab;
  PassedPath path;
  EffectPlan effects;
  StepSolver solver;
  Fidelity fidelity = Fidelity::kFull;  // requested
  double blend = 1;                     // linear in time during a transition; 1: the bone alone, 0: the slab law alone
  double bone_fraction = 1;             // fraction of the forces that come from the bone; the rest is the slab law's
  Vec3 f_cut_T{0};                      // force of the teeth in the last substep without the slab law, tool frame
  double teeth = 0;                     // engaged teeth in the same substep

  bool has_own_law;             // of another program: its forces are checked
  bool at_start = true;         // CutAtStart() has not removed the bone inside the tool yet
  Pose X_WT;                    // pose of the tool
  Pose X_WH;                    // last valid handle pose
  Twist u{};                    // motion in the last substep, start of the next solution
  double coupling_mJ = 0;       // energy of the coupling's springs at the end of the last tick
  double contact_mJ = 0;        // energy of the contact's springs
  double guide_mJ = 0;          // part of contact_mJ in the slab's guide
  double effects_mJ = 0;        // part of contact_mJ in springs of effects
  std::size_t first_guide = 0;  // index in the problem's solids
  std::size_t first_of_effects = 0;
  CoupledOutput last;  // output of the last tick
  std::uint64_t ticks = 0;
  std::array<double, 256> taken_out_mm3{};
  std::unique_ptr<LeafHistory> history;
  /// Energy lost so far and not returned; bounds the energy of a push-out (penetration_limiter.h).
  double reserve_mJ = 0;
};

}  // namespace kerf
