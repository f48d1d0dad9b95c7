#include "session/watch/cut_film.h"

#include <algorithm>

#include "bone/grid/set_leaf.h"

namespace kerf {

void CutFilm::Take(const std::array<int, 3>& index, std::span<const float, 512> values) {
  const double time_s = time_s_.load(std::memory_order_relaxed);
  const std::lock_guard lock(mutex_);
  Leaf& kept = leaves_[index];
  const bool renews =
      !kept.states.empty() && (time_s < kept.states.back().time_s + kFilmStep_s || states_ >= kMaxFilmStates);
  if (!renews) {
    kept.states.push_back({.time_s = time_s, .values = {}});
    ++states_;
  }
  std::copy(values.begin(), values.end(), kept.states.back().values.begin());
  kept.shown = kept.states.size();
}

std::vector<FilmLeaf> CutFilm::Seek(double time_s, const Bone& before) {
  std::vector<FilmLeaf> changed;
  const std::lock_guard lock(mutex_);
  for (auto& [index, leaf] : leaves_) {
    const auto next = std::upper_bound(leaf.states.begin(), leaf.states.end(), time_s,
                                       [](double t, const State& state) { return t < state.time_s; });
    const auto shown = static_cast<std::size_t>(next - leaf.states.begin());
    if (shown == leaf.shown) continue;
    leaf.shown = shown;
    FilmLeaf& now = changed.emplace_back(FilmLeaf{.index = index});
    if (shown == 0) {
      GetCut(before, index, now.values);
    } else {
      now.values = leaf.states[shown - 1].values;
    }
  }
  return changed;
}

}  // namespace kerf
