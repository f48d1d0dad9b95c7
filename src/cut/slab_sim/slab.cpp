#include "kerf/slab.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "cut/slab_sim/monotone.h"
#include "cut/slab_sim/resistance.h"
#include "kerf/error.h"

namespace kerf {
namespace {

constexpr double kTonnePerGram = 1e-6;  // N s^2 / mm: the unit of mass that is consistent with mm, N and s
constexpr int kMinSubsteps = 8;
constexpr int kMaxSubsteps = 1024;
constexpr double kSubstepTravel_mm = 0.05;  // maximum motion of the hand per substep
constexpr double kNoAdvance_N = 1e12;       // resistance that stops a blade whose spindle is stopped

void Validate(const SlabParams& p, const SlabProfile& profile) {
  p.saw.Validate();
  if (!(std::abs(glm::length(p.direction_W) - 1) < 1e-6)) throw Error("the cut direction is not of unit length");
  CheckParameters(p);
  if (profile.layers.empty() || !(profile.end_mm > 0) || !std::isfinite(profile.end_mm + profile.entry_mm)) {
    throw Error("the slice's profile is empty");
  }
  double top_mm = 0;
  for (const SlabProfile::Layer& layer : profile.layers) {
    const bool first = &layer == &profile.layers.front();
    if (!(first ? layer.top_mm == 0 : layer.top_mm > top_mm) || !(layer.top_mm < profile.end_mm)) {
      throw Error(fmt::format("the slice's layers must begin at depth 0 and go down to its end; one begins at {} mm",
                              layer.top_mm));
    }
    if (!(layer.E_MPa >= 0 && std::isfinite(layer.E_MPa) && kPoissonRatioRange.Contains(layer.nu))) {
      throw Error(fmt::format(
          "the slice's layer at {} mm has E = {} MPa and nu = {}; E must be finite and 0 or more, and nu {}",
          layer.top_mm, layer.E_MPa, layer.nu, ShowRange(kPoissonRatioRange, "")));
    }
    top_mm = layer.top_mm;
  }
}

/// Body with one degree of freedom, a spring and a damper to the world, and a coupling to the hand if held. Implicit
/// Euler gives  mass_eff v = drive + dt * (other forces).
struct Body {
  double x_mm = 0;
  double v_mm_per_s = 0;
  double mass = 0;       // N s^2 / mm
  double stiffness = 0;  // N / mm
  double damping = 0;    // N s / mm
  double rest_mm = 0;    // position without spring force
  bool held = false;
  double anchor_mm = 0;  // value of x - hand at which the coupling exerts no force

  double CalcElastic(bool one_sided) const {
    const double e = one_sided ? std::max(0.0, x_mm - rest_mm) : x_mm - rest_mm;
    return 0.5 * stiffness * e * e;
  }
  double CalcKinetic() const { return 0.5 * mass * v_mm_per_s * v_mm_per_s; }
};

/// Motion of the hand in one substep.
struct Hand {
  double q_mm;        // at the end of the substep
  double v_mm_per_s;  // during the substep
  double dt_s;
  double stiffness;  // of the coupling, N/mm
  double damping;
};

struct Equation {
  double mass_eff;
  double drive;
};

Equation MakeEquation(const Body& body, const Hand& hand, bool spring_acts) {
  const double dt = hand.dt_s;
  const double k = spring_acts ? body.stiffness : 0;
  Equation e{body.mass + dt * (body.damping + dt * k),
             body.mass * body.v_mm_per_s - dt * k * (body.x_mm - body.rest_mm)};
  if (body.held) {
    e.mass_eff += dt * (hand.damping + dt * hand.stiffness);
    e.drive += dt * (hand.stiffness * (hand.q_mm + body.anchor_mm - body.x_mm) + hand.damping * hand.v_mm_per_s);
  }
  return e;
}

/// Returns the forces on one face of the slice, times dt, as a graph over the slice's velocity. They act against the
/// velocity u of the slice relative to the segment: friction, and the cutting resistance once the slice is deeper than
/// the depth already cut (u >= gap / dt). `inverse_mass_eff` > 0 includes the motion of the segment; 0: it is fixed.
MonotoneGraph MakeFaceGraph(double friction_N, double cutting_N, double gap_mm, double dt_s, double segment_drive,
                            double inverse_mass_eff) {
  const double cut_from = gap_mm / dt_s;
  const auto corner = [&](double u, double force_N) {
    return MonotoneGraph::Corner{u + (segment_drive + dt_s * force_N) * inverse_mass_eff, dt_s * force_N};
  };
  return {{{corner(0, -friction_N), corner(0, friction_N), corner(cut_from, friction_N),
            corner(cut_from, friction_N + cutting_N)}}};
}

}  // namespace

struct SlabSimulation::State {
  State(SlabProfile the_profile, const SlabParams& the_params)
      : profile(std::move(the_profile)), params(the_params), resistance(profile, params) {}

  SlabProfile profile;
  SlabParams params;
  SlabResistance resistance;
  Body blade;
  double entry_mm = 0;            // displacement of the blade at which its edge first touches the bone
  std::array<Body, 2> segments;   // left, right
  double hand_origin_mm = 0;      // p_W . direction at the start of the run
  Vec3 hand_W{0};                 // last valid position
  Vec3 aside_W{0}, aside_v_W{0};  // motion of the free slice across the direction since its release
  Vec3 hand_aside_W{0};           // position of the hand across the direction at that time
  SlabBody holds = SlabBody::kSlice;
  SlabState out;
  TickOutput last;  // output of the last tick

  double hand_mm(const Vec3& p_W) const { return glm::dot(p_W, params.direction_W) - hand_origin_mm; }
  Vec3 Across(const Vec3& p_W) const { return p_W - glm::dot(p_W, params.direction_W) * params.direction_W; }
  Body* held_body() {
    if (holds == SlabBody::kNone) return nullptr;
    return holds == SlabBody::kSlice ? &blade : &segments[holds == SlabBody::kLeft ? 0 : 1];
  }

  void Place(const Pose& X_WT);
  void MeasureDepth();
  void MeasureEnergy();
  double StepOnRail(const Hand& hand, bool cuts);
  Vec3 StepAside(const Hand& hand, const Vec3& hand_aside_mm, const Vec3& hand_aside_v);
  void Account(const Body& body, const Body& before, const Hand& hand, bool one_sided, double* hand_N);
  void Release();
};

/// Places the blade at the hand, with all bodies at rest.
void SlabSimulation::State::Place(const Pose& X_WT) {
  hand_W = X_WT.p_AB;
  blade.x_mm = hand_mm(hand_W);
  blade.v_mm_per_s = 0;
  if (blade.held) blade.anchor_mm = 0;
  for (Body& segment : segments) {
    segment.v_mm_per_s = 0;
    if (segment.held) segment.anchor_mm = segment.x_mm - blade.x_mm;
  }
  aside_W = aside_v_W = Vec3(0);
  hand_aside_W = Across(hand_W);
  MeasureDepth();
  out.deepest_mm = std::max(out.deepest_mm, out.depth_mm);
  // If the blade is set down inside the bone, it touches a slice that has not been displaced.
  blade.rest_mm = std::max(entry_mm, blade.x_mm);
}

void SlabSimulation::State::MeasureDepth() {
  out.blade_mm = blade.x_mm;
  out.left_mm = segments[0].x_mm;
  out.right_mm = segments[1].x_mm;
  out.depth_mm = blade.x_mm - entry_mm - 0.5 * (segments[0].x_mm + segments[1].x_mm);
}

void SlabSimulation::State::MeasureEnergy() {
  out.kinetic_mJ = blade.CalcKinetic() + 0.5 * blade.mass * glm::dot(aside_v_W, aside_v_W);
  out.elastic_mJ = out.free ? 0 : blade.CalcElastic(true);
  for (const Body& segment : segments) {
    out.kinetic_mJ += segment.CalcKinetic();
    out.elastic_mJ += segment.CalcElastic(false);
  }
  if (const Body* held = held_body()) {
    const double e = held->x_mm - hand_mm(hand_W) - held->anchor_mm;
    out.elastic_mJ += 0.5 * params.coupling_N_per_mm * e * e;
    if (out.free && held == &blade) {
      const Vec3 aside = aside_W - (Across(hand_W) - hand_aside_W);
      out.elastic_mJ += 0.5 * params.coupling_N_per_mm * glm::dot(aside, aside);
    }
  }
}

/// Adds the energy of springs, dampers and the time step for one body in a substep, and the force of the hand on it.
void SlabSimulation::State::Account(const Body& body, const Body& before, const Hand& hand, bool one_sided,
                                    double* hand_N) {
  const double dv = body.v_mm_per_s - before.v_mm_per_s;
  const double dx = body.x_mm - before.x_mm;
  const double v = body.v_mm_per_s;
  out.numerical_mJ += 0.5 * body.mass * dv * dv;
  out.damping_mJ += body.damping * v * v * hand.dt_s;
  if (body.stiffness > 0 && !(one_sided && out.free)) {
    // For a convex spring, the force at the end of a step times the motion is at least the energy that the spring
    // gained.
    const double e = one_sided ? std::max(0.0, body.x_mm - body.rest_mm) : body.x_mm - body.rest_mm;
    out.numerical_mJ += body.stiffness * e * dx - (body.CalcElastic(one_sided) - before.CalcElastic(one_sided));
  }
  if (!body.held) return;
  const double e = hand.q_mm + body.anchor_mm - body.x_mm;
  const double slip = hand.v_mm_per_s - v;
  const double force_N = hand.stiffness * e + hand.damping * slip;
  const double de = hand.v_mm_per_s * hand.dt_s - dx;
  out.hand_work_mJ += force_N * hand.v_mm_per_s * hand.dt_s;
  out.damping_mJ += hand.damping * slip * slip * hand.dt_s;
  out.numerical_mJ += 0.5 * hand.stiffness * de * de;
  *hand_N += force_N;
}

/// Moves all bodies by one substep. Returns the force of the hand, N.
double SlabSimulation::State::StepOnRail(const Hand& hand, bool cuts) {
  const double dt = hand.dt_s;
  const bool in_bone = !out.free && out.depth_mm > 0;
  blade.damping = in_bone ? params.damping_Ns_per_mm : 0;
  const double friction_N = in_bone ? params.friction_coefficient * params.normal_force_N : 0;
  const double cutting_N = out.free ? 0 : (cuts ? resistance.At(std::max(0.0, out.depth_mm)).force_N : kNoAdvance_N);
  const double gap_mm = std::max(0.0, out.deepest_mm - out.depth_mm);

  const Body blade_before = blade;
  const std::array<Body, 2> before = segments;
  std::array<Equation, 2> side{};
  if (params.segments_move) {
    for (std::size_t j = 0; j < 2; ++j) side[j] = MakeEquation(segments[j], hand, true);
  }
  std::array<MonotoneGraph, 2> faces{};
  std::array<double, 2> impulse{};  // of the faces on the segments, N s
  const auto solve = [&](const Equation& e) {
    double fraction = 0;
    if (!params.segments_move) {
      const std::array<MonotoneGraph, 1> both{MakeFaceGraph(2 * friction_N, cutting_N, gap_mm, dt, 0, 0)};
      const double v = SolveMonotone(e.mass_eff, e.drive, both, &fraction);
      impulse[0] = impulse[1] = 0.5 * (e.drive - e.mass_eff * v);
      return v;
    }
    for (std::size_t j = 0; j < 2; ++j) {
      faces[j] = MakeFaceGraph(friction_N, 0.5 * cutting_N, gap_mm, dt, side[j].drive, 1 / side[j].mass_eff);
    }
    const double v = SolveMonotone(e.mass_eff, e.drive, faces, &fraction);
    for (std::size_t j = 0; j < 2; ++j) {
      impulse[j] = faces[j].Below(v) + fraction * (faces[j].Above(v) - faces[j].Below(v));
    }
    return v;
  };
  // The slice's spring acts only once the blade touches the slice.
  double v = solve(MakeEquation(blade, hand, false));
  if (!out.free && blade.stiffness > 0 && blade.x_mm - blade.rest_mm + dt * v > 0) {
    v = solve(MakeEquation(blade, hand, true));
  }
  blade.v_mm_per_s = v;
  blade.x_mm += dt * v;

  double hand_N = 0;
  Account(blade, blade_before, hand, true, &hand_N);
  out.sticking = in_bone;
  for (std::size_t j = 0; j < 2; ++j) {
    Body& segment = segments[j];
    if (params.segments_move) {
      // A segment that sticks moves with exactly the velocity of the slice, bit for bit. The same holds for a slice
      // that moves exactly to the depth already cut.
      const auto& corners = faces[j].corners;
      if (v >= corners[0].v && v <= corners[1].v) {
        segment.v_mm_per_s = v;
      } else if (v >= corners[2].v && v <= corners[3].v) {
        segment.v_mm_per_s = v - gap_mm / dt;
      } else {
        segment.v_mm_per_s = (side[j].drive + impulse[j]) / side[j].mass_eff;
      }
      segment.x_mm += dt * segment.v_mm_per_s;
    }
    // A hand that holds a segment of a fixed jaw works against its own coupling.
    if (params.segments_move || segment.held) Account(segment, before[j], hand, false, &hand_N);
    const double u = v - segment.v_mm_per_s;
    const double rubbed = friction_N * std::abs(u) * dt;
    out.friction_mJ += rubbed;
    out.cutting_mJ += std::max(0.0, impulse[j] * u - rubbed);
    out.sticking = out.sticking && u == 0;
  }
  return hand_N;
}

/// Moves the free slice across the direction. Returns the force of the hand on it, N.
Vec3 SlabSimulation::State::StepAside(const Hand& hand, const Vec3& hand_aside_mm, const Vec3& hand_aside_v) {
  const double dt = hand.dt_s;
  if (holds != SlabBody::kSlice) {
    aside_W += dt * aside_v_W;
    return Vec3(0);
  }
  const Vec3 v =
      (blade.mass * aside_v_W + dt * (hand.stiffness * (hand_aside_mm - aside_W) + hand.damping * hand_aside_v)) /
      (blade.mass + dt * (hand.damping + dt * hand.stiffness));
  const Vec3 dv = v - aside_v_W;
  const Vec3 slip = hand_aside_v - v;
  aside_v_W = v;
  aside_W += dt * v;
  const Vec3 force_N = hand.stiffness * (hand_aside_mm - aside_W) + hand.damping * slip;
  out.hand_work_mJ += glm::dot(force_N, hand_aside_v) * dt;
  out.damping_mJ += hand.damping * glm::dot(slip, slip) * dt;
  out.numerical_mJ += 0.5 * blade.mass * glm::dot(dv, dv) + 0.5 * hand.stiffness * glm::dot(slip, slip) * dt * dt;
  return force_N;
}

/// Releases the slice, which has left the jaw: spring, friction and segments no longer act on it.
void SlabSimulation::State::Release() {
  out.free = true;
  out.sticking = false;
  out.released_mJ += blade.CalcElastic(true);
  aside_W = aside_v_W = Vec3(0);
}

SlabSimulation::SlabSimulation(SlabProfile profile, const SlabParams& params, const Pose& X_WT_start) {
  Validate(params, profile);
  if (!IsValid(X_WT_start)) throw Error("the tool's start pose is not finite or its quaternion is not of unit length");
  state_ = std::make_unique<State>(std::move(profile), params);
  State& s = *state_;
  s.hand_origin_mm = glm::dot(X_WT_start.p_AB, params.direction_W);
  s.blade.mass = params.mass_g * kTonnePerGram;
  s.blade.stiffness = params.stiffness_N_per_mm;
  s.entry_mm = s.profile.entry_mm - params.saw.radius_mm() - s.hand_origin_mm;
  s.blade.held = true;
  for (Body& segment : s.segments) {
    segment.mass = params.segment_mass_g * kTonnePerGram;
    segment.stiffness = params.segment_stiffness_N_per_mm;
    segment.damping = params.segment_damping_Ns_per_mm;
  }
  s.Place(X_WT_start);
  if (s.out.depth_mm >= s.profile.end_mm) {
    throw Error(
        fmt::format("the blade starts {:.2f} mm deep, past the slice, which ends at {:.2f} mm; start it before the "
                    "bone along the cut direction",
                    s.out.depth_mm, s.profile.end_mm));
  }
  s.MeasureEnergy();
}
SlabSimulation::~SlabSimulation() = default;
SlabSimulation::SlabSimulation(SlabSimulation&&) noexcept = default;
SlabSimulation& SlabSimulation::operator=(SlabSimulation&&) noexcept = default;

const SlabState& SlabSimulation::state() const {
  return state_->out;
}
const SlabProfile& SlabSimulation::profile() const {
  return state_->profile;
}
std::uint64_t SlabSimulation::CalcMemoryBytes() const {
  return sizeof(*this) + sizeof(State) + state_->profile.layers.capacity() * sizeof(SlabProfile::Layer) +
         state_->resistance.CalcMemoryBytes();
}

bool SlabSimulation::SetDown(const Pose& X_WT) {
  if (!IsValid(X_WT) || !IsInWorld(X_WT.p_AB)) return false;
  State& s = *state_;
  const double before_mJ = s.out.kinetic_mJ + s.out.elastic_mJ;
  s.last = {};
  s.Place(X_WT);
  s.MeasureEnergy();
  s.out.hand_work_mJ += s.out.kinetic_mJ + s.out.elastic_mJ - before_mJ;
  return true;
}

void SlabSimulation::Hold(SlabBody body) {
  State& s = *state_;
  if (body == s.holds) return;
  const double before_mJ = s.out.kinetic_mJ + s.out.elastic_mJ;
  if (Body* held = s.held_body()) held->held = false;
  s.holds = body;
  if (Body* held = s.held_body()) {
    held->held = true;
    held->anchor_mm = held->x_mm - s.hand_mm(s.hand_W);
    s.hand_aside_W = s.Across(s.hand_W) - s.aside_W;
  }
  s.MeasureEnergy();
  s.out.hand_work_mJ += s.out.kinetic_mJ + s.out.elastic_mJ - before_mJ;
}

TickOutput SlabSimulation::Tick(const TickInput& in) {
  State& s = *state_;
  TickOutput out;

  // 1 accept
  if (!IsValid(in.X_WT) || !IsInWorld(in.X_WT.p_AB) || !std::isfinite(in.rpm) || !(in.dt_s >= 0) ||
      !std::isfinite(in.dt_s)) {
    s.last = {};
    out.status = kTickBadPose;
    return out;
  }
  if (in.dt_s < kMinTick_s) {
    out = s.last;
    out.status = kTickNoTime;
    return out;
  }
  const Vec3 from_W = std::exchange(s.hand_W, in.X_WT.p_AB);
  const Vec3 move_W = in.X_WT.p_AB - from_W;
  const double move_mm = glm::dot(move_W, s.params.direction_W);
  double substeps = std::max<double>(kMinSubsteps, std::ceil(glm::length(move_W) / kSubstepTravel_mm));
  if (substeps > kMaxSubsteps) {
    out.status |= kTickSubstepsLimited;
    substeps = kMaxSubsteps;
  }
  const bool cuts = in.rpm != 0;
  if (!cuts) out.status |= kTickSpindleStopped;

  // 2 move the bodies with the hand
  const double dt_s = in.dt_s / substeps;
  Hand hand{0, move_mm / in.dt_s, dt_s, s.params.coupling_N_per_mm, s.params.coupling_damping_Ns_per_mm};
  const Vec3 aside_move_W = s.Across(move_W);
  const Vec3 aside_from_W = s.Across(from_W);
  Vec3 hand_W_N{0};
  for (int i = 1; i <= static_cast<int>(substeps); ++i) {
    hand.q_mm = s.hand_mm(from_W) + move_mm * (i / substeps);
    hand_W_N += s.StepOnRail(hand, cuts) * s.params.direction_W;
    if (s.out.free) {
      const Vec3 aside = aside_from_W + aside_move_W * (i / substeps) - s.hand_aside_W;
      hand_W_N += s.StepAside(hand, aside, aside_move_W / in.dt_s);
    }
    s.MeasureDepth();
    s.out.deepest_mm = std::max(s.out.deepest_mm, s.out.depth_mm);
    if (!s.out.free && s.out.depth_mm >= s.profile.end_mm) {
      s.Release();
      s.hand_aside_W = aside_from_W + aside_move_W * (i / substeps);
    }
  }
  s.MeasureEnergy();

  // 3 publish: means over the tick
  out.f_T_W_N = -hand_W_N / substeps;
  out.tau_TG_W_Nmm = in.X_WT.Vector(glm::cross(-s.params.saw.p_TG_mm, in.X_WT.InverseVector(out.f_T_W_N)));
  if (!s.out.free && s.out.depth_mm > 0) {
    const SlabLoad load = s.resistance.At(s.out.depth_mm);
    out.thrust_sum_N = load.force_N;
    out.thrust_W = 1e-3 * load.force_N * s.params.saw.radius_mm() * std::abs(in.rpm) * std::numbers::pi / 30;
    out.engaged_teeth = load.teeth;
    out.mean_E_MPa = load.E_MPa;
    if (const SlabProfile::Layer* layer = s.profile.Find(s.out.depth_mm)) out.main_region = layer->region;
  }
  s.last = out;
  return out;
}

}  // namespace kerf
