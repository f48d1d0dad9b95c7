#include "app/window/export_order.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "support/folder.h"
#include "support/solids.h"

namespace kerf {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

constexpr double kVoxel_mm = 0.25;

/// Makes a bar of 12 x 4 x 4 mm with a gap of 1 mm beside its middle, or without it.
Bone MakeBar(bool cut) {
  SolidField field;
  field.value = [cut](const Vec3& p) {
    const double bar = test::BoxDistance(p, {6, 2, 2});
    return cut ? std::max(bar, 0.5 - std::abs(p.x - 2)) : bar;
  };
  field.classify = ClassifyByDistance(field.value);
  field.region = [](const Vec3&) { return 24; };
  const Box3 box{{-6, -2, -2}, {6, 2, 2}};
  return MakeBone(field, box.Grown(6 * kVoxel_mm), {kVoxel_mm, kVoxel_mm, {}}, test::OneRegionTable());
}

/// Exports a bar whose smaller piece was moved by 3 mm while it was cut, and returns the written files' texts.
struct Exported {
  explicit Exported(bool cut) {
    PieceSet arranged(MakeBar(true), 1);
    arranged.Move(1, {3, 0, 0});
    ExportOrder order;
    order.folder = folder.path();
    order.scene.tool.thickness_mm = 0.5;
    order.before = std::make_shared<const Bone>(MakeBar(false));
    std::promise<Bone> after;
    after.set_value(MakeBar(cut));
    order.after = after.get_future();
    order.pieces_json = arranged.FormatJson();
    order.measures = {{.name = "distance 1", .unit = "mm", .value = 20.4, .points_W_mm = {{0, 0, 0}, {20.4, 0, 0}}}};
    RunExport(order);
    measures = test::ReadBytes(folder.file("measures.csv"));
    transforms = nlohmann::json::parse(test::ReadBytes(folder.file("transforms.json")));
  }
  test::Folder folder;
  std::string measures;
  nlohmann::json transforms;
};

TEST(ExportOrder, WritesPiecesWhereTheyWereArranged) {
  const Exported exported(true);
  ASSERT_EQ(exported.transforms["pieces"].size(), 2u);
  EXPECT_EQ(exported.transforms["pieces"][0]["transform"][3], 0);
  EXPECT_EQ(exported.transforms["pieces"][1]["transform"][3], 3);
  EXPECT_THAT(exported.measures, HasSubstr("distance 1"));
}

TEST(ExportOrder, OmitsMeasurementsOfPiecesThatAreOneAgain) {
  const Exported exported(false);  // the cut was undone
  ASSERT_EQ(exported.transforms["pieces"].size(), 1u);
  EXPECT_EQ(exported.transforms["pieces"][0]["transform"][3], 0);
  EXPECT_THAT(exported.measures, Not(HasSubstr("distance 1")));
}

}  // namespace
}  // namespace kerf
