#include "experiment/stability/fuzz_run.h"

#include <fmt/format.h>

#include <chrono>
#include <cstdlib>

namespace kerf::test {
namespace {

constexpr int kMaxFailures = 5;

/// Calls of a failed sequence. Tests whether some of them break the same rule again on a new saw.
class Recording {
 public:
  Recording(std::uint64_t seed, FuzzTools tools, std::vector<FuzzCall> calls, const std::string& wrong)
      : seed_(seed), tools_(tools), calls_(std::move(calls)), rule_(Rule(wrong)) {}

  /// Removes calls as long as the rest breaks the same rule: halves, quarters, ... single calls.
  void Shorten() {
    for (std::size_t chunk = calls_.size() / 2; chunk > 0; chunk /= 2) {
      for (std::size_t at = 0; at + chunk <= calls_.size();) {
        std::vector<FuzzCall> fewer = calls_;
        fewer.erase(fewer.begin() + static_cast<long>(at), fewer.begin() + static_cast<long>(at + chunk));
        if (Breaks(fewer)) {
          calls_ = std::move(fewer);
        } else {
          at += chunk;
        }
      }
    }
  }
  /// Prints the calls and the outputs of the last ones.
  void Print() const {
    Dice dice(seed_);
    FuzzedSaw saw(MakeFuzzScene(dice, tools_));
    for (const FuzzCall& call : calls_) {
      fmt::print("  {};\n", ToText(call));
      saw.Do(call);
      if (call.kind != FuzzCall::Kind::kTick) continue;
      const CoupledOutput& o = saw.last();
      fmt::print(
          "    // status {:#x}, {}, {} substeps, {} iterations; mJ: hand {}, spindle {}, stored {}, cut {}, friction "
          "{}, damping {}, numerical {}; at {} {} {}\n",
          o.status, ToString(o.fidelity), o.substeps, o.iterations, o.hand_mJ, o.spindle_mJ, o.stored_mJ, o.cut_mJ,
          o.friction_mJ, o.damping_mJ, o.numerical_mJ, o.X_WT.p_AB.x, o.X_WT.p_AB.y, o.X_WT.p_AB.z);
    }
  }

 private:
  /// Returns the name of the invariant, or the first words of the message.
  static std::string Rule(const std::string& wrong) {
    return wrong.substr(0, wrong.empty() || wrong[0] != 'I' ? 15 : wrong.find_first_of(": "));
  }
  bool Breaks(const std::vector<FuzzCall>& calls) const {
    Dice dice(seed_);
    FuzzedSaw saw(MakeFuzzScene(dice, tools_));
    for (const FuzzCall& call : calls) {
      const std::string wrong = saw.Do(call);
      if (!wrong.empty()) return Rule(wrong) == rule_;
    }
    return Rule(saw.Account()) == rule_;
  }

  std::uint64_t seed_;
  FuzzTools tools_;
  std::vector<FuzzCall> calls_;
  std::string rule_;
};

}  // namespace

bool AskedForSeed(std::uint64_t& seed) {
  const char* asked = std::getenv("KERF_FUZZ_SEED");
  if (asked != nullptr) seed = std::strtoull(asked, nullptr, 10);
  return asked != nullptr;
}

FuzzResult FuzzCoupled(std::uint64_t seed, int calls, FuzzTools tools, FuzzedSaw::Counts& counts) {
  Dice dice(seed);
  const FuzzScene scene = MakeFuzzScene(dice, tools);
  FuzzedSaw saw(scene);
  FuzzHand hand(dice, scene, 100);
  std::vector<FuzzCall> made;
  FuzzResult result;
  for (; result.tick < calls && result.wrong.empty(); ++result.tick) {
    made.push_back(hand.Next(saw.X_WT()));
    result.wrong = saw.Do(made.back());
  }
  if (result.wrong.empty()) result.wrong = saw.Account();
  counts = saw.counts();
  std::uint64_t asked = 0;
  if (!result.wrong.empty() && AskedForSeed(asked)) {
    Recording recording(seed, tools, made, result.wrong);
    recording.Shorten();
    fmt::print("  {}\n", ToText(scene));
    recording.Print();
  }
  return result;
}

void RunFuzz(std::uint64_t first_seed, long ticks, const std::function<FuzzResult(std::uint64_t, long&)>& run) {
  const auto* info = ::testing::UnitTest::GetInstance()->current_test_info();
  const bool verbose = std::getenv("KERF_FUZZ_VERBOSE") != nullptr;
  std::uint64_t seed = first_seed;
  const bool one = AskedForSeed(seed);
  int failures = 0;
  long made = 0;
  for (; made < ticks && failures < kMaxFailures; ++seed) {
    const auto begin = std::chrono::steady_clock::now();
    const long before = made;
    const FuzzResult result = run(seed, made);
    if (verbose) {
      const std::chrono::duration<double, std::micro> took = std::chrono::steady_clock::now() - begin;
      fmt::print("seed {} ticks {} us_per_tick {:.1f}\n", seed, made - before,
                 took.count() / static_cast<double>(made - before));
    }
    if (!result.wrong.empty()) {
      ++failures;
      ADD_FAILURE() << result.wrong << "\nin tick " << result.tick << " of\n  KERF_FUZZ_SEED=" << seed
                    << " stability_test --gtest_filter=" << info->test_suite_name() << '.' << info->name();
    }
    if (one) break;
  }
}

}  // namespace kerf::test
