// The bone of a session as it was at each time, so that the cut can be shown again.
#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <map>
#include <mutex>
#include <span>
#include <vector>

#include "kerf/bone.h"

namespace kerf {

/// Time between two states of a leaf that are kept.
inline constexpr double kFilmStep_s = 0.1;
/// Maximum number of states: 80 MB. From then on, only the last state of a leaf is renewed.
inline constexpr std::size_t kMaxFilmStates = 40'000;

/// A leaf of a bone at one time, as in src/bone/grid/set_leaf.h.
struct FilmLeaf {
  std::array<int, 3> index{};
  std::array<float, 512> values{};
};

/// Keeps the changed leaves of a bone. Thread-safe.
class CutFilm {
 public:
  /// Sets the time of the leaves that are taken from now on; it must not decrease.
  void set_time_s(double time_s) { time_s_.store(time_s, std::memory_order_relaxed); }
  /// Takes a leaf that has changed.
  void Take(const std::array<int, 3>& index, std::span<const float, 512> values);
  /// Returns the leaves that must be replaced to show the bone at a time, if it is shown as at the last call or, before
  /// the first call, as it was last. `before`: the bone at the start.
  std::vector<FilmLeaf> Seek(double time_s, const Bone& before);

 private:
  struct State {
    double time_s;
    std::array<float, 512> values;
  };
  struct Leaf {
    std::vector<State> states;  // in the order of time
    std::size_t shown;          // number of states up to the one that is shown; 0: as before the session
  };
  std::atomic<double> time_s_{0};
  std::mutex mutex_;  // protects the rest
  std::map<std::array<int, 3>, Leaf> leaves_;
  std::size_t states_ = 0;
};

}  // namespace kerf
