// Import of a bone from a CT, with or without a mask.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <glm/geometric.hpp>
#include <memory>

#include "base/core/number_text.h"
#include "base/files/memory.h"
#include "bone/grid/build.h"
#include "bone/grid/build_times.h"
#include "bone/import/blocks.h"
#include "bone/import/ct_solid.h"
#include "bone/import/dicom.h"
#include "bone/import/dicom_input.h"
#include "bone/import/dicom_segments.h"
#include "bone/import/hu_check.h"
#include "bone/import/hu_sampler.h"
#include "bone/import/image_file.h"
#include "bone/import/image_header.h"
#include "bone/import/import_steps.h"
#include "bone/import/leaf_positions.h"
#include "bone/import/mask_overlay.h"
#include "bone/import/padding.h"
#include "bone/import/patient_frame.h"
#include "bone/import/preview.h"
#include "kerf/error.h"

namespace kerf {
namespace {

namespace fs = std::filesystem;

constexpr double kPreviewVoxel_mm = 0.8;
constexpr double kSlices = 0.5;  // of the time in which a CT is read; then its values are checked

// Parts of the import of a CT, in their order.
enum class CtPart { kRead, kPreview, kIsolate, kFill, kSolid, kTissues, kLevelSet, kPieces, kHu, kMeasure, kCount };

// Where the parts of the import of a CT begin and end in the progress of the whole, 0 to 1, so that progress is even in
// time.
class CtShares {
 public:
  // `lattice`: of the CT; its values are not needed. `by_leaves`: as in EstimateBuildTimes(). It is known only when the
  // CT has been read, and does not change where that ends.
  CtShares(const ImportOptions& options, const Volume& lattice, bool by_leaves) : report_(options.progress) {
    const double read_s = 0.4 * CountMegavoxels(lattice) / kMeasured;  // with the check of its values
    const double read = read_s / (read_s + Sum(options, lattice, true));
    const double rest_s = Sum(options, lattice, by_leaves);
    for (double& end : ends_) end = read + (1 - read) * end / rest_s;
  }
  // Returns a function that reports the progress of a part.
  std::function<void(double)> Of(CtPart part) const {
    return Part(report_, part == CtPart::kRead ? 0 : ends_[static_cast<std::size_t>(part) - 1],
                ends_[static_cast<std::size_t>(part)]);
  }
  void End(CtPart part) const {
    if (report_) report_(ends_[static_cast<std::size_t>(part)]);
  }

 private:
  static constexpr double kMeasured = 14.6;  // million voxels

  static double CountMegavoxels(const Volume& lattice) { return 1e-6 * static_cast<double>(lattice.count()); }

  // Sets the ends of the parts, in seconds after the end of reading. Returns the last one. The seconds are processor
  // time on one core, measured with a head of 250 x 250 x 234 voxels of about 1 mm, as are the BuildTimes, and with a
  // jaw of 600 x 600 x 600 voxels of 0.2 mm.
  double Sum(const ImportOptions& options, const Volume& lattice, bool by_leaves) {
    const double voxels = CountMegavoxels(lattice) / kMeasured;
    const std::array<int, 3> step = ChooseBlocks(lattice);
    const double blocks = voxels / (step[0] * step[1] * step[2]);
    const double joined = step == std::array{1, 1, 1} ? 0 : voxels;  // passes over all voxels beside those over blocks
    const double volume = 1e-6 * static_cast<double>(lattice.count()) * lattice.CalcVoxelVolume() / kMeasured;
    const double region_voxel_mm = std::max(options.voxel_mm, kRegionVoxel_mm);
    const double finer = std::pow(0.2 / options.voxel_mm, 2.4);
    const std::array<double, kCount> seconds{0,
                                             options.take_preview ? 2.1 * volume + 0.03 * joined : 0.0,
                                             1.2 * blocks + 0.09 * joined,
                                             0.62 * blocks + 0.2 * joined,
                                             0.31,
                                             0.12 + 0.02 * joined,
                                             EstimateBuildTimes(options.voxel_mm, region_voxel_mm, by_leaves).total_s(),
                                             0.17 * finer,
                                             options.keep_hu ? 0.18 + 0.03 * joined : 0.0,
                                             0.52 * finer};
    double total = 0;
    for (std::size_t i = 0; i < kCount; ++i) ends_[i] = total += seconds[i];
    return total;
  }

  static constexpr auto kCount = static_cast<std::size_t>(CtPart::kCount);
  std::function<void(double)> report_;
  std::array<double, kCount> ends_{};
};

// Returns whether the values of the CT's solid are computed for whole leaves. Larger voxels on which a fine CT is
// isolated have positions if its own have.
bool IsByLeaves(const Volume& ct, const ImportOptions& options) {
  return LatticeMap(ct).HasPositions(options.voxel_mm);
}

DicomSeries ChooseCt(const DicomInput& input, const ImportOptions& options) {
  constexpr int kPicture = 96;  // pixels
  try {
    return TakeAsCt(input.Choose(options.series), options.as_ct);
  } catch (UnclearSeries& e) {
    if (options.take_ct) {
      for (const DicomSeries& series : e.series()) e.pictures.push_back(DrawMiddleSlice(series, kPicture));
    }
    throw;
  }
}

// Returns about the lattice that the series will have, without values.
Volume MakeLattice(const DicomSeries& series) {
  const DicomSlice& first = series.slices.front();
  Volume lattice;
  lattice.size = {first.size[0], first.size[1], static_cast<int>(series.slices.size())};
  lattice.spacing_mm = {first.pixel_mm[0], first.pixel_mm[1], series.gap_mm > 0 ? series.gap_mm : first.pixel_mm[0]};
  return lattice;
}

// Returns what the series does not state about the places of its slices.
std::optional<AssumedPlacing> FindAssumed(const DicomSeries& series) {
  AssumedPlacing placing;
  for (const DicomSlice& slice : series.slices) {
    placing.has_orientation = placing.has_orientation && slice.has_orientation;
    if (slice.spacing_from.empty()) continue;
    placing.spacing_mm = slice.pixel_mm[0];
    placing.spacing_from = slice.has_spacing ? slice.spacing_from : "";
    if (slice.has_spacing && slice.thickness_mm > 0 && std::abs(slice.thickness_mm - series.gap_mm) > 0.02) {
      placing.spacing_from += fmt::format("; SliceThickness (0018,0050): {:.4g} mm", slice.thickness_mm);
    }
  }
  return placing.has_orientation && !placing.spacing_mm ? std::nullopt : std::optional(placing);
}

// Reads a series. Adds what was left out and assumed to the warnings or, because it may be the reason, to the error.
Volume ReadDicom(const std::string& path, const ImportOptions& options, ImportReport& report) {
  const DicomInput input(path, Part(options.progress, 0, 0));
  const DicomSeries series = ChooseCt(input, options);
  report.kind = "DICOM";
  report.series_uid = series.name();
  report.study_date = series.study_date;
  report.placing = FindAssumed(series);
  double spacing_z_mm = options.spacing_z_mm;
  if (options.check_placing && spacing_z_mm == 0 && report.placing && report.placing->spacing_from.empty()) {
    spacing_z_mm = report.placing->spacing_mm.value_or(0);
  }
  Volume ct;
  try {
    const auto progress = CtShares(options, MakeLattice(series), true).Of(CtPart::kRead);
    ct = ReadDicomSeries(series, Part(progress, 0, kSlices), spacing_z_mm);
  } catch (const Error& e) {
    std::string message = input.NameFiles(e.what());
    for (const std::string& warning : series.warnings) message += "\nwarning: " + warning;
    throw Error(message);
  }
  for (SliceGap& gap : ct.gaps) gap.what = input.NameFiles(gap.what);
  ct.warnings.insert(ct.warnings.begin(), series.warnings.begin(), series.warnings.end());
  const std::string of_mask = options.isolate.mask ? options.isolate.mask->frame_uid : "";
  if (!of_mask.empty() && !series.frame_uid.empty() && of_mask != series.frame_uid) {
    ct.warnings.emplace_back(
        "the mask and the CT have different frames of reference, so the mask may lie in another place: check it with "
        "'kerf picture CT --mask FILE'");
  }
  if (report.placing) {
    if (report.placing->spacing_mm) report.placing->spacing_mm = ct.spacing_mm.z;
    for (int a = 0; a < 3; ++a) {
      if (std::abs(ct.axes_W[2][a]) > std::abs(ct.axes_W[2][report.placing->axis])) report.placing->axis = a;
    }
  }
  if (!options.frame.empty()) {
    DropFrameWarnings(ct.warnings);
    ReinterpretFrame(options.frame, ct);
  }
  return ct;
}

}  // namespace

Volume ReadCt(const std::string& path, const ImportOptions& options, ImportReport& report) {
  std::error_code failed;
  if (!fs::exists(path, failed)) throw Error(fmt::format("{}: no such file or folder", path));
  if (path.ends_with(".seg.nrrd") || (!fs::is_directory(path, failed) && IsDicomSegmentation(path))) {
    throw Error(fmt::format("{}: a segmentation, not a CT; import it with --mask", path));
  }
  if (DicomInput::Is(path)) return ReadDicom(path, options, report);
  if (!HasImageExtension(path)) {
    throw Error(fmt::format(
        "{}: unknown file type; kerf imports DICOM (a folder, a file, a .zip), {}, or a closed surface .stl "
        ".obj .ply",
        path, ListImageExtensions()));
  }
  if (options.spacing_z_mm != 0)
    throw Error(fmt::format("{}: --spacing-z applies to DICOM files only; leave it out", path));
  report.kind = "image";
  return ReadImageFile(path, options.frame);
}

namespace {

// Where the bone's surface is far above that of HU and nothing else tells the scale of the values, air is taken as 0.
void ScaleTissues(double iso, TissueOptions& tissue) {
  const TissueOptions in_hu;
  if (iso < in_hu.tooth_hu) return;
  const double scale = iso / (1000 + IsolateOptions{}.iso_hu);
  for (double TissueOptions::*threshold :
       {&TissueOptions::cortical_hu, &TissueOptions::tooth_hu, &TissueOptions::tooth_body_hu}) {
    if (tissue.*threshold == in_hu.*threshold) tissue.*threshold = scale * (1000 + in_hu.*threshold);
  }
}

// Reads the CT with its voxels along the patient's axes. Its values become HU, and with them the thresholds.
Volume ReadHu(const std::string& path, ImportOptions& options, ImportReport& report) {
  Volume ct = ReadCt(path, options, report);
  const auto progress = CtShares(options, ct, true).Of(CtPart::kRead);
  const auto done = [&progress](double fraction) {
    if (progress) progress(fraction);
  };
  done(kSlices);
  ct = StoreAlongPatient(std::move(ct));
  done(0.6);
  report.input_hash = CalcHash(ct);
  done(0.7);
  ClearPadding(ct);
  done(0.8);
  std::optional<NotHu> values;
  try {
    const BoneLevel level = TakeAsHu(ct, options.isolate.iso_hu, options.iso_auto, path);
    report.iso = level.iso;
    report.is_grey = level.is_grey;
    options.isolate.iso_hu = level.iso_hu;
    if (!level.warning.empty()) ct.warnings.push_back(level.warning);
    if (!level.is_grey) ScaleTissues(level.iso, options.tissue);
  } catch (const NotHu& e) {
    values = e;
  }
  const bool unplaced = options.check_placing && report.placing;
  if (unplaced || values) {  // who looks at the import sees what is asked about
    if (options.take_ct) options.take_ct(std::make_shared<const Volume>(std::move(ct)));
    if (unplaced)
      throw NotPlaced(fmt::format("{}: the places of its slices were assumed", path), *report.placing, values);
    throw NotHu(*values);
  }
  report.warnings = ct.warnings;
  if (options.isolate.mask) {
    const std::vector<std::string>& of_mask = options.isolate.mask->tissue.warnings;
    report.warnings.insert(report.warnings.end(), of_mask.begin(), of_mask.end());
    const std::string& segmented = options.isolate.mask->series_uid;
    const std::string own = report.series_uid.substr(0, report.series_uid.find('#'));
    if (!segmented.empty() && !own.empty() && segmented != own) {
      report.warnings.push_back(fmt::format("the mask refers to the series {}, not to this CT's, {}", segmented, own));
    }
  }
  report.size = ct.size;
  report.spacing_mm = ct.spacing_mm;
  return ct;
}

// Stores the CT's own numbers, not the smoothed and filled ones that the surface is made from.
void KeepHu(const Volume& ct, const ImportOptions& options, Bone& bone, ImportReport& report) {
  const Vec3& spacing = ct.spacing_mm;
  const double finest = std::min({spacing.x, spacing.y, spacing.z});
  report.hu_voxel_mm = options.hu_voxel_mm != 0 ? options.hu_voxel_mm
                                                : std::clamp(finest, std::max(options.voxel_mm, kHuVoxelRange_mm.lower),
                                                             kHuVoxelRange_mm.upper);
  const HuSampler sampler(ct);
  SetHu(
      bone, [&sampler](const Vec3& p_W) { return sampler.At(p_W); }, report.hu_voxel_mm);
  report.hu = CalcHuRange(bone);
  bone.set_note("import_hu_voxel_mm", fmt::format("{}", report.hu_voxel_mm));
}
// Calls Isolate(). Adds the assumptions made about the file to its error messages, because they may be the reason.
Isolation IsolateBone(const Volume& ct, const ImportOptions& options, const CtShares& shares,
                      const ImportReport& report) {
  const auto add_warnings = [&report](std::string message) {
    for (const std::string& warning : report.warnings) message += "\nwarning: " + warning;
    return message;
  };
  try {
    return Isolate(ct, options.isolate, shares.Of(CtPart::kIsolate));
  } catch (const NotIsolated& e) {
    throw NotIsolated(add_warnings(e.what()), e.why(), e.largest_W());
  } catch (const Error& e) {
    throw Error(add_warnings(e.what()));
  }
}

// Calls `use` with the index and the place along the normal of a gap, mm, of each voxel.
template <typename Use>
void ForEachPlace(const Volume& lattice, const SliceGap& gap, Use&& use) {
  const double first_mm = glm::dot(gap.normal_W, lattice.origin_W);
  const Vec3 step_mm = (gap.normal_W * lattice.axes_W) * lattice.spacing_mm;
  for (int k = 0; k < lattice.size[2]; ++k) {
    for (int j = 0; j < lattice.size[1]; ++j) {
      for (int i = 0; i < lattice.size[0]; ++i)
        use(std::array{i, j, k}, first_mm + i * step_mm.x + j * step_mm.y + k * step_mm.z);
    }
  }
}

// Ends the bone where slices are missing that were interpolated. Warns if it reached them.
void EndBoneAt(const SliceGap& gap, double iso_hu, Isolation& isolation, ImportReport& report) {
  constexpr double kSlack_mm = 1e-3;
  const auto is_missing = [&](double at_mm) {
    return at_mm > gap.from_mm + kSlack_mm && at_mm < gap.to_mm - kSlack_mm;
  };
  const Volume& fine = isolation.fine();
  std::size_t removed = 0;
  ForEachPlace(fine, gap, [&](const std::array<int, 3>& at, double at_mm) {
    const bool is_bone = fine.hu[fine.Index(at[0], at[1], at[2])] >= iso_hu;
    if (is_bone && is_missing(at_mm)) removed += isolation.keep[isolation.Find(at[0], at[1], at[2])];
  });
  if (removed == 0) return;
  isolation.iso_volume_mm3 -= static_cast<double>(removed) * fine.CalcVoxelVolume();
  ForEachPlace(isolation.ct, gap, [&](const std::array<int, 3>& at, double at_mm) {
    const std::size_t v = isolation.ct.Index(at[0], at[1], at[2]);
    if (is_missing(at_mm)) isolation.keep[v] = isolation.bone[v] = 0;
  });
  report.warnings.push_back(fmt::format(
      "the bone reaches the gap from {:.2f} to {:.2f} mm, where slices are missing, and was ended there; up "
      "to {:.2f} mm of it may be missing",
      gap.from_mm, gap.to_mm, gap.to_mm - gap.from_mm));
}

// Throws kerf::Error if the bone lies on both sides of a place from which slices are missing. If it lies on one, it
// ends there.
void CheckGaps(const Volume& ct, double iso_hu, Isolation& isolation, ImportReport& report) {
  const Volume& lattice = isolation.ct;
  for (const SliceGap& gap : ct.gaps) {
    // A lattice of larger voxels ends up to half of one before the scan.
    const double slack_mm = gap.from_mm < gap.to_mm
                                ? 1e-3
                                : 0.5 * std::max({lattice.spacing_mm.x, lattice.spacing_mm.y, lattice.spacing_mm.z});
    bool before = false, behind = false;
    ForEachPlace(lattice, gap, [&](const std::array<int, 3>& at, double at_mm) {
      if (isolation.bone[lattice.Index(at[0], at[1], at[2])] == 0) return;
      before = before || at_mm <= gap.from_mm + slack_mm;
      behind = behind || at_mm >= gap.to_mm - slack_mm;
    });
    if (before && behind) {
      throw Error(gap.what + "; what is missing belongs to the bone, so export the series again with all its slices");
    }
    EndBoneAt(gap, iso_hu, isolation, report);
  }
}

void WarnAboutSurfaceError(double iso_hu, ImportReport& report) {
  const SurfaceError& e = report.surface_error;
  if (e.points == 0 || e.CalcExpected() <= kSurfaceErrorWarning_mm) return;
  report.warnings.push_back(fmt::format(
      "the surface has an expected error of {:.2f} mm (rms), above {} mm: the {:.0f} HU level lies {:.2f} mm {} the "
      "half height of the bone's edge ({:.0f} HU), and the spacing of {:.4g} x {:.4g} x {:.4g} mm adds a scatter of "
      "{:.2f} mm; a sharper CT reduces the error, while another iso level may lose thin bone",
      e.CalcExpected(), kSurfaceErrorWarning_mm, iso_hu, std::abs(e.offset_mm), e.offset_mm < 0 ? "inside" : "outside",
      e.half_height_hu, report.spacing_mm.x, report.spacing_mm.y, report.spacing_mm.z, e.scatter_mm));
}

// Suggests a crop and the least useful voxel size for a large scan of fine voxels.
void SuggestLimits(const Isolation& isolation, ImportReport& report) {
  constexpr double kLarge_vox = 1e8;
  const Vec3& h = report.spacing_mm;
  const auto& [nx, ny, nz] = report.size;
  const double finest = std::min({h.x, h.y, h.z});
  const double least_mm = std::max(0.05, 0.05 * std::round(10 * finest));
  if (static_cast<double>(nx) * ny * nz < kLarge_vox) return;
  Box3 box_W;
  const Volume& ct = isolation.ct;
  for (std::size_t v = 0, k = 0; k < static_cast<std::size_t>(ct.size[2]); ++k) {
    for (int j = 0; j < ct.size[1]; ++j) {
      for (int i = 0; i < ct.size[0]; ++i, ++v) {
        if (isolation.bone[v] != 0) box_W.Include(ct.WorldFromVoxel({i, j, static_cast<double>(k)}));
      }
    }
  }
  const Box3 crop_W = box_W.Grown(5);
  report.warnings.push_back(fmt::format(
      "the scan has {} x {} x {} voxels of {:.3g} x {:.3g} x {:.3g} mm, {:.0f} MB: --voxel {:.3g} is the smallest that "
      "shows more of it, and a crop to x {:.0f} to {:.0f}, y {:.0f} to {:.0f}, z {:.0f} to {:.0f} mm would hold the "
      "bone",
      nx, ny, nz, h.x, h.y, h.z, 2e-6 * nx * ny * nz, least_mm, crop_W.lower.x, crop_W.upper.x, crop_W.lower.y,
      crop_W.upper.y, crop_W.lower.z, crop_W.upper.z));
}

double CalcVolume(const std::vector<std::uint8_t>& voxels, const Volume& lattice) {
  return static_cast<double>(std::count(voxels.begin(), voxels.end(), 1)) * lattice.CalcVoxelVolume();
}

// Fills, as cavities, lesions and what lies inside the mask by more than the reach, where the CT shows no bone.
void AddByMask(const Isolation& isolation, const std::vector<std::uint8_t>& solid,
               std::vector<std::uint8_t>& cavities) {
  const std::vector<float>& lesion = isolation.mask->samples.lesion;
  for (std::size_t v = 0; v < cavities.size(); ++v) {
    const bool is_lesion = !lesion.empty() && lesion[v] >= 0.5F;
    if (solid[v] == 0 && (isolation.mask->certain[v] != 0 || is_lesion)) cavities[v] = 1;
  }
}

void WarnAboutMask(const Isolation& isolation, ImportReport& report) {
  constexpr double kNotable = 0.005;  // fraction of the bone
  const MaskReport& mask = report.mask;
  if (isolation.mask->outside_scan > 0.001) {
    report.warnings.push_back(fmt::format("{:.1f} % of the wanted bone of the mask lies outside the scan",
                                          100 * isolation.mask->outside_scan));
  }
  if (mask.added_mm3 > kNotable * report.iso_mm3) {
    report.warnings.push_back(
        fmt::format("the mask overrides the CT: {} that lie more than {:.4g} mm inside the mask are bone, although the "
                    "CT shows none there",
                    FormatVolume(mask.added_mm3), mask.reach_mm));
  }
  constexpr double kLoss = 0.01, kFar_mm = 3;
  if (mask.given_away_mm3 > kLoss * mask.wanted_mm3 || mask.given_away_mm > kFar_mm) {
    report.warnings.push_back(fmt::format(
        "{} of bone that the mask names ({:.0f} % of {}) are not in the result, up to {:.1f} mm from it, because they "
        "are nearer to other bone in the CT, or small pieces apart; look at them with 'kerf picture CT --mask FILE'",
        FormatVolume(mask.given_away_mm3), 100 * mask.given_away_mm3 / mask.wanted_mm3, FormatVolume(mask.wanted_mm3),
        mask.given_away_mm));
  }
  if (mask.beyond_mm3 > kLoss * mask.wanted_mm3) {
    report.warnings.push_back(fmt::format(
        "{} of the bone are beyond the mask, within its reach of {:.4g} mm, where the CT decides; a smaller "
        "--mask-reach leaves less to the CT",
        FormatVolume(mask.beyond_mm3), mask.reach_mm));
  }
  if (mask.cut_off_mm3 > kNotable * report.iso_mm3) {
    const std::vector<std::uint8_t>& other = isolation.mask->samples.other;
    const bool has_other = std::find(other.begin(), other.end(), 1) != other.end();
    report.warnings.push_back(fmt::format(
        "the mask overrides the CT: {} of bone that are joined to the wanted bone, lie more than {:.4g} mm outside the "
        "mask and are in no other segment were cut off; {}",
        FormatVolume(mask.cut_off_mm3), mask.reach_mm,
        has_other
            ? "if they belong to the wanted bone, correct the mask"
            : "the mask has no segment of other bone, so that these include the skull if it touches; look at them "
              "with 'kerf picture CT --mask FILE'"));
  }
}

// Warns if the threshold of enamel lies among the values of cortical bone, so that much of the bone would be tooth. In
// grey values, whose scale is known only roughly, it is raised. Throws kerf::Error if a mandible would be teeth mostly.
void CheckTeeth(const Isolation& isolation, double solid_mm3, TissueOptions& tissue, ImportReport& report) {
  constexpr double kMuch = 0.08, kMost = 0.3, kNearlyAll = 0.6;  // of the bone
  if (isolation.mask && !isolation.mask->samples.tooth.empty()) return;
  const double given_mm3 = CalcToothVolume(isolation.ct, isolation.bone, tissue);
  if (given_mm3 < kMuch * solid_mm3) return;
  const double given_hu = tissue.tooth_hu;
  const bool is_default = given_hu == TissueOptions{}.tooth_hu;
  if (report.mandible && is_default && !report.is_grey && given_mm3 > kNearlyAll * solid_mm3) {
    throw Error(
        fmt::format("{} of the bone's {} are as bright as enamel, {:.0f} HU or more, or joined to it: the values look "
                    "like HU times a factor, such as 2; convert the scan again with its rescale slope, or state --iso "
                    "and --tooth-hu in its values",
                    FormatVolume(given_mm3), FormatVolume(solid_mm3), given_hu));
  }
  const double most_mm3 = report.mandible ? kMost * solid_mm3 : solid_mm3;
  const ToothLevel found = FindToothLevel(isolation.ct, isolation.bone, tissue, most_mm3);
  if (found.hu == given_hu) return;
  if (report.is_grey && is_default) {
    tissue.tooth_hu = found.hu;
    report.warnings.push_back(
        fmt::format("with {:.0f} HU or more for enamel, {} of the bone's {} would be teeth, most of it cortical bone: "
                    "the threshold was raised to {:.0f}, which leaves {}; --tooth-hu sets another one",
                    given_hu, FormatVolume(given_mm3), FormatVolume(solid_mm3), found.hu, FormatVolume(found.mm3)));
    return;
  }
  report.warnings.push_back(
      fmt::format("with {:.0f} HU or more for enamel, {} of the bone's {} are teeth, most of it probably cortical "
                  "bone; --tooth-hu {:.0f} would leave {}",
                  given_hu, FormatVolume(given_mm3), FormatVolume(solid_mm3), found.hu, FormatVolume(found.mm3)));
}

// Names a cavity that was closed because its mouth is narrower than a voxel of the bone.
void WarnAboutVoids(ImportReport& report) {
  constexpr double kNotable_mm3 = 100;
  // Voids between the CT's voxels are smaller than one of them.
  const double voxel_mm3 = report.spacing_mm.x * report.spacing_mm.y * report.spacing_mm.z;
  if (report.voids.mm3 - static_cast<double>(report.voids.count) * voxel_mm3 < kNotable_mm3) return;
  report.warnings.push_back(
      fmt::format("{} of {} {} closed, because no opening as wide as a voxel of the bone leads out; --no-fill keeps {}",
                  report.voids.count == 1 ? "a cavity" : fmt::format("{} cavities", report.voids.count),
                  FormatVolume(report.voids.mm3), report.voids.count == 1 ? "was" : "were",
                  report.voids.count == 1 ? "it" : "them"));
}

// Passes the CT and a coarse bone on to those who look at the import.
void Show(const std::shared_ptr<const Volume>& ct, const ImportOptions& options, const CtShares& shares) {
  if (options.take_ct) options.take_ct(ct);
  if (!options.take_preview) return;
  try {
    options.take_preview(MakePreview(*ct, options.isolate.iso_hu, std::max(options.voxel_mm, kPreviewVoxel_mm),
                                     shares.Of(CtPart::kPreview)));
  } catch (const Error&) {  // the import itself reports the reason
  }
}

}  // namespace

ImportResult ImportCt(const std::string& path, const ImportOptions& given) {
  ImportOptions options = given;
  ImportResult result;
  ImportReport& report = result.report;
  Stages stages(report);
  auto ct = std::make_shared<const Volume>(ReadHu(path, options, report));
  const bool by_leaves = IsByLeaves(*ct, options);
  const CtShares shares(options, *ct, by_leaves);
  stages.Done("read");
  Show(ct, options, shares);
  Isolation isolation = IsolateBone(*ct, options, shares, report);
  CheckGaps(*ct, options.isolate.iso_hu, isolation, report);
  ct.reset();
  report.isolation = isolation.how;
  report.iso_mm3 = isolation.iso_volume_mm3;
  report.contact_mm2 = isolation.contact_mm2;
  report.dropped_pieces = isolation.dropped_pieces;
  report.dropped_mm3 = isolation.dropped_mm3;
  report.cut_mm2 = isolation.cut_mm2;
  report.cut_by_scan = isolation.cut_mm2 > 0;
  report.mandible = isolation.mandible;
  options.tissue.up_W = isolation.up_W;
  report.shape_objection = isolation.shape_objection;
  stages.Done("isolate");
  SuggestLimits(isolation, report);

  std::vector<std::uint8_t> cavities(isolation.ct.count(), 0);
  if (options.fill) {
    cavities = FindCavities(isolation.ct, isolation.bone, options.cavities, shares.Of(CtPart::kFill));
  }
  std::vector<std::uint8_t> solid_voxels = isolation.bone;
  std::size_t filled = 0;
  for (std::size_t v = 0; v < cavities.size(); ++v) {
    filled += cavities[v];
    solid_voxels[v] |= cavities[v];
  }
  report.filled_mm3 = static_cast<double>(filled) * isolation.ct.CalcVoxelVolume();
  if (isolation.mask) {
    report.mask = {.used = true,
                   .reach_mm = isolation.mask->reach_mm,
                   .wanted_mm3 = isolation.mask->wanted_mm3,
                   .added_mm3 = 0,
                   .cut_off_mm3 = CalcVolume(isolation.mask->cut_off, isolation.ct),
                   .given_away_mm3 = CalcVolume(isolation.mask->given_away, isolation.ct),
                   .given_away_mm = isolation.mask->given_away_mm};
    if (options.fill) {
      report.mask.added_mm3 = CalcVolume(FindAdded(isolation, solid_voxels, options.isolate.iso_hu), isolation.ct);
      AddByMask(isolation, solid_voxels, cavities);
      for (std::size_t v = 0; v < cavities.size(); ++v) solid_voxels[v] |= cavities[v];
    }
    const MaskSamples& samples = isolation.mask->samples;
    std::vector<std::uint8_t> beyond = isolation.bone;
    for (std::size_t v = 0; v < beyond.size(); ++v) {
      if (samples.wanted[v] != 0 || samples.undecided[v] != 0) beyond[v] = 0;
    }
    report.mask.beyond_mm3 = CalcVolume(beyond, isolation.ct);
    WarnAboutMask(isolation, report);
  }
  report.input_mm3 = CalcVolume(solid_voxels, isolation.ct);
  // Filled marrow must stay below the cortex's threshold, because the same field distinguishes the tissues.
  const double iso = options.isolate.iso_hu;
  const CtSolid solid(isolation, cavities, iso, iso + std::max(0.5 * (options.tissue.cortical_hu - iso), 1.0));
  stages.Done("fill");
  report.surface_error = CalcSurfaceError(solid, isolation, cavities);
  WarnAboutSurfaceError(options.isolate.iso_hu, report);
  stages.Done("surface error");
  shares.End(CtPart::kSolid);

  CheckTeeth(isolation, report.input_mm3, options.tissue, report);
  const TissueMap tissue(isolation.ct, solid_voxels, isolation.bone, &solid.hu(), report.mandible, options.tissue,
                         isolation.mask ? &isolation.mask->samples : nullptr, &solid.map());
  report.tooth_mm3 = tissue.tooth_mm3();
  if (report.mandible && report.tooth_mm3 == 0) {
    report.warnings.push_back(fmt::format(
        "no teeth were found: no part of the bone is as bright as enamel, {:.0f} HU or more; teeth that the CT "
        "shows are treated as bone",
        options.tissue.tooth_hu));
  }
  stages.Done("tissues");
  shares.End(CtPart::kTissues);

  SolidField field;
  field.value = [&solid](const Vec3& p_W) { return solid.Value(p_W); };
  if (by_leaves)
    field.leaf_values = [&solid](const LeafPlace& leaf, LeafValues& values) { solid.EvaluateLeaf(leaf, values); };
  field.classify = [&solid](const Vec3& p_W, double radius_mm) { return solid.Classify(p_W, radius_mm); };
  field.leaf_regions = [&tissue](const LeafPlace& leaf, const WantedVoxels& wanted, LeafRegions& ids) {
    tissue.FindRegions(leaf, wanted, ids);
  };
  field.is_distance = false;
  BuildOptions build;
  build.max_bytes = static_cast<double>(ReadAvailableBytes());
  build.voxel_mm = options.voxel_mm;
  build.region_voxel_mm = std::max(options.voxel_mm, kRegionVoxel_mm);
  build.progress = shares.Of(CtPart::kLevelSet);
  if (options.fill) build.fill_voids = &report.voids;
  result.bone = MakeBone(field, solid.box().Grown(6 * options.voxel_mm), build, ChooseTable(options, report.mandible));
  WarnAboutVoids(report);
  stages.Done("level set");
  DropDust(result.bone, isolation.pieces == 1, report);
  stages.Done("pieces");
  shares.End(CtPart::kPieces);
  if (options.keep_hu) {
    KeepHu(isolation.fine(), options, result.bone, report);
    stages.Done("CT numbers");
  }
  shares.End(CtPart::kHu);
  Finish(options, result.bone, report);
  stages.Done("measure");
  return result;
}

}  // namespace kerf
