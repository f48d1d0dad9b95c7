// kerf_friction: Coulomb friction of a blade's flats on the walls of the kerf, and of a stopped edge on bone.
//
//   |f| <= mu N, against the slip, which is the sum of the tool's motion and the spindle's rotation. The contact
//   sticks below the creep speed of the step (StepProblem::creep_mm_per_s). A disc that is tilted in its kerf binds:
//   both walls press on it.
//
// The normal force N is taken from the previous steps, so that the step remains one convex problem. For the flats it
// is summed over patches of the disc and follows with a lag of 4 ms.
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <variant>
#include <vector>

#include "cut/effects/effect.h"
#include "cut/effects/effects.h"
#include "cut/effects/parameters.h"
#include "cut/effects/stroke_ways.h"

namespace kerf {
namespace {

constexpr double kFrictionLag_s = 0.004;
constexpr int kSectors = 8;
constexpr int kPatches = 48;
constexpr int kRings = kPatches / 2 / kSectors;

/// Returns the force that bends a blade's rim aside by half its thickness, N.
double CalcBendingForce(const Tool& tool) {
  return CalcSideStiffness(tool) * 0.5 * CalcThickness(tool);
}

double FlatDepth(const FlatPoint& p, const StepProblem& problem, const Twist& u) {
  return std::max(0.0, p.depth_mm + problem.tau_s * p.side * (u[2] + u[3] * p.y - u[4] * p.x));
}

struct KerfFrictionParams {
  double coefficient = 0.2;
};

template <typename V>
void Describe(KerfFrictionParams& p, V&& visit) {
  visit("coefficient", p.coefficient, Range{0, 2},
        "coefficient of friction of the flats, and of the stopped edge, on bone");
}

class KerfFrictionEffect final : public Effect {
 public:
  KerfFrictionEffect(double coefficient, const EffectSetup& setup)
      : coefficient_(coefficient),
        p_TC_(setup.p_TC_mm),
        half_mm_(0.5 * CalcThickness(setup.tool)),
        max_couple_N_(2 * CalcBendingForce(setup.tool)),
        reach_mm_(setup.shape.reach_mm),
        edge_force_N_(setup.edge.size()) {
    for (std::size_t j = 0; j < setup.faces->pair_count(); ++j)
      patch_of_pair_.push_back(FindPatch(setup.faces->pair_T(j)));
  }

  void Engage(const EffectStep& step, StepProblem& problem) override {
    if (step.rpm == 0) AddEdge(step, problem);
    if (step.stroke == nullptr) {
      AddFlats(step, step.rpm * std::numbers::pi / 30, 0, 1, problem);
    } else {
      for (const StrokeWay& way : FindStrokeWays(*step.stroke, step.rpm, true)) {
        AddFlats(step, 0, way.mm_per_s, way.share, problem);
      }
    }
  }

  void Solved(const EffectSolved& solved) override {
    const StepProblem& problem = solved.problem;
    if (solved.rpm == 0) {
      const auto stopped_points = solved.edge.found_count();
      for (std::size_t n = 0; n < stopped_points; ++n) {
        const SolidPoint& solid = problem.solids[n];
        const double depth_mm = std::max(solid.depth_mm + problem.tau_s * Dot(solid.row, solved.u), 0.0);
        edge_force_N_[static_cast<std::size_t>(solved.edge.found_point(n))] = solid.stiffness_N_per_mm * depth_mm;
      }
      is_loaded_ = is_loaded_ || stopped_points > 0;
    }
    if (solved.faces != nullptr) GatherFlats(*solved.faces, solved);
  }

  void Release() override {
    if (!is_loaded_) return;
    is_loaded_ = false;
    patches_ = {};
    std::fill(edge_force_N_.begin(), edge_force_N_.end(), 0.0);
  }

  bool reads_teeth() const override { return false; }
  EffectCapacity capacity() const override { return {0, edge_force_N_.size() + 2 * kPatches}; }
  std::size_t CalcMemoryBytes() const override {
    return sizeof(*this) + edge_force_N_.capacity() * sizeof(double) + patch_of_pair_.capacity() * sizeof(int);
  }

 private:
  /// Patch of a flat over which friction is gathered: neighbouring points have similar slip.
  struct Patch {
    double force_N = 0;
    double x_N = 0, y_N = 0;  // force times position
  };

  void AddEdge(const EffectStep& step, StepProblem& problem) {
    for (std::size_t n = 0; n < step.edge.found_count(); ++n) {
      const auto point = static_cast<std::size_t>(step.edge.found_point(n));
      const double limit_N = coefficient_ * edge_force_N_[point];
      if (!(limit_N > 0)) continue;
      const Twist& row = problem.solids[n].row;
      const Vec3 into(row[0], row[1], row[2]);
      const Vec3 r = step.edge.Move(step.edge.point_T(point)) - p_TC_;
      const Vec3 a = glm::normalize(glm::cross(into, std::abs(into.z) < 0.7 ? Vec3(0, 0, 1) : Vec3(1, 0, 0)));
      problem.frictions.push_back({MakeRow(a, r), MakeRow(glm::cross(into, a), r), 0, 0, limit_N});
    }
  }

  /// `edge_mm_per_s`: velocity of a stroke along the edge. `share`: fraction of the patches' force.
  void AddFlats(const EffectStep& step, double spindle_rad_per_s, double edge_mm_per_s, double share,
                StepProblem& problem) {
    for (std::size_t n = 0; n < patches_.size(); ++n) {
      const Patch& patch = patches_[n];
      const double limit_N = share * coefficient_ * patch.force_N;
      if (!(limit_N > 0)) continue;
      const Vec3 p_T = step.edge.Move(
          {patch.x_N / patch.force_N, patch.y_N / patch.force_N, n < patches_.size() / 2 ? -half_mm_ : half_mm_});
      const Vec3 v_T = step.edge.motion().CalcVelocity(p_T, edge_mm_per_s);
      problem.frictions.push_back({MakeRow({1, 0, 0}, p_T - p_TC_), MakeRow({0, 1, 0}, p_T - p_TC_),
                                   -spindle_rad_per_s * p_T.y + v_T.x, spindle_rad_per_s * p_T.x + v_T.y, limit_N});
    }
  }

  int FindPatch(const Vec3& p_T) const {
    const double turn = std::atan2(p_T.y, p_T.x) / (2 * std::numbers::pi) + 0.5;
    const int sector = std::min(static_cast<int>(turn * kSectors), kSectors - 1);
    const int ring = std::min(static_cast<int>(std::hypot(p_T.x, p_T.y) / reach_mm_ * kRings), kRings - 1);
    return ring * kSectors + sector;
  }

  void GatherFlats(const Faces& faces, const EffectSolved& solved) {
    const StepProblem& problem = solved.problem;
    // The friction of the next step uses forces that follow these with a lag. Otherwise friction could throw the tool
    // off the wall in one tick, and the tool would return without friction in the next, again and again.
    const double fresh = 1 - std::exp(-solved.fraction * problem.tau_s / kFrictionLag_s);
    for (Patch& patch : patches_) {
      patch.force_N *= 1 - fresh;
      patch.x_N *= 1 - fresh;
      patch.y_N *= 1 - fresh;
    }
    const double fraction_borne = CalcFractionBorne(problem, solved.u);
    for (std::size_t n = 0; n < problem.flats.size(); ++n) {
      const FlatPoint& flat = problem.flats[n];
      const double depth_mm = FlatDepth(flat, problem, solved.u);
      if (!(depth_mm > 0)) continue;
      const std::size_t pair = faces.found_pair(n);
      const Vec3 p_T = faces.pair_T(pair);
      const int index = patch_of_pair_[pair] + (flat.side > 0 ? kSectors * kRings : 0);
      Patch& patch = patches_[static_cast<std::size_t>(index)];
      const double force_N = fresh * fraction_borne * problem.flat_stiffness_N_per_mm * depth_mm;
      patch.force_N += force_N;
      patch.x_N += force_N * p_T.x;
      patch.y_N += force_N * p_T.y;
      is_loaded_ = true;
    }
  }

  /// Returns the fraction of the walls' pressure that holds the disc against a load, 0 to 1. It includes the resultant,
  /// and the couple as far as a disc can transmit it before it bends out of the way. Without this limit, friction and
  /// couple would increase each other without bound, because the grip is about 80 mm above the disc. The rest of the
  /// pressure comes from an uneven kerf that squeezes the disc, which is rigid here; a real disc, whose rim has a
  /// stiffness of about 10 N/mm sideways, yields to it. Only the first part causes friction.
  double CalcFractionBorne(const StepProblem& problem, const Twist& u) const {
    double gross = 0, x = 0, y = 0;
    for (const FlatPoint& p : problem.flats) {
      const double d = FlatDepth(p, problem, u);
      gross += d;
      x += d * p.x;
      y += d * p.y;
    }
    if (!(gross > 0)) return 0;
    x /= gross;
    y /= gross;
    double net = 0, moment_x = 0, moment_y = 0, spread = 0;
    for (const FlatPoint& p : problem.flats) {
      const double d = FlatDepth(p, problem, u);
      net += p.side * d;
      moment_x += p.side * d * (p.y - y);
      moment_y += p.side * d * (p.x - x);
      spread += d * std::hypot(p.x - x, p.y - y);
    }
    const double turning = spread > 0 ? gross * std::hypot(moment_x, moment_y) / spread : 0;
    const double passed_on = std::min(turning, max_couple_N_ / problem.flat_stiffness_N_per_mm);
    return std::min(1.0, (std::abs(net) + passed_on) / gross);
  }

  double coefficient_;
  Vec3 p_TC_;
  double half_mm_;
  double max_couple_N_;  // sum of both forces of the couple
  double reach_mm_;
  bool is_loaded_ = false;  // true if any value below is not 0
  std::array<Patch, kPatches> patches_{};
  std::vector<int> patch_of_pair_;    // for the points on the lower side
  std::vector<double> edge_force_N_;  // normal force on each point of a stopped edge, in the last step
};

}  // namespace

const EffectInfo& KerfFriction() {
  static const EffectInfo kEffect{
      .name = "kerf_friction",
      .summary =
          "friction of the flats on the walls of the kerf and of a stopped edge on bone: stick and slip, binding of a "
          "tilted disc",
      .source = "Coulomb's law; the coefficient is an assumption: no value was found for steel on wet bone",
      .reads = "contact forces of flats and stopped edge, spindle speed, motion",
      .writes = "force and torque on the tool",
      .state = "normal force of each patch of the disc and each point of the edge",
      .sleeps = "while nothing presses on the flats or a stopped edge",
      .tool = EffectTool::kInHand,
      .hooks = kEffectEngage | kEffectSolved,
      .parameters = ListEffectParameters<KerfFrictionParams>(),
      .make = [](std::span<const EffectValue> values, const EffectSetup& setup) -> std::unique_ptr<Effect> {
        const auto params = ReadEffectParameters<KerfFrictionParams>(values);
        return std::make_unique<KerfFrictionEffect>(params.coefficient, setup);
      }};
  return kEffect;
}

}  // namespace kerf
