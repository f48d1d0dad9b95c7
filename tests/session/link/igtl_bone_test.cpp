// Bones that a peer sends, packed by the protocol's own library, and the bone that the import makes of them.
#include "session/link/igtl_bone.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <igtlImageMessage.h>
#include <igtlPolyDataMessage.h>

#include <array>
#include <cmath>
#include <cstring>
#include <glm/gtc/matrix_transform.hpp>
#include <glm/gtc/quaternion.hpp>
#include <limits>

#include "bone/import/import.h"
#include "bone/segmentation/mask_file.h"
#include "kerf/models.h"
#include "kerf/surface.h"
#include "session/link/bone_inbox.h"
#include "support/folder.h"
#include "support/message_of.h"

namespace kerf {
namespace {

using test::MessageOf;
using testing::HasSubstr;

/// A body without symmetry: two boxes of unequal size, mm.
bool IsInside(const Vec3& p) {
  const auto in = [&](const Vec3& lower, const Vec3& upper) {
    return glm::all(glm::greaterThan(p, lower)) && glm::all(glm::lessThan(p, upper));
  };
  return in({1.5, 2.5, 1.5}, {14.5, 6.5, 5.5}) || in({1.5, 2.5, 1.5}, {5.5, 11.5, 8.5});
}

constexpr double kVoxel_mm = 1;
constexpr std::array<int, 3> kSize{17, 15, 11};

/// A lattice of the body's voxels, whose axis i runs along axis order[i] of the world, backwards if flips[i].
struct Storage {
  std::array<int, 3> order{0, 1, 2};
  std::array<bool, 3> flips{false, false, false};
};

/// Packs the body as it is stored, at the pose X_WB, with the library. `frame`: of the message.
template <typename T = std::uint8_t>
std::string PackBody(const Storage& storage, const Pose& X_WB, int type = igtl::ImageMessage::TYPE_UINT8,
                     int endian = igtl::ImageMessage::ENDIAN_LITTLE, bool ras = true) {
  igtl::ImageMessage::Pointer image = igtl::ImageMessage::New();
  image->SetDeviceName("kerf_bone");
  std::array<int, 3> size{};
  for (std::size_t a = 0; a < 3; ++a) size[a] = kSize[static_cast<std::size_t>(storage.order[a])];
  image->SetDimensions(size.data());
  image->SetSpacing(kVoxel_mm, kVoxel_mm, kVoxel_mm);
  image->SetScalarType(type);
  image->SetEndian(endian);
  image->SetCoordinateSystem(ras ? igtl::ImageMessage::COORDINATE_RAS : igtl::ImageMessage::COORDINATE_LPS);
  image->AllocateScalars();
  const glm::dmat3 R = glm::mat3_cast(X_WB.R_AB);
  const Vec3 turn = ras ? Vec3(-1, -1, 1) : Vec3(1);
  igtl::Matrix4x4 matrix;
  igtl::IdentityMatrix(matrix);
  const Vec3 middle = turn * X_WB.Point(0.5 * kVoxel_mm * Vec3(kSize[0] - 1, kSize[1] - 1, kSize[2] - 1));
  for (int a = 0; a < 3; ++a) {
    const auto at = static_cast<std::size_t>(a);
    const Vec3 axis = turn * R[storage.order[at]] * (storage.flips[at] ? -1.0 : 1.0);
    for (int row = 0; row < 3; ++row) matrix[row][a] = static_cast<float>(axis[row]);
    matrix[a][3] = static_cast<float>(middle[a]);
  }
  image->SetMatrix(matrix);
  auto* voxels = static_cast<T*>(image->GetScalarPointer());
  std::array<int, 3> v{};
  for (v[2] = 0; v[2] < size[2]; ++v[2]) {
    for (v[1] = 0; v[1] < size[1]; ++v[1]) {
      for (v[0] = 0; v[0] < size[0]; ++v[0]) {
        Vec3 p(0);
        for (std::size_t a = 0; a < 3; ++a) {
          p[storage.order[a]] = kVoxel_mm * (storage.flips[a] ? size[a] - 1 - v[a] : v[a]);
        }
        *voxels++ = IsInside(p) ? T{1} : T{0};
      }
    }
  }
  image->Pack();
  return {static_cast<const char*>(image->GetPackPointer()), static_cast<std::size_t>(image->GetPackSize())};
}

std::span<const std::uint8_t> ContentOf(const std::string& message) {
  const auto* bytes = reinterpret_cast<const std::uint8_t*>(message.data());
  const IgtlHeader header =
      ReadIgtlHeader(std::span<const std::uint8_t, IgtlHeader::kBytes>(bytes, IgtlHeader::kBytes));
  return CheckIgtlBody(header, {bytes + IgtlHeader::kBytes, message.size() - IgtlHeader::kBytes});
}

class SentBones : public testing::Test {
 protected:
  /// Does what `kerf rehearse` does with a bone.
  Bone ImportSent(const SentBone& sent) {
    const std::string path = WriteSentBone(sent, folder_.file("kerf_bone"));
    ImportOptions options;
    options.voxel_mm = 0.2;
    options.mesh_units = IsSurfacePath(path) ? kSentUnits : "";
    if (IsSurfacePath(path)) return Import(path, options).bone;
    options.isolate.mask = ReadMaskFile(path, "", {}, false).mask;
    return Import("", options).bone;
  }
  Bone ImportMessage(const std::string& message) { return ImportSent(ReadIgtlLabelMap(ContentOf(message))); }

  const test::Folder folder_;
};

/// Largest difference between the distances to two bones near their surface, mm. `b` is `a` moved by X_WB.
double CompareBones(const Bone& a, const Bone& b, const Pose& X_WB) {
  double worst_mm = 0;
  const Box3 box = a.CalcBounds();
  constexpr double kStep_mm = 0.35;
  for (double x = box.lower.x; x <= box.upper.x; x += kStep_mm) {
    for (double y = box.lower.y; y <= box.upper.y; y += kStep_mm) {
      for (double z = box.lower.z; z <= box.upper.z; z += kStep_mm) {
        const double at_mm = a.SignedDistance({x, y, z});
        if (std::abs(at_mm) > 0.3) continue;
        worst_mm = std::max(worst_mm, std::abs(at_mm - b.SignedDistance(X_WB.Point({x, y, z}))));
      }
    }
  }
  return worst_mm;
}

TEST_F(SentBones, AreTheSameInAllDirections) {
  const Pose here{};
  const Bone expected = ImportMessage(PackBody({}, here));
  const Box3 box_W = expected.CalcBounds();
  EXPECT_LT(glm::length(box_W.lower - Vec3(1.5, 2.5, 1.5)), 0.1 * kVoxel_mm);
  EXPECT_LT(glm::length(box_W.upper - Vec3(14.5, 11.5, 8.5)), 0.1 * kVoxel_mm);
  const std::array<Storage, 4> storages{{{.order = {0, 1, 2}, .flips = {true, true, false}},
                                         {.order = {0, 1, 2}, .flips = {false, true, false}},
                                         {.order = {2, 0, 1}, .flips = {true, false, true}},
                                         {.order = {1, 0, 2}, .flips = {false, false, true}}}};
  for (const Storage& storage : storages) {
    EXPECT_LT(CompareBones(expected, ImportMessage(PackBody(storage, here)), here), 1e-3 * kVoxel_mm);
  }
  EXPECT_LT(CompareBones(expected,
                         ImportMessage(PackBody({}, here, igtl::ImageMessage::TYPE_UINT8,
                                                igtl::ImageMessage::ENDIAN_LITTLE, false)),
                         here),
            1e-3 * kVoxel_mm);
  // Oblique: the same body, moved and turned, with flipped axes, too.
  const Pose X_WB{glm::angleAxis(0.4, glm::normalize(Vec3(1, -2, 3))), {20, -30, 45}};
  EXPECT_LT(CompareBones(expected, ImportMessage(PackBody({}, X_WB)), X_WB), 0.1 * kVoxel_mm);
  EXPECT_LT(CompareBones(expected, ImportMessage(PackBody(storages[1], X_WB)), X_WB), 0.1 * kVoxel_mm);
}

TEST_F(SentBones, MayHaveAnyWholeNumbers) {
  const Volume expected = ReadIgtlLabelMap(ContentOf(PackBody({}, {})));
  const auto read = [](const std::string& message) { return ReadIgtlLabelMap(ContentOf(message)).hu; };
  EXPECT_EQ(read(PackBody<std::int16_t>({}, {}, igtl::ImageMessage::TYPE_INT16)), expected.hu);
  EXPECT_EQ(read(PackBody<std::uint32_t>({}, {}, igtl::ImageMessage::TYPE_UINT32)), expected.hu);
  // The library packs the voxels as they are in memory; in the other order, 1 becomes 256.
  EXPECT_EQ(read(PackBody<std::int16_t>({}, {}, igtl::ImageMessage::TYPE_INT16, igtl::ImageMessage::ENDIAN_BIG)),
            expected.hu);
}

TEST_F(SentBones, AreRefusedWithASentence) {
  const std::string good = PackBody({}, {});
  const std::span<const std::uint8_t> content = ContentOf(good);
  const std::vector<std::uint8_t> image(content.begin(), content.end());
  const auto refusal = [](const std::vector<std::uint8_t>& bytes) {
    return MessageOf([&] { ReadIgtlLabelMap(bytes); });
  };
  ASSERT_EQ(refusal(image), "");
  const auto with = [&](std::size_t at, std::vector<std::uint8_t> bytes) {
    std::vector<std::uint8_t> changed = image;
    std::copy(bytes.begin(), bytes.end(), changed.begin() + static_cast<std::ptrdiff_t>(at));
    return refusal(changed);
  };
  const std::vector<std::uint8_t> nan{0x7F, 0xC0, 0, 0};
  EXPECT_THAT(with(2, {3}), HasSubstr("3 values per voxel"));
  EXPECT_THAT(with(3, {10}), HasSubstr("values with decimals"));
  EXPECT_THAT(with(3, {9}), HasSubstr("unknown type 9"));
  EXPECT_THAT(with(4, {9}), HasSubstr("unknown byte order 9"));
  EXPECT_THAT(with(5, {7}), HasSubstr("neither in RAS nor in LPS"));
  EXPECT_THAT(with(6, {0xFF, 0xFF, 0xFF, 0xFF, 0, 1}), HasSubstr("65535 x 65535 x 1 voxels"));
  EXPECT_THAT(with(6, {0, 0}), HasSubstr("0 x 15 x 11 voxels"));
  EXPECT_THAT(with(6, {0, 18}), HasSubstr("a part of a larger one"));
  EXPECT_THAT(with(12, std::vector<std::uint8_t>(12)), HasSubstr("without size along axis 1"));
  EXPECT_THAT(with(16, nan), HasSubstr("not finite"));
  EXPECT_THAT(with(52, nan), HasSubstr("not finite"));
  std::vector<std::uint8_t> along_i(image.begin() + 12, image.begin() + 24);
  EXPECT_THAT(with(24, along_i), HasSubstr("do not span space"));
  EXPECT_THAT(with(12, {0x7F, 0, 0, 0}), HasSubstr("voxel spacing along axis 1"));
  EXPECT_THAT(with(72, {1, 2}), HasSubstr("several labels"));
  EXPECT_THAT(with(72, std::vector<std::uint8_t>(image.size() - 72)), HasSubstr("is empty"));
  EXPECT_THAT(refusal({image.begin(), image.end() - 1}), HasSubstr("2804 bytes of voxels instead of 2805"));
  EXPECT_THAT(refusal({image.begin(), image.begin() + 71}), HasSubstr("cut off"));
  EXPECT_THAT(refusal({}), HasSubstr("cut off"));
}

std::string PackSurface(const TriangleMesh& mesh_W, bool as_strips) {
  igtl::PolyDataMessage::Pointer message = igtl::PolyDataMessage::New();
  igtl::PolyDataPointArray::Pointer points = igtl::PolyDataPointArray::New();
  for (const Vec3& p : mesh_W.points) {
    points->AddPoint(static_cast<float>(-p.x), static_cast<float>(-p.y), static_cast<float>(p.z));
  }
  igtl::PolyDataCellArray::Pointer cells = igtl::PolyDataCellArray::New();
  for (const auto& t : mesh_W.triangles) {
    std::array<igtlUint32, 3> corners{t[0], t[1], t[2]};
    cells->AddCell(3, corners.data());
  }
  message->SetPoints(points);
  message->SetDeviceName("kerf_bone");
  as_strips ? message->SetTriangleStrips(cells) : message->SetPolygons(cells);
  message->Pack();
  return {static_cast<const char*>(message->GetPackPointer()), static_cast<std::size_t>(message->GetPackSize())};
}

TEST_F(SentBones, MayBeClosedSurfaces) {
  BlockParams block;
  block.size_mm = {20, 16, 12};
  block.voxel_mm = 0.4;
  const TriangleMesh surface = ExtractSurface(MakeBlock(block), 0);
  for (const bool as_strips : {false, true}) {
    const TriangleMesh sent = ReadIgtlSurface(ContentOf(PackSurface(surface, as_strips)));
    EXPECT_EQ(sent.triangles, surface.triangles);
    EXPECT_NEAR(ImportSent(sent).CalcVolume(), 20 * 16 * 12, 40);
  }
  // One of 4 mm is as small as it says.
  block.size_mm = {4, 3, 2};
  block.voxel_mm = 0.1;
  const TriangleMesh small = ReadIgtlSurface(ContentOf(PackSurface(ExtractSurface(MakeBlock(block), 0), false)));
  EXPECT_NEAR(ImportSent(small).CalcVolume(), 4 * 3 * 2, 1);
  // A strip of four points is two triangles that face the same way; a polygon of four is, too.
  const TriangleMesh quad{{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 1, 0}}, {}};
  std::string message = PackSurface(quad, true);
  const auto content = ContentOf(message);
  std::vector<std::uint8_t> bytes(content.begin(), content.end());
  const std::vector<std::uint8_t> strip{0, 0, 0, 4, 0, 0, 0, 0, 0, 0, 0, 1, 0, 0, 0, 2, 0, 0, 0, 3};
  bytes.insert(bytes.begin() + 40 + 48, strip.begin(), strip.end());
  bytes[35] = 20;
  EXPECT_EQ(ReadIgtlSurface(bytes).triangles, (std::vector<std::array<std::uint32_t, 3>>{{0, 1, 2}, {2, 1, 3}}));
}

TEST_F(SentBones, SurfacesAreRefusedWithASentence) {
  const TriangleMesh triangle{{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, {{0, 1, 2}}};
  const std::string message = PackSurface(triangle, false);
  const auto content = ContentOf(message);
  const std::vector<std::uint8_t> good(content.begin(), content.end());
  const auto refusal = [](const std::vector<std::uint8_t>& bytes) {
    return MessageOf([&] { ReadIgtlSurface(bytes); });
  };
  ASSERT_EQ(refusal(good), "");
  const auto with = [&](std::size_t at, std::uint8_t byte) {
    std::vector<std::uint8_t> changed = good;
    changed[at] = byte;
    return refusal(changed);
  };
  EXPECT_THAT(with(0, 0xFF), HasSubstr("cut off"));   // 4e9 points
  EXPECT_THAT(with(24, 0xFF), HasSubstr("cut off"));  // 4e9 bytes of polygons
  std::vector<std::uint8_t> points(good.begin(), good.begin() + 40 + 36);
  points[27] = 0;
  EXPECT_THAT(refusal(points), HasSubstr("no polygons"));
  EXPECT_THAT(with(36, 0x3B), HasSubstr("cut off"));  // 1e9 attributes
  std::vector<std::uint8_t> longer = good;
  longer.resize(good.size() + 36);
  EXPECT_THAT(refusal(longer), HasSubstr("36 bytes too many"));
  EXPECT_THAT(with(40 + 36, 0xFF), HasSubstr("cut off"));  // a polygon of 4e9 corners
  EXPECT_THAT(with(40 + 36 + 7, 9), HasSubstr("refers to point 9, but has 3 points"));
  std::vector<std::uint8_t> infinite = good;
  infinite[40] = 0x7F;
  infinite[41] = 0x80;
  EXPECT_THAT(refusal(infinite), HasSubstr("not finite"));
  EXPECT_THAT(refusal({good.begin(), good.begin() + 39}), HasSubstr("cut off"));
}

TEST_F(SentBones, AreTakenWhenTheSessionAccepts) {
  BoneInbox inbox;
  const std::string message = PackBody({}, {});
  const IgtlHeader header{.type = "IMAGE", .device = "kerf_bone"};
  EXPECT_TRUE(IsBoneMessage(header));
  EXPECT_FALSE(IsBoneMessage({.type = "IMAGE", .device = "ct"}));
  const auto take = [&] { return MessageOf([&] { inbox.Take(header, ContentOf(message)); }); };
  EXPECT_THAT(take(), HasSubstr("the bone of this session is fixed"));
  inbox.Open();
  EXPECT_EQ(take(), "");
  EXPECT_THAT(take(), HasSubstr("less than 2 s ago"));
  EXPECT_TRUE(inbox.Fetch().has_value());
  EXPECT_FALSE(inbox.Fetch().has_value());
}

}  // namespace
}  // namespace kerf
