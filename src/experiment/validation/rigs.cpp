#include "experiment/validation/rigs.h"

#include <fmt/format.h>

#include <cmath>
#include <numbers>

#include "cut/tool/twist_drill.h"
#include "kerf/error.h"

namespace kerf {
namespace {

constexpr double kMaxBite_mm = 10;        // of a blade under a given force
constexpr double kThinBite_mm = 1e-6;     // stands for a bite just above 0
constexpr double kConstantForce = 1e-12;  // relative change of the force above which it depends on the bite

std::string Missing(std::string_view condition) {
  return fmt::format("{} is not known", condition);
}

/// Returns a phrase about the first of `names` that is not given; empty if all are given.
std::string FindMissing(MeasuredConditions c, std::initializer_list<std::string_view> names) {
  for (const std::string_view name : names) {
    if (!IsGiven(ConditionOf(c, name))) return Missing(name);
  }
  return {};
}

ToothState MakeState(double bite_mm, const MeasuredConditions& c) {
  return {bite_mm, IsGiven(c.speed_mm_per_s) ? c.speed_mm_per_s : 0, IsGiven(c.density) ? c.density : 1};
}

Simulated SimulateTooth(const ForceLaw& law, const MeasuredTool& tool, std::string_view quantity,
                        const MeasuredConditions& c) {
  if (std::string why = FindMissing(c, {"bite_um"}); !why.empty()) return {kNotGiven, why};
  const double bite_mm = c.bite_um / 1000;
  const LawOnTooth on_tooth(law, MakeReferenceDisc(tool.width_mm));
  return {CalcToothQuantity(quantity, on_tooth(MakeState(bite_mm, c)), tool.width_mm, bite_mm), {}};
}

/// Two lips, each a tooth, and the chisel edge of an ordinary drill; the margins are left out.
Simulated SimulateDrill(const ForceLaw& law, const MeasuredTool& tool, std::string_view quantity,
                        const MeasuredConditions& c) {
  if (std::string why = FindMissing(c, {"rpm", "feed_mm_per_min"}); !why.empty()) return {kNotGiven, why};
  const double sine = std::sin(0.5 * tool.point_deg * std::numbers::pi / 180);
  const double feed_mm = c.feed_mm_per_min / c.rpm;  // per turn
  const double bite_mm = 0.5 * feed_mm * sine;
  const double width_mm = 0.5 * tool.diameter_mm / sine;
  DiscSaw lips;  // Hertz's laws take radius and pitch of the drill
  lips.diameter_mm = tool.diameter_mm;
  lips.teeth = 2;
  lips.thickness_mm = width_mm;
  const ToothForces lip = LawOnTooth(law, lips)(MakeState(bite_mm, c));
  const double chisel = ToolKind<TwistDrill>::CalcChiselThrust({});
  const double thrust_N = 2 * lip.thrust_N * sine * (1 + chisel);
  // The chisel edge has a smaller lever.
  const double torque_Nmm =
      2 * lip.cutting_N * 0.25 * tool.diameter_mm * (1 + chisel * ToolKind<TwistDrill>::kChiselRadius);
  if (quantity == "thrust_N") return {thrust_N, {}};
  if (quantity == "torque_Nmm") return {torque_Nmm, {}};
  const double area_mm2 = 0.25 * std::numbers::pi * tool.diameter_mm * tool.diameter_mm;
  const double work_Nmm = 2 * std::numbers::pi * torque_Nmm + feed_mm * thrust_N;  // per turn
  return {1e-3 * work_Nmm / (area_mm2 * feed_mm), {}};
}

/// The force presses the blade in until its engaged teeth bite so deep that they carry it.
Simulated SimulateBladeForce(const ForceLaw& law, const MeasuredTool& tool, const MeasuredConditions& c) {
  if (std::string why = FindMissing(c, {"force_N", "speed_mm_per_s"}); !why.empty()) return {kNotGiven, why};
  const LawOnTooth on_tooth(law, MakeReferenceDisc(tool.width_mm));
  const auto thrust = [&](double bite_mm) { return tool.teeth * on_tooth(MakeState(bite_mm, c)).thrust_N; };
  if (!(thrust(kMaxBite_mm) > thrust(kThinBite_mm) * (1 + kConstantForce))) {
    return {kNotGiven, "the law's force does not depend on the bite, so the force does not determine the rate"};
  }
  double low_mm = 0;
  double high_mm = kMaxBite_mm;
  if (thrust(kThinBite_mm) >= c.force_N) high_mm = 0;
  if (thrust(kMaxBite_mm) < c.force_N) low_mm = kMaxBite_mm;
  for (int i = 0; i < 100 && low_mm < high_mm; ++i) {
    const double middle_mm = 0.5 * (low_mm + high_mm);
    (thrust(middle_mm) > c.force_N ? high_mm : low_mm) = middle_mm;
  }
  return {tool.teeth * tool.width_mm * low_mm * c.speed_mm_per_s, {}};
}

/// The bite is proportional to feed / speed.
Simulated SimulateBladeFeed(const ForceLaw& law, const MeasuredSet& set, std::string_view quantity,
                            const MeasuredConditions& c) {
  const MeasuredConditions& middle = set.conditions;
  MeasuredConditions tooth = c;
  tooth.bite_um =
      middle.bite_um * (c.feed_mm_per_min / middle.feed_mm_per_min) * (middle.cycles_per_min / c.cycles_per_min);
  if (quantity != "temperature_rise") return SimulateTooth(law, set.tool, quantity, tooth);
  // Heat flux into the floor of the kerf, energy per volume x feed, for a time proportional to 1 / feed: the surface of
  // a half space warms with flux x sqrt(time).
  Simulated energy = SimulateTooth(law, set.tool, "energy_J_per_mm3", tooth);
  energy.value *= std::sqrt(c.feed_mm_per_min);
  return energy;
}

}  // namespace

double CalcToothQuantity(std::string_view quantity, const ToothForces& forces, double width_mm, double bite_mm) {
  if (quantity == "thrust_N") return forces.thrust_N;
  if (quantity == "cutting_N") return forces.cutting_N;
  if (quantity == "resultant_N") return std::hypot(forces.thrust_N, forces.cutting_N);
  if (quantity == "thrust_per_cutting") return forces.thrust_N / forces.cutting_N;
  if (quantity == "energy_J_per_mm3") return 1e-3 * forces.cutting_N / (width_mm * bite_mm);
  throw Error(fmt::format("a tooth has no {}", quantity));
}

bool UsesCuttingForce(std::string_view quantity) {
  return quantity != "thrust_N" && quantity != "removal_mm3_per_s";
}

Simulated SimulateQuantity(const ForceLaw& law, const MeasuredSet& set, std::string_view quantity,
                           const MeasuredConditions& at) {
  const bool assumed = UsesCuttingForce(quantity) && !HasCuttingForce(law);
  if (assumed && quantity == "thrust_per_cutting") {
    return {kNotGiven, "the law has no cutting force"};
  }
  const MeasuredConditions c = JoinConditions(at, set.conditions);
  const std::string_view kind = set.tool.kind;
  Simulated simulated = kind == kToolTooth        ? SimulateTooth(law, set.tool, quantity, c)
                        : kind == kToolDrill      ? SimulateDrill(law, set.tool, quantity, c)
                        : kind == kToolBladeForce ? SimulateBladeForce(law, set.tool, c)
                        : kind == kToolBladeFeed  ? SimulateBladeFeed(law, set, quantity, c)
                                                  : Simulated{kNotGiven, "the set has no tool"};
  if (simulated.why.empty() && !std::isfinite(simulated.value)) return {kNotGiven, "the law's cutting force is 0"};
  simulated.assumed_ratio = assumed;
  return simulated;
}

double CountCarriedTeeth(const ForceLaw& law, double width_mm, double force_N) {
  const LawOnTooth on_tooth(law, MakeReferenceDisc(width_mm));
  return std::floor(force_N / on_tooth({kThinBite_mm, 0, 1}).thrust_N);
}

}  // namespace kerf
