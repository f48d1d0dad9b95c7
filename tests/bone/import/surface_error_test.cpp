// The estimate of the surface's error, compared with the actual error on solids of known shape.
#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <glm/gtc/quaternion.hpp>

#include "bone/import/import.h"
#include "ct_files.h"
#include "kerf/surface.h"

namespace kerf {
namespace {

using test::Folder;

constexpr double kSoft_HU = 50;
constexpr double kCortex_HU = 1600;

double Normal(double x) {  // the cumulative normal distribution
  return 0.5 * std::erfc(-x / std::sqrt(2.0));
}

/// A solid in the scanner: the HU of its image, blurred by `sigma_mm`, and the distance to its outer surface.
struct Solid {
  const char* name;
  std::function<double(const Vec3&)> distance;
  double marrow_HU = kCortex_HU;  // HU of the marrow, which the cortex surrounds
  double cortex_mm = 0;

  double Hu(const Vec3& p, double sigma_mm) const {
    const double d = distance(p);
    return kSoft_HU + (kCortex_HU - kSoft_HU) * Normal(-d / sigma_mm) -
           (kCortex_HU - marrow_HU) * Normal(-(d + cortex_mm) / sigma_mm);
  }
};

const glm::dmat3 kTurn = glm::mat3_cast(glm::angleAxis(0.5, glm::normalize(Vec3(2, -1, 0.6))));

std::vector<Solid> Solids() {
  const auto ball = [](const Vec3& p) { return glm::length(p) - 11; };
  const auto plate = [](const Vec3& p) {
    const Vec3 q = glm::abs(kTurn * p) - Vec3(13, 12, 3.5);
    return std::max({q.x, q.y, q.z});
  };
  const auto tube = [](const Vec3& p) {
    const Vec3 q = kTurn * p;
    return std::max(std::hypot(q.x, q.y) - 8, std::abs(q.z) - 14);
  };
  return {{"ball", ball}, {"plate", plate}, {"tube", tube, 600, 2}};
}

/// Sampling of the scan: each sample is the mean of the blurred image over a box, or its value at a point.
struct Scan {
  Vec3 spacing_mm;
  double sigma_mm;
  bool box;
};

Volume MakeScan(const Solid& solid, const Scan& scan) {
  Volume ct;
  ct.spacing_mm = scan.spacing_mm;
  for (int a = 0; a < 3; ++a) ct.size[a] = static_cast<int>(44 / scan.spacing_mm[a]);
  ct.origin_W = -0.5 * Vec3(ct.size[0], ct.size[1], ct.size[2]) * scan.spacing_mm + Vec3(0.37, 0.61, 0.23);
  const int parts = scan.box ? 4 : 1;
  for (int k = 0; k < ct.size[2]; ++k) {
    for (int j = 0; j < ct.size[1]; ++j) {
      for (int i = 0; i < ct.size[0]; ++i) {
        double sum = 0;
        const double d = solid.distance(ct.WorldFromVoxel({i, j, k}));
        if (std::abs(d) > 8) {
          ct.hu.push_back(static_cast<std::int16_t>(std::lround(solid.Hu(ct.WorldFromVoxel({i, j, k}), 0.1))));
          continue;
        }
        for (int n = 0; n < parts * parts * parts; ++n) {
          const Vec3 part(n % parts, n / parts % parts, n / (parts * parts));
          sum += solid.Hu(ct.WorldFromVoxel(Vec3(i, j, k) + (part + 0.5) / static_cast<double>(parts) - 0.5),
                          scan.sigma_mm);
        }
        ct.hu.push_back(static_cast<std::int16_t>(std::lround(sum / (parts * parts * parts))));
      }
    }
  }
  return ct;
}

ImportResult ImportScan(const Volume& ct, double iso_hu = 300) {
  const Folder folder;
  test::WriteNrrd(ct, folder.file("ct.nrrd"));
  ImportOptions options;
  options.voxel_mm = 0.4;
  options.isolate.isolate = false;
  options.isolate.iso_hu = iso_hu;
  return Import(folder.file("ct.nrrd"), options);
}

struct Measured {
  double median_mm, rms_mm;
};

Measured Measure(const Bone& bone, const Solid& solid) {
  std::vector<double> d;
  double sum = 0;
  for (const Vec3& p : ExtractSurface(bone).points) {
    d.push_back(solid.distance(p));
    sum += d.back() * d.back();
  }
  std::nth_element(d.begin(), d.begin() + static_cast<std::ptrdiff_t>(d.size() / 2), d.end());
  return {d[d.size() / 2], std::sqrt(sum / static_cast<double>(d.size()))};
}

// Returns the distance by which the level `iso_hu` lies outside a flat edge, after a Gaussian blur and the scanner's
// box.
double FlatOffset(const Scan& scan, double iso_hu) {
  const double sigma = std::hypot(scan.sigma_mm, scan.box ? scan.spacing_mm.x / std::sqrt(12.0) : 0);
  const double fraction = (kCortex_HU - iso_hu) / (kCortex_HU - kSoft_HU);
  double z = 0;
  for (int n = 0; n < 50; ++n) z += (fraction - Normal(z)) * 2;  // quantile, by iteration
  return sigma * z;
}

TEST(SurfaceErrorEstimate, OffsetMatchesABlurredFlatEdge) {
  const Solid ball = Solids()[0];
  // The edges are resolved, with a blur of at least 0.6 spacings, so that interpolation adds no error.
  for (const Scan& scan : {Scan{Vec3(0.5), 0.3, false}, Scan{Vec3(1), 0.6, true}}) {
    for (const double iso_hu : {300.0, 825.0}) {
      const SurfaceError e = ImportScan(MakeScan(ball, scan), iso_hu).report.surface_error;
      // The curvature of the ball's surface shifts an edge by sigma^2 / R, here up to 0.04 mm.
      EXPECT_NEAR(e.offset_mm, FlatOffset(scan, iso_hu), 0.045) << scan.sigma_mm << " " << iso_hu;
      EXPECT_NEAR(e.half_height_hu, 0.5 * (kCortex_HU + kSoft_HU), 10);
      EXPECT_GT(e.points, 1000);
    }
  }
}

TEST(SurfaceErrorEstimate, MatchesTheErrorOnKnownSolids) {
  const Scan fine{Vec3(1), 0.3, true};
  const Scan gaps{{1, 1, 3}, 0.3, false};
  const Scan slabs{{1, 1, 3}, 0.6, true};
  const Scan wide{{2, 2, 1}, 0.6, false};
  const std::vector<Solid> solids = Solids();
  struct Case {
    const Solid& solid;
    Scan scan;
  };
  for (const auto& [solid, scan] : {Case{solids[0], fine}, Case{solids[0], gaps}, Case{solids[0], wide},
                                    Case{solids[1], gaps}, Case{solids[1], slabs}, Case{solids[2], slabs}}) {
    const ImportResult result = ImportScan(MakeScan(solid, scan));
    const SurfaceError& e = result.report.surface_error;
    const Measured m = Measure(result.bone, solid);
    const std::string which = fmt::format("{} {} {} {}", solid.name, scan.spacing_mm.x, scan.spacing_mm.z, scan.box);
    // Over 72 combinations of solid, spacing, blur and sampling, the ratio of the estimated to the actual error is 0.69
    // to 1.38 (docs/import.md). Of these six it is smallest for the tube, whose cortex of 2 mm appears fainter in
    // slices of 3 mm than it is.
    EXPECT_GT(e.CalcExpected(), (solid.cortex_mm > 0 ? 0.72 : 0.85) * m.rms_mm) << which;
    EXPECT_LT(e.CalcExpected(), 1.45 * m.rms_mm) << which;
    EXPECT_NEAR(e.offset_mm, m.median_mm, 0.2 * m.median_mm + 0.01) << which;
  }
}

TEST(SurfaceErrorEstimate, WidelySpacedSamplesScatterTheSurface) {
  // At half height, blur does not shift the surface, so all of the error is scatter.
  const Solid ball = Solids()[0];
  const Scan gaps{{1, 1, 3}, 0.3, false};
  const ImportResult result = ImportScan(MakeScan(ball, gaps), 825);
  const SurfaceError& e = result.report.surface_error;
  const Measured m = Measure(result.bone, ball);
  EXPECT_NEAR(e.offset_mm, 0, 0.05);
  EXPECT_GT(e.scatter_mm, 0.8 * m.rms_mm);
  EXPECT_LT(e.scatter_mm, 2 * m.rms_mm);
}

TEST(ThickSlices, GiveTheSurfaceOfThinSlices) {
  const Solid tube = Solids()[2];
  const ImportResult thin = ImportScan(MakeScan(tube, {Vec3(1), 0.5, false}));
  for (const Vec3& spacing : {Vec3(1, 1, 3), Vec3(1, 2.5, 1), Vec3(2, 2, 1)}) {
    const ImportResult thick = ImportScan(MakeScan(tube, {spacing, 0.5, false}));
    const std::string which = fmt::format("{} {} {}", spacing.x, spacing.y, spacing.z);
    EXPECT_NEAR(Measure(thick.bone, tube).median_mm, Measure(thin.bone, tube).median_mm, 0.1) << which;
    EXPECT_NEAR(thick.report.solid_mm3 / thin.report.solid_mm3, 1, 0.03) << which;
  }
}

TEST(ThickSlices, CorrectionVanishesForEquallySpacedScans) {
  // Limits and blur depend on the ratio of the spacings and vanish when the spacings are equal; a difference of 0.1 %
  // has no effect.
  const Solid tube = Solids()[2];
  Volume ct = MakeScan(tube, {Vec3(1), 0.5, false});
  const double before_mm3 = ImportScan(ct).report.solid_mm3;
  ct.spacing_mm.z *= 1.001;
  EXPECT_NEAR(ImportScan(ct).report.solid_mm3 / before_mm3, 1.001, 1e-4);
}

TEST(SurfaceErrorEstimate, IsStoredInTheProvenance) {
  const ImportResult result = ImportScan(MakeScan(Solids()[0], {Vec3(1), 0.5, false}));
  const SurfaceError& e = result.report.surface_error;
  EXPECT_EQ(result.bone.notes().at("import_surface_error_mm"),
            fmt::format("{:.2f} expected (rms): offset {:+.2f}, scatter {:.2f}; half height {:.0f} HU",
                        e.CalcExpected(), e.offset_mm, e.scatter_mm, e.half_height_hu));
}

}  // namespace
}  // namespace kerf
