// The cache of generated bones: the same bone with and without it, whatever its files contain.
#include "session/run/bone_cache.h"

#include <gtest/gtest.h>

#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <vector>

#include "bone/material/region_table.h"
#include "kerf/bone_file.h"
#include "session/run/overall_progress.h"
#include "support/folder.h"

namespace kerf {
namespace {

namespace fs = std::filesystem;

class BoneCache : public ::testing::Test {
 protected:
  BoneCache() { SetBoneCache(folder_.path() + "/bones"); }
  ~BoneCache() override { SetBoneCache(""); }

  /// Voxels so large that a bone is made at once.
  static MandibleParams Coarse(double voxel_mm = 2) {
    MandibleParams params;
    params.voxel_mm = voxel_mm;
    return params;
  }
  /// Returns the bone, and whether it was made: reading reports only the end of the progress.
  std::pair<Bone, bool> Get(const MandibleParams& params) const {
    int reports = 0;
    Bone bone = MakeCachedMandible(params, DefaultMandibleTable(), [&](double) { ++reports; });
    FinishKeepingBones();
    return {std::move(bone), reports > 1};
  }
  std::vector<fs::path> Files() const {
    std::vector<fs::path> files;
    if (!fs::exists(folder_.path() + "/bones")) return files;
    for (const auto& entry : fs::directory_iterator(folder_.path() + "/bones")) files.push_back(entry.path());
    return files;
  }

  test::Folder folder_;
};

TEST_F(BoneCache, TheSecondBoneIsReadAndIsTheSame) {
  const auto [first, first_made] = Get(Coarse());
  const auto [second, second_made] = Get(Coarse());
  EXPECT_TRUE(first_made);
  EXPECT_FALSE(second_made);
  EXPECT_EQ(first.CalcHash(), second.CalcHash());
  EXPECT_EQ(first.CalcMaterialHash(), second.CalcMaterialHash());
  EXPECT_EQ(first.notes(), second.notes());
  EXPECT_EQ(first.CalcVolume(), second.CalcVolume());
  EXPECT_EQ(Files().size(), 1u);
}

TEST_F(BoneCache, ABoneInItIsExpectedToTakeLessTime) {
  Scene scene;
  scene.bone.source = BoneSource::kMandible;
  scene.bone.mandible = Coarse();
  const auto making_s = [&] { return ListLoopStages(scene, {}, true).front().seconds; };
  const double made_s = making_s();
  EXPECT_FALSE(IsMandibleCached(Coarse()));
  Get(Coarse());
  EXPECT_TRUE(IsMandibleCached(Coarse()));
  EXPECT_FALSE(IsMandibleCached(Coarse(3)));
  EXPECT_LT(making_s(), made_s);
}

TEST_F(BoneCache, ABoneThatIsBeingKeptIsWaitedFor) {
  const Bone first = MakeCachedMandible(Coarse(), DefaultMandibleTable(), {});
  int reports = 0;
  const Bone second = MakeCachedMandible(Coarse(), DefaultMandibleTable(), [&](double) { ++reports; });
  EXPECT_EQ(reports, 1);
  EXPECT_EQ(first.CalcHash(), second.CalcHash());
}

TEST_F(BoneCache, ABoneThatWasBegunIsTakenOnce) {
  const Bone first = Get(Coarse(3)).first;
  SetBoneCache("");
  const MaterialTable& materials = DefaultMandibleTable();
  BeginCachedMandible(Coarse(3), materials);
  EXPECT_TRUE(Get(Coarse()).second);  // another one; FinishKeepingBones() drops the one that was begun
  EXPECT_TRUE(Get(Coarse(3)).second);
  BeginCachedMandible(Coarse(), materials);
  BeginCachedMandible(Coarse(3), materials);
  std::vector<double> between;  // reports of one that is made
  const Bone taken = MakeCachedMandible(Coarse(3), materials, [&](double fraction) {
    if (fraction > 0 && fraction < 1) between.push_back(fraction);
  });
  EXPECT_TRUE(between.empty());
  EXPECT_EQ(taken.CalcHash(), first.CalcHash());
  EXPECT_EQ(taken.CalcMaterialHash(), first.CalcMaterialHash());
  EXPECT_EQ(taken.notes(), first.notes());
  EXPECT_TRUE(Get(Coarse(3)).second);
  MandibleParams bad = Coarse();
  bad.voxel_mm = -1;
  BeginCachedMandible(bad, materials);
  EXPECT_THROW((void)MakeCachedMandible(bad, materials, {}), Error);
}

TEST_F(BoneCache, OtherParametersMakeAnotherBone) {
  (void)Get(Coarse());
  MandibleParams other = Coarse();
  other.canal_diameter_mm += 1e-9;
  EXPECT_TRUE(Get(other).second);
  EXPECT_FALSE(Get(other).second);
  EXPECT_FALSE(Get(Coarse()).second);
  EXPECT_EQ(Files().size(), 2u);
}

TEST_F(BoneCache, DamagedOrWrongFilesAreReplaced) {
  const Bone bone = Get(Coarse()).first;
  const fs::path file = Files().at(0);
  // Cut short, empty, and a good bone that is another one.
  fs::resize_file(file, fs::file_size(file) / 2);
  auto [made, is_made] = Get(Coarse());
  EXPECT_TRUE(is_made);
  EXPECT_EQ(made.CalcHash(), bone.CalcHash());
  fs::resize_file(file, 0);
  EXPECT_TRUE(Get(Coarse()).second);
  SetBoneCache("");
  const Bone other = MakeCachedMandible(Coarse(3), DefaultMandibleTable(), {});
  WriteBone(other, file.string());
  SetBoneCache(folder_.path() + "/bones");
  std::tie(made, is_made) = Get(Coarse());
  EXPECT_TRUE(is_made);
  EXPECT_EQ(made.CalcHash(), bone.CalcHash());
  EXPECT_EQ(Files(), std::vector{file});
  EXPECT_FALSE(Get(Coarse()).second);
}

TEST_F(BoneCache, FilesThatWereUsedLongestAgoAreRemoved) {
  (void)Get(Coarse(2));
  const fs::path old = Files().at(0);
  fs::last_write_time(old, fs::file_time_type::clock::now() - std::chrono::hours(1));
  // A file of holes, as large as the cache may be.
  const fs::path large = old.parent_path() / "mandible-0123456789abcdef-0123456789abcdef.vdb";
  std::ofstream(large).put('x');
  fs::resize_file(large, static_cast<std::uintmax_t>(kMaxBoneCacheBytes));
  // Files of others, and a link that leads nowhere, stay and do not matter.
  const fs::path other = old.parent_path() / "patient.vdb";
  std::ofstream(other).put('x');
  fs::resize_file(other, 2 * static_cast<std::uintmax_t>(kMaxBoneCacheBytes));
  fs::last_write_time(other, fs::file_time_type::clock::now() - std::chrono::hours(2));
  const fs::path link = old.parent_path() / "mandible-0000000000000000-0000000000000000.vdb";
  fs::create_symlink(link, link);
  (void)Get(Coarse(3));
  EXPECT_FALSE(fs::exists(old));
  EXPECT_FALSE(fs::exists(large));
  EXPECT_TRUE(fs::exists(other));
  EXPECT_TRUE(fs::is_symlink(link));
  EXPECT_EQ(Files().size(), 3u);
  EXPECT_FALSE(Get(Coarse(3)).second);
}

TEST_F(BoneCache, AFolderThatCannotBeUsedCostsOnlyTime) {
  std::ofstream(folder_.path() + "/file").put('x');
  SetBoneCache(folder_.path() + "/file/bones");
  const auto [bone, made] = Get(Coarse());
  EXPECT_TRUE(made);
  EXPECT_FALSE(bone.empty());
}

TEST_F(BoneCache, NothingIsKeptWithoutAFolder) {
  SetBoneCache("");
  EXPECT_TRUE(Get(Coarse()).second);
  EXPECT_TRUE(Get(Coarse()).second);
  EXPECT_TRUE(Files().empty());
}

TEST(FindBoneCache, TakesOnlyAbsolutePaths) {
  const char* const home = std::getenv("HOME");
  const std::string old_home = home == nullptr ? "" : home;
  setenv("XDG_CACHE_HOME", "/cache", 1);
  setenv("HOME", "/nowhere/ida", 1);
  EXPECT_EQ(FindBoneCache(), "/cache/kerf/bones");
  setenv("XDG_CACHE_HOME", "cache", 1);
  EXPECT_EQ(FindBoneCache(), "/nowhere/ida/.cache/kerf/bones");
  setenv("HOME", "", 1);
  EXPECT_EQ(FindBoneCache(), "");
  unsetenv("XDG_CACHE_HOME");
  setenv("HOME", old_home.c_str(), 1);
}

TEST_F(BoneCache, ParametersOutOfRangeAreRefused) {
  MandibleParams params = Coarse();
  params.teeth = 99;
  EXPECT_THROW((void)Get(params), Error);
}

TEST_F(BoneCache, ACancelledBoneIsNotKept) {
  struct Stop {};
  EXPECT_THROW((void)MakeCachedMandible(Coarse(), DefaultMandibleTable(), [](double) { throw Stop(); }), Stop);
  EXPECT_TRUE(Files().empty());
}

}  // namespace
}  // namespace kerf
