// Values that are not Hounsfield units, and data that the header does not describe.
#include <gmock/gmock.h>

#include <cstdlib>
#include <filesystem>
#include <set>

#include "bone/import/hu_check.h"
#include "bone/import/image_file.h"
#include "bone/import/import.h"
#include "ct_files.h"
#include "test_paths.h"

namespace kerf {
namespace {

using test::Folder;
using test::MessageOf;
using test::WriteBytes;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

constexpr double kIso = 300;

// Makes concentric balls of soft tissue, bone and enamel in air, with a few values each.
Volume Head() {
  Volume ct = test::MakeCt({40, 40, 40}, {2, 2, 2}, {-39, -39, -39}, glm::dmat3(1), test::Ball(Vec3(0), 30));
  for (int k = 0; k < 40; ++k) {
    for (int j = 0; j < 40; ++j) {
      for (int i = 0; i < 40; ++i) {
        const double r = glm::length(ct.WorldFromVoxel({i, j, k}));
        const int noise = (i * 7 + j * 11 + k * 13) % 41 - 20;
        ct.hu[ct.Index(i, j, k)] = static_cast<std::int16_t>((r > 30   ? -1000
                                                              : r > 18 ? 40
                                                              : r > 16 ? 1400
                                                                       : 300) +
                                                             noise);
      }
    }
  }
  return ct;
}

Volume Shifted(Volume ct, int by) {
  for (std::int16_t& hu : ct.hu) hu = static_cast<std::int16_t>(hu + by);
  return ct;
}

TEST(HuCheck, LabelMapIsRecognised) {
  for (const int labels : {2, 3, 12, 100, 118}) {
    Volume map = Head();
    for (std::size_t v = 0; v < map.hu.size(); ++v) {  // in blocks of 4 x 4 x 4 voxels
      const std::size_t block = v % 40 / 4 + 10 * (v / 40 % 40 / 4) + 100 * (v / 1600 / 4);
      map.hu[v] = static_cast<std::int16_t>(map.hu[v] < -500 ? 0 : block % static_cast<std::size_t>(labels));
    }
    const std::set<std::int16_t> found(map.hu.begin(), map.hu.end());  // the corners have air
    EXPECT_THAT(
        MessageOf([&] { CheckHu(map, kIso, "a.nrrd"); }),
        HasSubstr(fmt::format("a.nrrd: this is a label map, not a CT: its voxels have {} different values from 0 to {}",
                              found.size(), *found.rbegin())));
    EXPECT_THAT(CheckHu(map, 0.5, "a.nrrd"), HasSubstr("this is a label map"));  // only a warning: the user set 0.5
  }
}

TEST(HuCheck, HuAreNotTakenForLabels) {
  EXPECT_EQ(CheckHu(Head(), kIso, ""), "");
  // In scans of phantoms, the body has one value and the air another.
  EXPECT_EQ(CheckHu(test::MakeCt({9, 9, 9}, Vec3(1), Vec3(0), glm::dmat3(1), test::Ball(Vec3(4), 3)), kIso, ""), "");
}

TEST(HuCheck, CtWithoutItsOffsetIsRecognised) {
  const Volume raw = Shifted(Head(), 1024);
  EXPECT_THAT(MessageOf([&] { CheckHu(raw, kIso, "a.nrrd"); }),
              HasSubstr("a.nrrd: this is a CT without its offset: air lies near 0 and soft tissue near 1024"));
  EXPECT_THAT(CheckHu(raw, 1324, "a.nrrd"), HasSubstr("a CT without its offset"));  // only a warning: the user set 1324
  // Scanners fill the area outside their field of view with a special value.
  Volume padded = raw;
  for (std::size_t v = 0; v < padded.hu.size(); v += 9) padded.hu[v] = -2000;
  EXPECT_THAT(MessageOf([&] { CheckHu(padded, kIso, ""); }), HasSubstr("without its offset"));
  // A crop with only bone and soft tissue has no air as a reference, and is accepted.
  Volume crop = Head();
  std::erase_if(crop.hu, [](std::int16_t hu) { return hu < -500; });
  EXPECT_EQ(CheckHu(crop, kIso, ""), "");
}

TEST(HuCheck, ImportShowsTheCtForWhichAThresholdIsWanted) {
  const Folder folder;
  test::WriteNrrd(Shifted(Head(), 1024), folder.file("a.nrrd"));
  ImportOptions options;
  std::shared_ptr<const Volume> shown;
  options.take_ct = [&shown](std::shared_ptr<const Volume> ct) { shown = std::move(ct); };
  try {
    Import(folder.file("a.nrrd"), options);
    FAIL() << "no error";
  } catch (const NotHu& e) {
    // Air lies at 24, soft tissue at 1064 and bone at 1324 and more, by up to 20 each.
    EXPECT_GT(e.proposed_iso(), 1084);
    EXPECT_LE(e.proposed_iso(), 1324);
    EXPECT_THAT(e.why(), testing::StartsWith("this is a CT without its offset"));
    EXPECT_THAT(CheckHu(*shown, e.proposed_iso(), "a.nrrd"), testing::StartsWith(e.why()));
  }
  ASSERT_NE(shown, nullptr);
  EXPECT_EQ(shown->hu.size(), 64000u);
}

TEST(RealData, HuCheckAcceptsARealScanOnlyWithItsOffset) {
  const std::string head = std::string(KERF_TEST_DATA) + "/visible_human_female/vhf_head_hu_int16_250x250x234.nrrd";
  if (!std::filesystem::exists(head)) GTEST_SKIP() << "not found: " << head;
  const Volume ct = ReadImageFile(head);
  EXPECT_EQ(CheckHu(ct, kIso, ""), "");
  EXPECT_THAT(MessageOf([&] { CheckHu(Shifted(ct, 1024), kIso, ""); }), HasSubstr("without its offset"));
  Volume labels = ct;
  for (std::int16_t& hu : labels.hu) hu = hu > 300 ? 1 : 0;
  EXPECT_THAT(MessageOf([&] { CheckHu(labels, kIso, ""); }), HasSubstr("this is a label map"));
}

TEST(HuCheck, ImportRefusesALabelMap) {
  Volume map = Head();
  for (std::int16_t& hu : map.hu) hu = hu > 1000 ? 2 : hu > 0 ? 1 : 0;
  const Folder folder;
  test::WriteNrrd(map, folder.file("a.nrrd"));
  EXPECT_THAT(MessageOf([&] { Import(folder.file("a.nrrd"), ImportOptions{}); }),
              HasSubstr("this is a label map, not a CT: its voxels have 3 different values from 0 to 2"));
}

TEST(Values, ValueOutOfRangeIsClampedWithAWarning) {
  const Folder folder;
  const Volume ct = Head();
  std::vector<float> values(ct.hu.begin(), ct.hu.end());
  values.at(100) = 1e30f;
  WriteBytes(folder.file("a.nrrd"), test::NrrdHeader(ct, "float") + "\n" +
                                        std::string(reinterpret_cast<const char*>(values.data()), 4 * values.size()));
  const Volume read = ReadImageFile(folder.file("a.nrrd"));
  EXPECT_EQ(read.hu[100], 32767);
  ASSERT_THAT(read.warnings, ElementsAre(HasSubstr("1 of 64000 voxels lie outside the range of HU")));
  EXPECT_THAT(read.warnings[0], HasSubstr("the most extreme has 1e+30"));
}

TEST(Values, MoreSlicesThanTheHeaderStatesCauseAWarning) {
  const Folder folder;
  Volume ct = Head();
  const std::string two_more(2 * sizeof(std::int16_t) * 40 * 40, '\1');
  test::WriteNrrd(ct, folder.file("a.nrrd"));
  test::WriteNifti(ct, folder.file("a.nii"));
  test::WriteMeta(ct, folder.file("a.mha"));
  for (const char* name : {"a.nrrd", "a.nii", "a.mha"}) {
    EXPECT_THAT(ReadImageFile(folder.file(name)).warnings, IsEmpty());
    const std::string whole = test::ReadBytes(folder.file(name));
    WriteBytes(folder.file(name), whole + "\n");  // less than a slice
    EXPECT_THAT(ReadImageFile(folder.file(name)).warnings, IsEmpty());
    WriteBytes(folder.file(name), whole + two_more);
    const Volume read = ReadImageFile(folder.file(name));
    EXPECT_EQ(read.hu, ct.hu);
    EXPECT_THAT(read.warnings,
                ElementsAre("the header gives 40 x 40 x 40 voxels, but the file contains 2 slices more; they were "
                            "left out"))
        << name;
  }
  ASSERT_EQ(std::system(("gzip '" + folder.file("a.nii") + "'").c_str()), 0);
  EXPECT_THAT(ReadImageFile(folder.file("a.nii.gz")).warnings, ElementsAre(HasSubstr("at least 2 slices more")));
}

TEST(Values, GzipOfSeveralMembersIsReadWhole) {
  const Folder folder;
  const Volume ct = Head();
  test::WriteNifti(ct, folder.file("a.nii"));
  const std::string whole = test::ReadBytes(folder.file("a.nii"));
  WriteBytes(folder.file("1"), whole.substr(0, whole.size() / 3));
  WriteBytes(folder.file("2"), whole.substr(whole.size() / 3));
  const std::string pack = "cd '" + folder.file("") + "' && gzip 1 2 && cat 1.gz 2.gz > b.nii.gz";
  ASSERT_EQ(std::system(pack.c_str()), 0);
  EXPECT_EQ(ReadImageFile(folder.file("b.nii.gz")).hu, ct.hu);
}

}  // namespace
}  // namespace kerf
