// Slices that can be read, and whose values are not those of their place.
#include "bone/import/unfit_slices.h"

#include <gmock/gmock.h>

#include <cmath>
#include <filesystem>
#include <random>
#include <utility>

#include "bone/import/import.h"
#include "ct_files.h"
#include "support/jaw_ct.h"
#include "test_paths.h"

namespace kerf {
namespace {

using test::Folder;
using ::testing::IsEmpty;

// The jaw with the noise of a scanner, of 15 HU, from -1024 HU on.
Volume NoisyJaw(double spacing_mm = 2) {
  Volume ct = test::JawCt(spacing_mm);
  std::mt19937_64 random(20261201);
  std::normal_distribution<double> noise(0, 15);
  for (std::int16_t& hu : ct.hu) hu = static_cast<std::int16_t>(std::lround(std::max(hu + noise(random), -1024.0)));
  return ct;
}

using ChangeSlice = std::function<void(Volume& ct, int k)>;

template <typename Change>
ChangeSlice EachPixel(Change&& change) {
  return [change](Volume& ct, int k) {
    for (int j = 0; j < ct.size[1]; ++j) {
      for (int i = 0; i < ct.size[0]; ++i) ct.hu[ct.Index(i, j, k)] = change(ct, i, j, k);
    }
  };
}

ChangeSlice CopyOf(int from) {
  return EachPixel([from](const Volume& ct, int i, int j, int) { return ct.hu[ct.Index(i, j, from)]; });
}

// What happens to a slice, and what is said of it.
using Spoils = std::vector<std::pair<ChangeSlice, std::string>>;

Spoils ListDamage() {
  return {
      {EachPixel([](const Volume&, int, int, int) { return std::int16_t{-1024}; }), "have one value each"},
      {EachPixel([](const Volume& ct, int i, int j, int k) {
         return j < ct.size[1] / 2 ? ct.hu[ct.Index(i, j, k)] : std::int16_t{-1024};
       }),
       "have one value each"},
  };
}

// What metal, few photons or motion may do as well.
Spoils ListDoubtful() {
  const auto random = std::make_shared<std::mt19937_64>(1);
  return {
      {EachPixel(
           [random](const Volume&, int, int, int) { return static_cast<std::int16_t>((*random)() % 3000 - 1000); }),
       "little in common"},
      {EachPixel([](const Volume& ct, int i, int j, int k) {  // one byte lost
         const int stored = ct.hu[ct.Index(i, j, k)] + 1024;
         return static_cast<std::int16_t>((stored >> 8 | (stored & 0xff) << 8) - 1024);
       }),
       "little in common"},
  };
}

UnfitSlices FindIn(const Volume& ct) {
  DicomSlice slice;
  slice.size = {ct.size[0], ct.size[1]};
  return FindUnfitSlices(std::vector(static_cast<std::size_t>(ct.size[2]), slice), ct.hu.data());
}

void ExpectNothingIn(const Volume& ct) {
  const UnfitSlices found = FindIn(ct);
  EXPECT_THAT(found.damaged, IsEmpty());
  EXPECT_THAT(found.doubtful, IsEmpty());
}

void ExpectOnly(const SliceFaults& found, const SliceFaults& others, int k, const std::string& why) {
  ASSERT_EQ(found.size(), 1u) << why;
  EXPECT_EQ(found.begin()->first, static_cast<std::size_t>(k)) << why;
  EXPECT_THAT(found.begin()->second, ::testing::HasSubstr(why));
  EXPECT_THAT(others, IsEmpty()) << why;
}

TEST(UnfitSlices, AreFoundWithAndWithoutNoise) {
  for (const Volume& ct : {test::JawCt(), NoisyJaw(), NoisyJaw(3)}) {
    ExpectNothingIn(ct);
    const int middle = ct.size[2] / 4;
    const auto find = [&](const ChangeSlice& change) {
      Volume changed = ct;
      change(changed, middle);
      return FindIn(changed);
    };
    for (const auto& [damage, why] : ListDamage()) {
      const UnfitSlices found = find(damage);
      ExpectOnly(found.damaged, found.doubtful, middle, why);
    }
    for (const auto& [change, why] : ListDoubtful()) {
      const UnfitSlices found = find(change);
      ExpectOnly(found.doubtful, found.damaged, middle, why);
    }
    for (const int from : {middle - 1, middle + 1}) {  // as interpolation to other places gives them
      const UnfitSlices found = find(CopyOf(from));
      ExpectOnly(found.doubtful, found.damaged, middle, "exactly those of");
    }
    const UnfitSlices found = find(CopyOf(middle + 5));
    ExpectOnly(found.damaged, found.doubtful, middle, "exactly those of");
  }
}

// Of bone in a background of one value, a slice may show less than both neighbours.
TEST(UnfitSlices, RowsOfTheBackgroundAreNoDamage) {
  Volume ct = test::JawCt();
  for (std::int16_t& hu : ct.hu) hu = std::max(hu, std::int16_t{-1000});
  const int middle = ct.size[2] / 4;
  int shown = 0;
  for (int j = 0; j < ct.size[1]; ++j) {
    const auto shows = [&](int k) {
      const auto row = ct.hu.begin() + static_cast<std::ptrdiff_t>(ct.Index(0, j, k));
      const auto [least, most] = std::minmax_element(row, row + ct.size[0]);
      return *most - *least > 300;
    };
    if (!shows(middle - 1) || !shows(middle + 1) || ++shown > 10) continue;
    for (int i = 0; i < ct.size[0]; ++i) ct.hu[ct.Index(i, j, middle)] = -1000;
  }
  ASSERT_GT(shown, 22);
  ExpectNothingIn(ct);
}

// Metal in one slice, a patient who moved for one, doubled slices, air and noise at the ends, and empty ends.
TEST(UnfitSlices, WhatScansShowIsNoDamage) {
  const Volume ct = NoisyJaw();
  const int middle = ct.size[2] / 4;
  Volume metal = ct;
  EachPixel([](const Volume& v, int i, int j, int k) {
    const double x = i - 32, y = j - 12, r = std::hypot(x, y);
    const double streak = 1500 * std::sin(14 * std::atan2(y, x)) * std::exp(-r / 9);
    return static_cast<std::int16_t>(std::lround(std::clamp(v.hu[v.Index(i, j, k)] + streak, -1024.0, 3071.0)));
  })(metal, middle);
  ExpectNothingIn(metal);
  Volume moved = ct;
  const Volume& still = ct;
  EachPixel([&still](const Volume&, int i, int j, int k) { return still.hu[still.Index(std::max(i - 2, 0), j, k)]; })(
      moved, middle);
  ExpectNothingIn(moved);
  Volume doubled = ct;
  for (int k = 1; k < ct.size[2]; k += 2) CopyOf(k - 1)(doubled, k);
  ExpectNothingIn(doubled);
  Volume phases = ct;
  for (int k = 1; k < ct.size[2]; k += 2) {
    EachPixel([&still](const Volume&, int i, int j, int k_of) {
      return still.hu[still.Index(i, still.size[1] - 1 - j, k_of)];
    })(phases, k);
  }
  ExpectNothingIn(phases);
  Volume ends = ct;
  const auto random = std::make_shared<std::mt19937_64>(1);
  for (const int k : {0, 1, 2, ct.size[2] - 2, ct.size[2] - 1}) {
    EachPixel([random](const Volume&, int, int, int) { return static_cast<std::int16_t>((*random)() % 50 - 1024); })(
        ends, k);
  }
  ExpectNothingIn(ends);
  for (const int k : {0, 1, 2, ct.size[2] - 2, ct.size[2] - 1}) {
    EachPixel([](const Volume&, int, int, int) { return std::int16_t{-1024}; })(ends, k);
  }
  ExpectNothingIn(ends);
}

TEST(UnfitSlices, AreTreatedAsMissing) {
  const Volume whole = NoisyJaw();
  ImportOptions options;
  options.voxel_mm = 1;
  const auto write = [](const Volume& ct, const Folder& folder) {
    for (int k = 0; k < ct.size[2]; ++k)
      test::WriteBytes(folder.file(fmt::format("{:03}.dcm", k)), test::DicomSlice(ct, k, {}));
  };
  const Folder good;
  write(whole, good);
  const double whole_mm3 = Import(good.path(), options).report.iso_mm3;
  Spoils damages = ListDamage();
  damages.emplace_back(CopyOf(8), "its values are exactly those of 008.dcm");
  for (const auto& [damage, why] : damages) {
    const Folder folder;
    Volume ct = whole;
    damage(ct, 12);
    write(ct, folder);
    const std::string said = test::MessageOf([&] { Import(folder.path(), options); });
    EXPECT_THAT(said, ::testing::HasSubstr("1 slice is missing between 011.dcm and 013.dcm"));
    EXPECT_THAT(said, ::testing::HasSubstr("012.dcm: "));
    EXPECT_THAT(said, ::testing::HasSubstr(why));
    ct = whole;
    damage(ct, 43);
    write(ct, folder);
    const ImportReport report = Import(folder.path(), options).report;
    EXPECT_NEAR(report.iso_mm3 / whole_mm3, 1, 0.005);
    EXPECT_THAT(report.warnings, ::testing::Contains(::testing::StartsWith("1 file was left out: 043.dcm ("))) << why;
  }
  // Every second slice is damaged over a part of the jaw: no second spacing.
  const Folder alternating;
  Volume ct = whole;
  for (const int k : {11, 13, 15}) ListDamage().front().first(ct, k);
  write(ct, alternating);
  EXPECT_THAT(test::MessageOf([&] { Import(alternating.path(), options); }),
              ::testing::HasSubstr("1 slice is missing between 010.dcm and 012.dcm"));
}

TEST(UnfitSlices, DoubtfulOnesAreKeptAndNamed) {
  const Folder folder;
  const Volume whole = NoisyJaw();
  Volume ct = whole;
  CopyOf(11)(ct, 12);
  for (int k = 0; k < ct.size[2]; ++k)
    test::WriteBytes(folder.file(fmt::format("{:03}.dcm", k)), test::DicomSlice(ct, k, {}));
  ImportOptions options;
  options.voxel_mm = 1;
  const ImportReport report = Import(folder.path(), options).report;
  EXPECT_THAT(report.warnings,
              ::testing::Contains(::testing::StartsWith(
                  "012.dcm may be damaged: its values are exactly those of 011.dcm; metal and motion do the same")));
}

TEST(RealData, HasNoUnfitSlices) {
  for (const char* name : {"visible_human_female/dicom", "phantom_siemens/dicom", "ge_head_tilted"}) {
    const std::string folder = std::string(KERF_TEST_DATA) + "/" + name;
    if (!std::filesystem::exists(folder)) GTEST_SKIP() << "not found: " << folder;
    const Volume ct = ReadDicomSeries(ListDicomSeries(folder).front(), {});
    EXPECT_THAT(ct.warnings, ::testing::Not(::testing::Contains(::testing::HasSubstr("damaged")))) << name;
  }
}

}  // namespace
}  // namespace kerf
