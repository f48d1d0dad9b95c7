// What an import shows while it goes on, and how it is cancelled.
#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <numbers>
#include <utility>
#include <vector>

#include "base/core/cancelled.h"
#include "bone/import/import.h"
#include "bone/import/preview.h"
#include "ct_files.h"
#include "kerf/error.h"

namespace kerf {
namespace {

using test::Ball;
using test::Folder;

double BallVolume_mm3(double radius_mm) {
  return 4.0 / 3.0 * std::numbers::pi * std::pow(radius_mm, 3);
}

Volume BallCt(const std::array<int, 3>& size, const Vec3& spacing_mm, const Vec3& centre_W, double radius_mm) {
  return test::MakeCt(size, spacing_mm, {0, 0, 0}, glm::dmat3(1), Ball(centre_W, radius_mm), 1000);
}

TEST(Preview, IsTheBallInEachSampling) {
  const double radius_mm = 9;
  for (const Vec3& spacing_mm : {Vec3(0.3, 0.4, 0.5), Vec3(1, 1, 1), Vec3(0.4, 0.4, 2)}) {
    std::array<int, 3> size{};
    for (int a = 0; a < 3; ++a) size[a] = static_cast<int>(26 / spacing_mm[a]);
    const Bone bone = MakePreview(BallCt(size, spacing_mm, {13, 12, 12.5}, radius_mm), 500, 0.8);
    EXPECT_EQ(bone.voxel_mm(), 0.8);
    EXPECT_LT(glm::length(bone.CalcBounds().centre() - Vec3(13, 12, 12.5)), 0.5);
    // Smoothing shrinks a ball; half a voxel of its radius is allowed.
    EXPECT_NEAR(std::cbrt(bone.CalcVolume() / BallVolume_mm3(1)), radius_mm, 0.4);
  }
}

TEST(Preview, IsClosedWhereTheScanCutsTheBone) {
  // The lower half of the ball lies outside the scan, which begins half a voxel below the first centres.
  const Bone bone = MakePreview(BallCt({30, 30, 20}, {1, 1, 1}, {15, 15, 0}, 10), 500, 0.8);
  EXPECT_NEAR(bone.CalcVolume(), 0.5 * BallVolume_mm3(10), 0.15 * BallVolume_mm3(10));
  EXPECT_GT(bone.CalcBounds().lower.z, -1.5);
}

TEST(Preview, OfAirIsRefused) {
  const Volume air = test::MakeCt({20, 20, 20}, {1, 1, 1}, {0, 0, 0}, glm::dmat3(1), Ball({99, 99, 99}, 1));
  EXPECT_THROW(MakePreview(air, 500, 0.8), Error);
}

class ImportOfABall : public testing::Test {
 protected:
  ImportOfABall() {
    test::WriteNrrd(ct_, folder_.file("a.nrrd"));
    options_.voxel_mm = 0.4;
    options_.isolate.iso_hu = 500;
    options_.isolate.isolate = false;
    options_.keep_hu = true;
  }
  const Volume ct_ = BallCt({40, 40, 40}, {0.7, 0.7, 0.7}, {14, 14, 14}, 9);
  Folder folder_;
  ImportOptions options_;
};

TEST_F(ImportOfABall, ShowsTheCtThenACoarseBoneAndChangesNothing) {
  const ImportResult plain = Import(folder_.file("a.nrrd"), options_);
  std::vector<std::string> order;
  std::shared_ptr<const Volume> ct;
  Bone preview;
  options_.take_ct = [&](std::shared_ptr<const Volume> taken) {
    order.emplace_back("ct");
    ct = std::move(taken);
  };
  options_.take_preview = [&](Bone bone) {
    order.emplace_back("preview");
    preview = std::move(bone);
  };
  double last = 0;
  options_.progress = [&](double fraction) {
    EXPECT_GE(fraction, last - 1e-12) << "progress never goes back";
    EXPECT_LE(fraction, 1);
    last = fraction;
  };
  const ImportResult watched = Import(folder_.file("a.nrrd"), options_);
  EXPECT_EQ(order, (std::vector<std::string>{"ct", "preview"}));
  EXPECT_EQ(ct->hu, ct_.hu);
  EXPECT_EQ(ct->spacing_mm, ct_.spacing_mm);
  EXPECT_EQ(preview.voxel_mm(), 0.8);
  EXPECT_NEAR(preview.CalcVolume(), BallVolume_mm3(9), 0.1 * BallVolume_mm3(9));
  EXPECT_EQ(last, 1);
  EXPECT_EQ(watched.bone.CalcHash(), plain.bone.CalcHash());
}

TEST_F(ImportOfABall, EndsAtTheReportThatIsCancelled) {
  options_.take_preview = [](const Bone&) {};
  int total = 0;
  options_.progress = [&](double) { ++total; };
  Import(folder_.file("a.nrrd"), options_);
  EXPECT_GT(total, 100);
  // How many reports there are depends on the threads, but each fraction from 0 to 1 is passed.
  for (const double at : {0.0, 0.01, 0.05, 0.2, 0.4, 0.6, 0.8, 0.95, 1.0}) {
    int calls_after = 0;
    bool cancelled = false;
    options_.progress = [&](double fraction) {
      if (cancelled) ++calls_after;
      if (fraction < at) return;
      cancelled = true;
      throw Cancelled();
    };
    EXPECT_THROW(Import(folder_.file("a.nrrd"), options_), Cancelled) << at;
    EXPECT_TRUE(cancelled);
    EXPECT_EQ(calls_after, 0) << at;
  }
}

}  // namespace
}  // namespace kerf
