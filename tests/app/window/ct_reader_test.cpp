// Tests of reading a project's CT again.
#include "app/window/ct_reader.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <thread>

#include "bone/import/ct_files.h"
#include "bone/import/import.h"
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
