// Tests of reading a project's CT again.
#include "app/window/ct_reader.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <thread>

#include "bone/import/ct_files.h"
#include "bone/import/dicom_bytes.h"
#include "bone/import/import.h"
#include "support/jaw_ct.h"
#include "support/message_of.h"

namespace kerf {
namespace {

using testing::HasSubstr;

/// A CT of a ball in soft tissue, with its bone.
struct Case {
  Case() {
    ct = test::MakeCt({24, 24, 24}, Vec3{1}, Vec3{-12, 5, 0}, glm::dmat3(1), test::Ball({0, 17, 12}, 8));
    ct.hu[0] = 71;  // far from the bone
    test::WriteNrrd(ct, file);
    ImportOptions options;
    options.voxel_mm = 1;
    options.isolate.isolate = false;
    bone = std::make_shared<const Bone>(Import(file, options).bone);
  }
  test::Folder folder;
  std::string file = folder.file("head.nrrd");
  Volume ct;
  std::shared_ptr<const Bone> bone;
};

CtReader::Result Read(const Case& of) {
  CtReader reader;
  reader.Begin(of.bone, of.file);
  std::optional<CtReader::Result> result;
  while (!(result = reader.Take())) std::this_thread::yield();
  return *result;
}

TEST(CtReader, ReadsTheWholeCtOfABone) {
  const Case of;
  const CtReader::Result read = Read(of);
  EXPECT_EQ(read.why_not, "");
  ASSERT_TRUE(read.ct);
  EXPECT_EQ(read.ct->hu, of.ct.hu);
  EXPECT_EQ(read.ct->origin_W, of.ct.origin_W);
}

TEST(CtReader, ReadsWhatTheUserHasStatedAboutTheCt) {
  // Grey values in one file of the modality OT, whose frames have no places.
  const Volume jaw = test::JawCt(3);
  test::SliceSpec spec;
  spec.modality = "OT";
  spec.intercept = 0;
  for (const std::int16_t hu : jaw.hu) {
    const auto grey = static_cast<unsigned>(std::lround(300 + 0.6 * (hu + 1000)));
    spec.pixels += {static_cast<char>(grey & 0xff), static_cast<char>(grey >> 8)};
  }
  test::DicomBytes file(test::DicomSlice(jaw, 0, spec));
  file.Set(0x28, 8, "IS", std::to_string(jaw.size[2])).Remove(0x18, 0x50).Remove(0x20, 0x37);
  const test::Folder folder;
  Case of;
  of.file = folder.file("jaw.dcm");
  test::WriteBytes(of.file, file.File());
  ImportOptions options;
  options.voxel_mm = 1.5;
  options.as_ct = true;
  options.spacing_z_mm = 3;
  options.frame = "RPS";
  options.isolate.iso_hu = 1080;
  options.isolate.isolate = false;
  std::shared_ptr<const Volume> ct;
  options.take_ct = [&](std::shared_ptr<const Volume> taken) { ct = std::move(taken); };
  of.bone = std::make_shared<const Bone>(Import(of.file, options).bone);
  const CtReader::Result read = Read(of);
  EXPECT_EQ(read.why_not, "");
  ASSERT_TRUE(read.ct);
  EXPECT_EQ(read.ct->hu, ct->hu);
  EXPECT_EQ(read.ct->origin_W, ct->origin_W);
}

TEST(CtReader, SaysWhyThereIsNoCt) {
  Case of;
  of.ct.hu[0] = 72;
  test::WriteNrrd(of.ct, of.file);
  EXPECT_EQ(Read(of).ct, nullptr);
  EXPECT_THAT(Read(of).why_not, HasSubstr("head.nrrd has changed since the bone was made"));
  test::WriteBytes(of.file, "NRRD0004\n");
  EXPECT_THAT(Read(of).why_not, HasSubstr("head.nrrd could not be read again"));
  std::filesystem::remove(of.file);
  EXPECT_THAT(Read(of).why_not, HasSubstr("The CT is no longer at "));
}

TEST(CtReader, CanBeCancelled) {
  const Case of;
  CtReader reader;
  reader.Begin(of.bone, of.file);
  reader.Cancel();
  EXPECT_FALSE(reader.Take());
  EXPECT_TRUE(reader.WaitUntil(std::chrono::steady_clock::time_point::max()));
}

}  // namespace
}  // namespace kerf
