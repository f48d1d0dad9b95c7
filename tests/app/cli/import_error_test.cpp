// Tests what `kerf import` reports about the expected error of the surface.
#include <fmt/format.h>
#include <gmock/gmock.h>

#include <cmath>
#include <cstdint>
#include <nlohmann/json.hpp>

#include "support/program.h"

namespace kerf {
namespace {

using test::ProgramResult;
using testing::HasSubstr;
using testing::Not;

class ImportError : public test::ProgramTest {
 protected:
  // Writes a ball of 1600 HU with a radius of 11 mm in soft tissue of 50 HU, blurred by 0.5 mm, in slices of
  // `slice_mm`.
  void WriteBall(const std::string& name, double slice_mm) const {
    constexpr int kSide = 32;
    const int slices = static_cast<int>(kSide / slice_mm);
    std::string voxels;
    for (int k = 0; k < slices; ++k) {
      for (int j = 0; j < kSide; ++j) {
        for (int i = 0; i < kSide; ++i) {
          const double r = std::hypot(i - 15.6, j - 15.2, slice_mm * k - 15.9);
          const auto hu = static_cast<std::int16_t>(50 + 1550 * 0.5 * std::erfc((r - 11) / (0.5 * std::sqrt(2.0))));
          voxels.append(reinterpret_cast<const char*>(&hu), sizeof hu);
        }
      }
    }
    Write(name, fmt::format("NRRD0004\ntype: short\ndimension: 3\nspace: left-posterior-superior\nsizes: {0} {0} {1}\n"
                            "space directions: (1,0,0) (0,1,0) (0,0,{2})\nendian: little\nencoding: raw\n"
                            "space origin: (0,0,0)\n\n",
                            kSide, slices, slice_mm) +
                    voxels);
  }
};

TEST_F(ImportError, IsInSummaryJsonAndProvenanceAndWarnsAbove300Micrometres) {
  WriteBall("thick.nrrd", 3);
  const ProgramResult thick = Kerf("import thick.nrrd --no-isolate --voxel 0.6 --json -o thick.vdb");
  ASSERT_EQ(thick.code, 0) << thick.err;
  const auto error = nlohmann::json::parse(thick.out)["surface_error"];
  // 300 HU is 0.99 standard deviations outside the middle of the edge; the slices blur it slightly more.
  EXPECT_NEAR(error["offset_mm"], 0.55, 0.1);
  EXPECT_NEAR(error["half_height_HU"], 825, 25);
  EXPECT_GT(error["scatter_mm"], 0.1);
  EXPECT_NEAR(error["expected_mm"], std::hypot(double{error["offset_mm"]}, double{error["scatter_mm"]}), 1e-9);
  EXPECT_THAT(thick.err,
              HasSubstr(fmt::format("kerf: the surface has an expected error of {:.2f} mm (rms), above 0.3 "
                                    "mm: the 300 HU level lies {:.2f} mm outside the half height of the bone's edge",
                                    double{error["expected_mm"]}, double{error["offset_mm"]})));
  EXPECT_THAT(thick.err, HasSubstr("the spacing of 1 x 1 x 3 mm adds a scatter of"));
  EXPECT_THAT(Kerf("info thick.vdb").out, HasSubstr("import_surface_error_mm"));

  // With a threshold at half height and with fine sampling, there is no warning.
  WriteBall("fine.nrrd", 1);
  const ProgramResult fine = Kerf("import fine.nrrd --no-isolate --voxel 0.6 --iso 825 -o fine.vdb");
  ASSERT_EQ(fine.code, 0) << fine.err;
  EXPECT_THAT(fine.out, HasSubstr("surface    expected error 0.0"));
  EXPECT_THAT(fine.err, Not(HasSubstr("expected error")));
}

}  // namespace
}  // namespace kerf
