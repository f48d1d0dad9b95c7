#include "bone/vdb/bonefile.h"

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <openvdb/io/File.h>
#include <unistd.h>

#include <cmath>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <limits>
#include <random>
#include <sstream>

#include "base/files/files.h"
#include "bone/grid/build.h"
#include "bone/grid/ct_modulus.h"
#include "bone/grid/grids.h"
#include "kerf/error.h"
#include "support/memory_limit.h"
#include "support/message_of.h"
#include "support/one_core.h"
#include "support/solids.h"
#include "test_paths.h"

namespace kerf {
namespace {

namespace fs = std::filesystem;

/// Writes the file again as a program would that knows OpenVDB but not kerf; such a program copies the metadata. kerf's
/// checksum does not detect damage to the new file.
void WriteAgainByOpenVdb(const std::string& from, const std::string& to, bool with_checksum = true) {
  openvdb::io::File file(from);
  file.open(false);
  openvdb::MetaMap meta(*file.getMetadata());
  if (!with_checksum) meta.removeMeta("kerf_checksum");
  openvdb::GridPtrVec grids;
  for (const char* name : {"phi", "region", "hu"}) {
    if (file.hasGrid(name)) grids.push_back(file.readGrid(name));
  }
  openvdb::io::File out(to);
  out.write(grids, meta);
  out.close();
}

class BoneFile : public testing::Test {
 protected:
  void SetUp() override {
    folder_ = fs::temp_directory_path() / ("kerf_bonefile_" + std::to_string(getpid()));
    fs::create_directories(folder_);
  }
  void TearDown() override { fs::remove_all(folder_); }

  std::string Path(const std::string& name) const { return (folder_ / name).string(); }
  static std::string MessageOf(const std::string& path, const ReadBoneOptions& options = {}) {
    return test::MessageOf([&] { ReadBone(path, options); }, "accepted");
  }

  fs::path folder_;
};

TEST_F(BoneFile, RoundTripKeepsEverything) {
  Bone bone = test::MakeSphere({10, -20, 30}, 4, 0.2);
  bone.set_note("input", "a sphere, \"quoted\"\nand a second line");
  WriteBone(bone, Path("a.vdb"));
  const Bone read = ReadBone(Path("a.vdb"));
  EXPECT_EQ(read.CalcHash(), bone.CalcHash());
  EXPECT_EQ(read.notes(), bone.notes());
  EXPECT_EQ(read.voxel_mm(), bone.voxel_mm());
  EXPECT_EQ(read.region_voxel_mm(), bone.region_voxel_mm());
  ASSERT_EQ(read.materials().regions().size(), 1u);
  const Region& region = read.materials().At(24);
  EXPECT_EQ(region.E_MPa, 19300);
  EXPECT_EQ(region.nu, 0.28);
  EXPECT_EQ(region.tissue, Tissue::kCortical);
  EXPECT_EQ(region.source, "test");
  EXPECT_TRUE(region.estimate);
}

TEST_F(BoneFile, CopyAsStoredIsWhatTheFileHolds) {
  Bone bone = test::MakeSphere({10, -20, 30}, 4, 0.2);
  SetHu(
      bone, [](const Vec3& p) { return 100 * p.x; }, 0.5);
  bone.set_note("input", "a sphere");
  WriteBone(bone, Path("plain.vdb"));
  // A run overrides the materials; the file keeps the original ones.
  bone.OverrideMaterials(test::OneRegionTable(24, 1000, 0.4));
  WriteBone(bone, Path("a.vdb"));
  for (const bool hu : {false, true}) {
    const Bone read = ReadBone(Path("a.vdb"), {.hu = hu});
    const Bone copy = CopyAsStored(bone, {.hu = hu});
    EXPECT_EQ(copy.has_hu(), hu);
    EXPECT_EQ(copy.hu_voxel_mm(), read.hu_voxel_mm());
    EXPECT_EQ(copy.CalcHash(), read.CalcHash());
    EXPECT_EQ(copy.CalcMaterialHash(), read.CalcMaterialHash());
    EXPECT_NE(copy.CalcMaterialHash(), bone.CalcMaterialHash());
    EXPECT_EQ(copy.CalcVolume(), read.CalcVolume());
    EXPECT_EQ(copy.CalcRegionVolumes(), read.CalcRegionVolumes());
    EXPECT_EQ(copy.CountActiveVoxels(), read.CountActiveVoxels());
    EXPECT_EQ(copy.notes(), read.notes());
    EXPECT_EQ(copy.CalcMaterialHash(), ReadBone(Path("plain.vdb")).CalcMaterialHash());
  }
}

TEST_F(BoneFile, OtherFilesAreRefusedInOneSentence) {
  EXPECT_EQ(MessageOf(Path("none.vdb")), Path("none.vdb") + ": there is no such file; 'kerf import INPUT -o " +
                                             Path("none.vdb") + "' makes it from a CT or a closed surface");
  std::ofstream(Path("text.vdb")) << "this is no volume";
  EXPECT_NE(MessageOf(Path("text.vdb")).find(": not a valid OpenVDB file ("), std::string::npos);
  std::ofstream(Path("empty.vdb")).close();
  EXPECT_NE(MessageOf(Path("empty.vdb")).find(": not a valid OpenVDB file ("), std::string::npos);
}

TEST_F(BoneFile, TruncatedAndCorruptFilesNeverCrash) {
  Bone bone = test::MakeSphere({0, 0, 0}, 2, 0.4);
  SetHu(
      bone, [](const Vec3& p) { return 100 * p.x; }, 0.5);
  WriteBone(bone, Path("a.vdb"));
  WriteAgainByOpenVdb(Path("a.vdb"), Path("whole.vdb"));
  const std::string whole = ReadTextFile(Path("whole.vdb"));
  std::mt19937 random(11);
  for (int n = 0; n < 240; ++n) {
    std::string content = whole;
    if (n % 2 == 0) {
      content.resize(random() % whole.size());
    } else {
      for (int k = 0; k < 4; ++k) content[random() % content.size()] = static_cast<char>(random());
    }
    std::ofstream(Path("b.vdb"), std::ios::binary) << content;
    // Either the file is refused with a one-sentence message, or the change had no effect; nothing else may happen.
    const std::string message = MessageOf(Path("b.vdb"), {.hu = true});
    EXPECT_EQ(MessageOf(Path("b.vdb")).find('\n'), std::string::npos);
    if (n % 2 == 0) {
      EXPECT_NE(message, "accepted") << "cut off at " << content.size() << " of " << whole.size();
    }
    EXPECT_EQ(message.find('\n'), std::string::npos);
  }
}

/// Treats every position in a file as a possible length. Ends the process, with exit status 0 if no absurd value at any
/// position causes a large allocation.
[[noreturn]] void ReadLyingFiles(const std::string& path) {
  test::UseOneCore();
  Bone bone = test::MakeSphere({10, 10, 10}, 1, 0.4);
  SetHu(
      bone, [](const Vec3& p) { return 100 * p.x; }, 0.5);
  WriteBone(bone, path);
  WriteAgainByOpenVdb(path, path + ".again");
  const std::string whole = ReadTextFile(path + ".again");
  fs::remove(path);
  fs::remove(path + ".again");
  std::istringstream first(whole);
  ReadBone(first, "whole", {.hu = true});  // makes OpenVDB and TBB allocate the memory that they keep
  test::LimitMemory(std::uint64_t{256} << 20);
  constexpr std::size_t kStep = 3;  // a length has 4 or 8 bytes
  for (std::size_t at = 0; at + 8 <= whole.size(); at += kStep) {
    for (const std::int64_t lie : {std::int64_t{1} << 40, -(std::int64_t{1} << 33), std::int64_t{0x7fffffff}}) {
      std::string content = whole;
      std::memcpy(content.data() + at, &lie, sizeof lie);
      std::istringstream in(content);
      try {
        ReadBone(in, "lie", {.hu = true});
      } catch (const Error& e) {
        if (std::string(e.what()).find("bad_alloc") == std::string::npos) continue;
        std::cerr << lie << " at byte " << at << ": " << e.what() << "\n";
        std::_Exit(1);
      }
    }
  }
  std::_Exit(0);
}

TEST_F(BoneFile, FalseLengthsNeverCauseLargeAllocations) {
  testing::FLAGS_gtest_death_test_style = "threadsafe";
  EXPECT_EXIT(ReadLyingFiles(Path("lie.vdb")), testing::ExitedWithCode(0), "");
}

TEST_F(BoneFile, FalseLengthsAreRefusedInOneSentence) {
  WriteBone(test::MakeSphere({10, 10, 10}, 1, 0.4), Path("a.vdb"));
  const std::string whole = ReadTextFile(Path("a.vdb"));
  // The file begins with 8 bytes of magic number, 12 of versions, 1 of offsets and 36 of identity; then follow the
  // number of metadata entries and the length of the first name.
  const auto with = [&](std::size_t at, std::uint32_t value) {
    std::string content = whole;
    std::memcpy(content.data() + at, &value, sizeof value);
    std::ofstream(Path("b.vdb"), std::ios::binary) << content;
    return MessageOf(Path("b.vdb"));
  };
  EXPECT_NE(with(8, 300).find("not a valid OpenVDB file (version 300; kerf reads 222 to 224)"), std::string::npos);
  EXPECT_NE(with(57, 4'000'000'000).find("4000000000 entries of metadata; kerf reads up to 1000"), std::string::npos);
  EXPECT_NE(with(61, 4'000'000'000).find("a text of 4000000000 bytes, but "), std::string::npos);
}

TEST_F(BoneFile, AFlippedBitAnywhereIsFound) {
  Bone bone = test::MakeSphere({10, 10, 10}, 1, 0.4);
  SetHu(
      bone, [](const Vec3& p) { return 100 * p.x; }, 0.5);
  bone.set_note("input", "a sphere");
  WriteBone(bone, Path("a.vdb"));
  const std::string whole = ReadTextFile(Path("a.vdb"));
  std::mt19937 random(3);
  std::size_t by_checksum = 0;
  for (std::size_t at = 0; at < whole.size(); ++at) {
    std::string content = whole;
    content[at] = static_cast<char>(content[at] ^ (1 << random() % 8));
    std::istringstream in(content);
    try {
      ReadBone(in, "flipped");
      FAIL() << "byte " << at << " of " << whole.size();
    } catch (const Error& e) {
      if (std::string(e.what()).find("checksum that kerf wrote; use another copy") != std::string::npos) ++by_checksum;
    }
  }
  // The other files are not recognised as OpenVDB files, so the checksum is not reached.
  EXPECT_GT(by_checksum, whole.size() / 4);
}

TEST_F(BoneFile, FilesWithoutOwnChecksumAreRead) {
  const Bone bone = test::MakeSphere({10, 10, 10}, 1, 0.4);
  WriteBone(bone, Path("a.vdb"));
  EXPECT_NE(ReadTextFile(Path("a.vdb")).find("kerf_checksum"), std::string::npos);
  WriteAgainByOpenVdb(Path("a.vdb"), Path("again.vdb"));
  EXPECT_NE(ReadTextFile(Path("again.vdb")).find("kerf_checksum"), std::string::npos);
  EXPECT_EQ(ReadBone(Path("again.vdb")).CalcHash(), bone.CalcHash());
  WriteAgainByOpenVdb(Path("a.vdb"), Path("earlier.vdb"), false);
  EXPECT_EQ(ReadTextFile(Path("earlier.vdb")).find("kerf_checksum"), std::string::npos);
  EXPECT_EQ(ReadBone(Path("earlier.vdb")).CalcHash(), bone.CalcHash());
}

TEST_F(BoneFile, FailedWriteKeepsTheOldFile) {
  const Bone bone = test::MakeSphere({0, 0, 0}, 2, 0.4);
  WriteBone(bone, Path("a.vdb"));
  fs::create_directory(Path("folder.vdb"));
  EXPECT_THROW(WriteBone(bone, Path("folder.vdb")), Error);
  EXPECT_THROW(WriteBone(bone, Path("missing/a.vdb")), Error);
  EXPECT_EQ(ReadBone(Path("a.vdb")).CalcHash(), bone.CalcHash());
  // No temporary files are left behind.
  EXPECT_EQ(std::distance(fs::directory_iterator(folder_), fs::directory_iterator{}), 2);
}

TEST_F(BoneFile, CtNumbersAreReadOnlyOnRequest) {
  Bone bone = test::MakeSphere({10, -20, 30}, 4, 0.2);
  WriteBone(bone, Path("plain.vdb"));
  const auto hu = [](const Vec3& p) { return 300 + 10 * p.x - 7 * p.y + p.z; };
  SetHu(bone, hu, 0.6);
  WriteBone(bone, Path("hu.vdb"));

  Bone with = ReadBone(Path("hu.vdb"), {.hu = true});
  EXPECT_EQ(with.hu_voxel_mm(), 0.6);
  EXPECT_EQ(with.CalcHash(), bone.CalcHash());
  EXPECT_EQ(with.CalcMemoryBytes(), bone.CalcMemoryBytes());
  const HuRange a = CalcHuRange(bone);
  const HuRange b = CalcHuRange(with);
  EXPECT_EQ(a.voxels, b.voxels);
  EXPECT_EQ(a.min, b.min);
  EXPECT_EQ(a.mean, b.mean);
  EXPECT_EQ(a.max, b.max);
  EXPECT_NEAR(b.mean, hu({10, -20, 30}), 1);

  const Bone without = ReadBone(Path("hu.vdb"));
  EXPECT_FALSE(without.has_hu());
  EXPECT_EQ(without.CalcHash(), bone.CalcHash());
  EXPECT_EQ(without.CalcMemoryBytes(), ReadBone(Path("plain.vdb")).CalcMemoryBytes());
  EXPECT_FALSE(ReadBone(Path("plain.vdb"), {.hu = true}).has_hu());
  // Without a checksum, the HU are not even read: a file that is cut off within them (the last grid) still yields the
  // bone.
  const std::string own = ReadTextFile(Path("hu.vdb"));
  std::ofstream(Path("cut.vdb"), std::ios::binary) << own.substr(0, own.size() - 100);
  EXPECT_NE(MessageOf(Path("cut.vdb")).find("is damaged"), std::string::npos);
  WriteAgainByOpenVdb(Path("hu.vdb"), Path("again.vdb"));
  const std::string whole = ReadTextFile(Path("again.vdb"));
  std::ofstream(Path("cut.vdb"), std::ios::binary) << whole.substr(0, whole.size() - 100);
  EXPECT_EQ(ReadBone(Path("cut.vdb")).CalcHash(), bone.CalcHash());
  EXPECT_NE(MessageOf(Path("cut.vdb"), {.hu = true}).find("not a valid OpenVDB file"), std::string::npos);
}

TEST_F(BoneFile, InvalidCtNumbersAreRefused) {
  Bone bone = test::MakeSphere({0, 0, 0}, 2, 0.4);
  for (const double bad : {std::nan(""), 1e6, -std::numeric_limits<double>::infinity()}) {
    SetHu(
        bone, [bad](const Vec3& p) { return p.x > 1 ? bad : 100; }, 0.5);
    WriteBone(bone, Path("a.vdb"));
    EXPECT_EQ(MessageOf(Path("a.vdb"), {.hu = true}),
              Path("a.vdb") + ": grid \"hu\" contains a value that is not a CT number");
    EXPECT_EQ(MessageOf(Path("a.vdb")), "accepted");
  }
}

TEST_F(BoneFile, OverriddenConstantsAreNotWritten) {
  Bone bone = test::MakeSphere({0, 0, 0}, 2, 0.4);
  bone.OverrideMaterials(MakeUniformTable(bone.materials(), 1000, 0.1));
  bone.OverrideMaterials(MakeUniformTable(bone.materials(), 2000, 0.2));
  EXPECT_EQ(bone.materials().At(24).E_MPa, 2000);
  WriteBone(bone, Path("a.vdb"));
  EXPECT_EQ(ReadBone(Path("a.vdb")).materials().At(24).E_MPa, 19300);
  EXPECT_EQ(ReadBone(Path("a.vdb")).materials().At(24).source, "test");
}

/// Makes a bone with two regions, so that the region grid has more than one value.
Bone MakeTwoRegions() {
  SolidField field = test::SphereField({1, -2, 3}, 4);
  field.region = [](const Vec3& p) { return p.x < 1 ? 24 : 255; };
  MaterialTable table = test::OneRegionTable();
  Region other = table.At(24);
  other.id = 255;
  table.Add(other);
  return MakeBone(field, Box3{Vec3(-6), Vec3(9)}, {0.2, 0.3, {}}, table);
}

/// A script that prints a file's metadata, then each grid's name, type, active voxels and values at the coordinates.
constexpr char kReadWithPython[] = R"(
import sys, pyopenvdb
grids, metadata = pyopenvdb.readAll(sys.argv[1])
print(metadata['kerf_format'], metadata['units'], metadata['note_input'])
for grid in sorted(grids, key=lambda grid: grid.name):
  accessor = grid.getConstAccessor()
  values = [accessor.getValue(tuple(int(i) for i in c.split(','))) for c in sys.argv[2:]]
  print(grid.name, grid.valueTypeName, grid.activeVoxelCount(), *('%.9g' % v for v in values))
)";

TEST_F(BoneFile, CanBeReadCompletelyWithPyopenvdb) {
  if (std::system("/usr/bin/python3 -c 'import pyopenvdb' 2>/dev/null") != 0) {
    GTEST_SKIP() << "/usr/bin/python3 has no module pyopenvdb (Debian's package python3-openvdb)";
  }
  Bone bone = MakeTwoRegions();
  SetHu(
      bone, [](const Vec3& p) { return 100 * p.x; }, 0.5);
  bone.set_note("input", "two");
  WriteBone(bone, Path("a.vdb"));
  std::ofstream(Path("read.py")) << kReadWithPython;
  const openvdb::Coord places[] = {{5, -10, 15}, {24, -10, 15}, {-14, -8, 12}, {0, 0, 0}, {90, 90, 90}, {3, -7, 10}};
  std::string command = "/usr/bin/python3 " + Path("read.py") + " " + Path("a.vdb");
  for (const openvdb::Coord& c : places) command += fmt::format(" {},{},{}", c.x(), c.y(), c.z());
  ASSERT_EQ(std::system((command + " >" + Path("out.txt") + " 2>" + Path("err.txt")).c_str()), 0)
      << ReadTextFile(Path("err.txt"));
  const BoneGrids& grids = GridsOf(bone);
  std::string expected = "2 mm two\n";
  const auto add = [&](const auto& grid) {
    expected += fmt::format("{} float {}", grid.getName(), grid.activeVoxelCount());
    for (const openvdb::Coord& c : places) {
      expected += fmt::format(" {:.9g}", static_cast<double>(grid.tree().getValue(c)));
    }
    expected += "\n";
  };
  add(*grids.hu);
  add(*grids.phi);
  add(*grids.region);
  EXPECT_EQ(ReadTextFile(Path("out.txt")), expected);
  EXPECT_NE(expected.find(" 24"), std::string::npos);
  EXPECT_NE(expected.find(" 255"), std::string::npos);
}

TEST_F(BoneFile, RoundTripKeepsRegionsBitIdentical) {
  const Bone bone = MakeTwoRegions();
  WriteBone(bone, Path("a.vdb"));
  const Bone read = ReadBone(Path("a.vdb"));
  EXPECT_EQ(read.CalcHash(), bone.CalcHash());
  EXPECT_EQ(read.CalcRegionVolumes(), bone.CalcRegionVolumes());
  EXPECT_EQ(read.CalcMemoryBytes(), bone.CalcMemoryBytes());
}

TEST_F(BoneFile, AFileOfFormat1WithItsInt32RegionsIsRead) {
  const std::string old_file = std::string(KERF_SOURCE_DIR) + "/tests/fuzz/corpus/bonefile/block.vdb";
  ASSERT_NE(ReadTextFile(old_file).find("Tree_int32_5_4_3"), std::string::npos);
  const Bone bone = ReadBone(old_file);
  EXPECT_FALSE(bone.CalcRegionVolumes().empty());
  WriteBone(bone, Path("new.vdb"));
  EXPECT_EQ(ReadTextFile(Path("new.vdb")).find("Tree_int32_5_4_3"), std::string::npos);
  EXPECT_EQ(ReadBone(Path("new.vdb")).CalcHash(), bone.CalcHash());
}

TEST_F(BoneFile, NonIntegerRegionsAreRefused) {
  const Bone bone = test::MakeSphere({0, 0, 0}, 2, 0.4);
  for (const float bad : {24.5f, -1.0f, 256.0f, std::nanf("")}) {
    WriteBone(bone, Path("a.vdb"));
    openvdb::io::File file(Path("a.vdb"));
    file.open(false);
    const auto region = openvdb::gridPtrCast<openvdb::FloatGrid>(file.readGrid("region"));
    region->tree().setValueOn({1, 0, 0}, bad);
    openvdb::io::File out(Path("b.vdb"));
    out.write(openvdb::GridCPtrVec{file.readGrid("phi"), region}, *file.getMetadata());
    out.close();
    EXPECT_EQ(MessageOf(Path("b.vdb")),
              Path("b.vdb") + fmt::format(": grid \"region\" has the value {}, which is not a region number", bad));
  }
}

}  // namespace
}  // namespace kerf
