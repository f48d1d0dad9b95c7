// Tests of the film of a cut.
#include "session/watch/cut_film.h"

#include <gtest/gtest.h>

#include "bone/grid/set_leaf.h"
#include "bone/material/region_table.h"
#include "bone/models/block.h"

namespace kerf {
namespace {

void Take(CutFilm& film, const std::array<int, 3>& index, float value) {
  std::array<float, 512> values{};
  values.fill(value);
  film.Take(index, values);
}

/// Returns the first value of the leaf in the answer; none: the leaf does not change.
std::optional<float> ValueOf(const std::vector<FilmLeaf>& leaves, const std::array<int, 3>& index) {
  for (const FilmLeaf& leaf : leaves) {
    if (leaf.index == index) return leaf.values[0];
  }
  return {};
}

TEST(CutFilm, ShowsEachLeafAsItWasLastAtATime) {
  const Bone before = MakeBlock({}, DefaultMandibleTable());
  const std::array<int, 3> a{0, 0, 0}, b{8, 0, 0};
  FilmLeaf uncut{.index = a};
  GetCut(before, a, uncut.values);
  CutFilm film;
  film.set_time_s(1);
  Take(film, a, 11);
  film.set_time_s(1.05);  // soon after it: the same state
  Take(film, a, 12);
  film.set_time_s(2);
  Take(film, b, 21);
  film.set_time_s(3);
  Take(film, a, 13);
  // It is shown as it was last, so that nothing is to be replaced at the end.
  EXPECT_TRUE(film.Seek(9, before).empty());
  std::vector<FilmLeaf> leaves = film.Seek(2.5, before);
  EXPECT_EQ(leaves.size(), 1u);
  EXPECT_EQ(ValueOf(leaves, a), 12);
  leaves = film.Seek(0.5, before);
  EXPECT_EQ(ValueOf(leaves, a), uncut.values[0]);
  EXPECT_TRUE(ValueOf(leaves, b));
  EXPECT_TRUE(film.Seek(0.6, before).empty());
  leaves = film.Seek(1.5, before);
  EXPECT_EQ(leaves.size(), 1u);
  EXPECT_EQ(ValueOf(leaves, a), 12);
  leaves = film.Seek(9, before);
  EXPECT_EQ(ValueOf(leaves, a), 13);
  EXPECT_EQ(ValueOf(leaves, b), 21);
}

}  // namespace
}  // namespace kerf
