// All cases of a study, and their distribution over shards.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "base/table/shard.h"
#include "experiment/study/study_file.h"

namespace kerf {

/// The two kinds of work on a case. Each has a separate record.
enum class CaseWork { kErrors, kCosts };
std::string_view ToString(CaseWork work);  // "errors", "costs"

struct PlannedCase {
  std::string id;  // as in CaseRecord
  std::string path;
  Holding holding = Holding::kHand;
  std::string knob;   // "default" for the base settings
  std::string value;  // empty for the base settings
  StudySettings settings;
  std::string reference;     // its file name without extension: "slot.hand.law-edge_plus_chip"
  bool costs = true;         // whether the costs are measured
  int ticks = 0;             // number of ticks to time for the costs
  double errors_weight = 1;  // approximate effort, in any unit; for load balancing and estimating the remaining time
  double costs_weight = 1;
  /// Text with all inputs that the result of the work depends on, except for the program.
  std::string errors_input;
  std::string costs_input;

  const std::string& InputOf(CaseWork work) const { return work == CaseWork::kErrors ? errors_input : costs_input; }
  double WeightOf(CaseWork work) const { return work == CaseWork::kErrors ? errors_weight : costs_weight; }
  bool Has(CaseWork work) const { return work == CaseWork::kErrors || costs; }
};

struct StudyPlan {
  std::vector<PlannedCase> cases;
  std::uint64_t hash = 0;  // of all ids and inputs
};

using VariantFunction = std::function<std::string(const StudySettings&)>;

/// Returns the plan of a study, which depends on nothing but the arguments. The plan contains each path with each
/// holding at the base settings, and then with each knob at each value that differs from the base settings.
StudyPlan MakePlan(const StudySpec& spec, const VariantFunction& variant_of);

/// Distributes the cases over `count` shards. Returns the indices of the plan's cases by shard; each case is in exactly
/// one shard. Cases that share a reference are kept together as far as an even distribution of the work permits. Some
/// shards are empty if there are more shards than cases.
std::vector<std::vector<std::size_t>> SplitPlan(const StudyPlan& plan, int count);

}  // namespace kerf
