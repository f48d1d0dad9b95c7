#include "bone/import/nifti.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <glm/geometric.hpp>
#include <initializer_list>
#include <utility>

#include "bone/import/image_fields.h"
#include "bone/import/image_header.h"
#include "bone/import/patient_frame.h"
#include "bone/import/unpack.h"
#include "bone/import/voxel_values.h"
#include "kerf/error.h"

namespace kerf {

namespace {

constexpr std::size_t kHeaderBytes = 348;
constexpr std::size_t kHeader2Bytes = 540;
constexpr double kFirstVoxel = 352, kFirstVoxel2 = 544;  // least offset of the voxels in the file of the header
constexpr double kFormsAgree_mm = 0.1;                   // sform and qform have single precision
constexpr double kSpacingsAgree = 1e-3;                  // relative, between the sform's steps and pixdim
constexpr double kMaxUnpacked = 1 << 26;  // bytes unpacked of a stream that is not NIfTI, to check that it is complete

// Transform from voxel indices to the header's coordinates.
struct Form {
  glm::dmat3 steps{1};  // columns
  Vec3 origin{0};
};

template <typename T>
T Field(const std::string& bytes, std::size_t offset, bool swapped) {
  std::array<char, sizeof(T)> field{};
  std::memcpy(field.data(), bytes.data() + offset, sizeof(T));
  if (swapped) std::reverse(field.begin(), field.end());
  return std::bit_cast<T>(field);
}

// Reads numbers from the bytes of a header.
struct HeaderBytes {
  std::string bytes;
  bool swapped = false;
  int Short(std::size_t at) const { return Field<std::int16_t>(bytes, at, swapped); }
  int Int(std::size_t at) const { return Field<std::int32_t>(bytes, at, swapped); }
  double Long(std::size_t at) const { return static_cast<double>(Field<std::int64_t>(bytes, at, swapped)); }
  double Float(std::size_t at) const { return static_cast<double>(Field<float>(bytes, at, swapped)); }
  double Double(std::size_t at) const { return Field<double>(bytes, at, swapped); }
};

[[noreturn]] void RefuseHeader(const std::string& path) {
  if (IsGzip(path)) {
    const Unpacked whole = Unpack(path, 0, kMaxUnpacked);
    if (whole.damaged || whole.bytes < static_cast<double>(kHeaderBytes)) {
      throw Error(
          fmt::format("{}: the file is {}: {:.0f} bytes of its gzip stream can be unpacked{}; copy or export it again",
                      path, whole.damaged ? "damaged" : "cut off", whole.bytes,
                      whole.bytes < static_cast<double>(kHeaderBytes) ? ", and a NIfTI header has 348" : ""));
    }
  }
  throw Error(fmt::format("{}: not a NIfTI file despite its name", path));
}

VoxelType FindType(const NiftiHeader& header, const std::string& path) {
  switch (header.datatype) {
    case 2:
      return VoxelType::kUint8;
    case 4:
      return VoxelType::kInt16;
    case 8:
      return VoxelType::kInt32;
    case 16:
      return VoxelType::kFloat;
    case 64:
      return VoxelType::kDouble;
    case 256:
      return VoxelType::kInt8;
    case 512:
      return VoxelType::kUint16;
    case 768:
      return VoxelType::kUint32;
    case 1024:
      return VoxelType::kInt64;
    case 1280:
      return VoxelType::kUint64;
    case 32:
    case 1792:
      CheckOneComponent(2, path);
      break;
    case 128:
      CheckOneComponent(3, path);
      break;
    case 2304:
      CheckOneComponent(4, path);
      break;
    default:
      break;
  }
  throw Error(fmt::format("{}: voxels of NIfTI type {} are not supported", path, header.datatype));
}

Form SForm(const NiftiHeader& header) {
  Form form;
  for (int row = 0; row < 3; ++row) {
    const double* numbers = &header.rows[4 * static_cast<std::size_t>(row)];
    for (int a = 0; a < 3; ++a) form.steps[a][row] = numbers[a];
    form.origin[row] = numbers[3];
  }
  return form;
}

Form QForm(const NiftiHeader& header) {
  const auto& [b, c, d, offset_x, offset_y, offset_z] = header.quaternion;
  const double rest = 1 - (b * b + c * c + d * d);
  const double a = std::sqrt(std::max(rest, 0.0));
  const double scale = 1 / std::sqrt(a * a + b * b + c * c + d * d);  // it may be longer than 1 due to single precision
  const double w = a * scale, x = b * scale, y = c * scale, z = d * scale;
  Form form;
  form.steps[0] = {w * w + x * x - y * y - z * z, 2 * (x * y + w * z), 2 * (x * z - w * y)};
  form.steps[1] = {2 * (x * y - w * z), w * w + y * y - x * x - z * z, 2 * (y * z + w * x)};
  form.steps[2] = {2 * (x * z + w * y), 2 * (y * z - w * x), w * w + z * z - x * x - y * y};
  if (header.handedness < 0) form.steps[2] *= -1.0;
  for (int axis = 0; axis < 3; ++axis) form.steps[axis] *= header.spacing[axis];
  form.origin = {offset_x, offset_y, offset_z};
  return form;
}

// Returns the largest distance between the two positions of a corner of the volume.
double CalcDistance(const Form& a, const Form& b, const std::array<int, 3>& size) {
  double max_distance = 0;
  for (int corner = 0; corner < 8; ++corner) {
    Vec3 p_V;
    for (int axis = 0; axis < 3; ++axis) p_V[axis] = ((corner >> axis) & 1) != 0 ? size[axis] - 1 : 0;
    max_distance = std::max(max_distance, glm::length(a.steps * p_V + a.origin - b.steps * p_V - b.origin));
  }
  return max_distance;
}

// Returns the length of the header's unit, mm.
double FindUnit(const NiftiHeader& header, const std::string& path, std::vector<std::string>& warnings) {
  if (header.analyze) return 1;
  switch (header.unit & 7) {
    case 0:
      warnings.emplace_back("the NIfTI header gives no unit of length (xyzt_units is 0); mm was assumed");
      return 1;
    case 1:
      return 1000;
    case 2:
      return 1;
    case 3:
      return 0.001;
    default:
      throw Error(fmt::format("{}: the header's unit of length (xyzt_units {}) is unknown; NIfTI has m, mm and um",
                              path, header.unit));
  }
}

// Returns slope and intercept of the stored values. In NIfTI a slope of 0 means no rescaling.
std::pair<double, double> ReadRescale(const NiftiHeader& header, const std::string& path,
                                      std::vector<std::string>& warnings) {
  const double slope = header.slope;
  const double intercept = header.intercept;
  if (slope == 0) return {1, 0};
  if (header.analyze) {
    if (!(slope > 0) || !std::isfinite(slope) || slope == 1) return {1, 0};
    warnings.push_back(
        fmt::format("the Analyze header has a factor of the values, {:.6g}, as SPM writes it; they were multiplied by "
                    "it",
                    slope));
    return {slope, 0};
  }
  if (!std::isfinite(slope)) {
    warnings.push_back(
        fmt::format("the NIfTI header's slope of the values (scl_slope) is {}, which is not a number; the values were "
                    "used as stored, so the HU may be wrong",
                    slope));
    return {1, 0};
  }
  if (!std::isfinite(intercept)) {
    throw Error(
        fmt::format("{}: the header's intercept of the values (scl_inter) is {}, which is not a number, so the HU are "
                    "unknown; correct the header",
                    path, intercept));
  }
  return {slope, intercept};
}

const char* SpaceName(int code) {
  switch (code) {
    case 1:
      return "the scanner's";
    case 2:
      return "another scan's";
    case 3:
      return "Talairach";
    case 4:
      return "MNI";
    default:
      return "a template's";
  }
}

// Returns the form that places the scan in the patient. A form in a standard space may stretch the head to fit it, so
// the other one is preferred in that case.
Form ChooseForm(const NiftiHeader& header, double unit_mm, bool frame_given, Volume& volume) {
  const int s_code = header.sform_code;
  const int q_code = header.qform_code;
  if (s_code <= 0 && q_code <= 0) {
    if (header.analyze && !frame_given) {
      // Axes by the header's "orient": axial, coronal, sagittal, and the same flipped.
      constexpr std::array kAnalyzeFrames{"LAS", "LSA", "ASL", "LPS", "LIA", "AIL"};
      volume.frame = kAnalyzeFrames[static_cast<std::size_t>(header.orient < 6 ? header.orient : 0)];
      volume.warnings.push_back(fmt::format(
          "an Analyze header does not say which side of the patient is left; its axes were taken as {}, so left and "
          "right may be swapped; compare with the patient and set them with --frame",
          volume.frame));
    } else if (!frame_given) {
      volume.warnings.emplace_back(
          "the NIfTI header does not say how the scan lies in the patient (sform_code and qform_code are 0); its axes "
          "were taken as RAS (right, front, head), so left and right may be swapped; set them with --frame");
    }
    Form form;
    for (int a = 0; a < 3; ++a) form.steps[a] *= header.spacing[a];
    return form;
  }
  const Form s = s_code > 0 ? SForm(header) : QForm(header);
  const Form q = q_code > 0 ? QForm(header) : s;
  const bool take_s = s_code > 0 && (s_code <= 2 || q_code <= 0);
  const int code = take_s ? s_code : q_code;
  if (const double apart_mm = CalcDistance(s, q, volume.size) * unit_mm; !(apart_mm <= kFormsAgree_mm)) {
    const bool mirrored = glm::determinant(s.steps) * glm::determinant(q.steps) < 0;
    volume.warnings.push_back(
        fmt::format("the NIfTI header gives two positions of the scan, up to {:.1f} mm apart{}; its {} was used, in {} "
                    "coordinates, "
                    "as it is for a mask",
                    apart_mm, mirrored ? " and mirrored" : "", take_s ? "sform" : "qform", SpaceName(code)));
  }
  if (code > 2) {
    volume.warnings.push_back(
        fmt::format("the NIfTI header places the scan in {} coordinates, to which it may have been stretched; sizes "
                    "may not be the patient's",
                    SpaceName(code)));
  }
  const Form& form = take_s ? s : q;
  for (int a = 0; a < 3; ++a) {
    const double step = glm::length(form.steps[a]);
    const double spacing = header.spacing[a];
    if (std::abs(step - spacing) <= kSpacingsAgree * spacing) continue;
    volume.warnings.push_back(fmt::format(
        "the NIfTI header has two voxel spacings along axis {}, {:.4g} mm by its sform and {:.4g} mm by its "
        "pixdim; the sform's was used",
        a + 1, step * unit_mm, spacing * unit_mm));
  }
  return form;
}

}  // namespace

namespace {

struct NiftiFiles {
  std::string header, voxels;
};

// Returns the files of the pair that a path belongs to, or the path twice.
NiftiFiles FindFiles(const std::string& path) {
  std::string stem = path;
  if (EndsWith(Lower(stem), ".gz")) stem.resize(stem.size() - 3);
  const std::string extension = Lower(stem.substr(stem.size() - std::min<std::size_t>(stem.size(), 4)));
  if (extension != ".hdr" && extension != ".img") return {path, path};
  stem.resize(stem.size() - 4);
  const auto find = [&](const char* wanted, std::initializer_list<const char*> endings) {
    if (extension == wanted) return path;
    std::error_code failed;
    for (const char* ending : endings) {
      if (std::filesystem::exists(stem + ending, failed)) return stem + ending;
    }
    throw Error(fmt::format("{}: the image is a pair of files, and {}{} is missing beside it", path,
                            std::filesystem::path(stem).filename().string(), wanted));
  };
  return {find(".hdr", {".hdr", ".HDR", ".hdr.gz"}), find(".img", {".img", ".IMG", ".img.gz"})};
}

HeaderBytes ReadHeaderBytes(const std::string& path) {
  HeaderBytes header{ReadHead(path).substr(0, kHeader2Bytes)};
  if (IsGzip(path)) {
    std::vector<char> bytes;
    Unpack(path, 0, static_cast<double>(kHeader2Bytes), 0, &bytes);
    header.bytes.assign(bytes.begin(), bytes.end());
  }
  return header;
}

NiftiHeader TakeNifti1(const HeaderBytes& bytes) {
  NiftiHeader header;
  header.swapped = bytes.swapped;
  const int dimensions = bytes.Short(40);
  for (int a = 1; a <= dimensions && dimensions <= 7; ++a) {
    header.sizes.push_back(bytes.Short(40 + 2 * static_cast<std::size_t>(a)));
  }
  for (int a = 0; a < 3; ++a) header.spacing[a] = bytes.Float(80 + 4 * static_cast<std::size_t>(a));
  header.datatype = bytes.Short(70);
  header.bits = bytes.Short(72);
  header.offset = bytes.Float(108);
  header.handedness = bytes.Float(76);
  header.slope = bytes.Float(112);
  header.intercept = bytes.Float(116);
  header.unit = static_cast<unsigned char>(bytes.bytes[123]);
  header.orient = static_cast<unsigned char>(bytes.bytes[252]);
  header.qform_code = bytes.Short(252);
  header.sform_code = bytes.Short(254);
  for (std::size_t i = 0; i < 6; ++i) header.quaternion[i] = bytes.Float(256 + 4 * i);
  for (std::size_t i = 0; i < 12; ++i) header.rows[i] = bytes.Float(280 + 4 * i);
  return header;
}

NiftiHeader TakeNifti2(const HeaderBytes& bytes) {
  NiftiHeader header;
  header.swapped = bytes.swapped;
  const double dimensions = bytes.Long(16);
  for (std::size_t a = 1; dimensions <= 7 && static_cast<double>(a) <= dimensions; ++a) {
    header.sizes.push_back(bytes.Long(16 + 8 * a));
  }
  for (int a = 0; a < 3; ++a) header.spacing[a] = bytes.Double(112 + 8 * static_cast<std::size_t>(a));
  header.datatype = bytes.Short(12);
  header.bits = bytes.Short(14);
  header.offset = bytes.Long(168);
  header.handedness = bytes.Double(104);
  header.slope = bytes.Double(176);
  header.intercept = bytes.Double(184);
  header.unit = bytes.Int(500);
  header.qform_code = bytes.Int(344);
  header.sform_code = bytes.Int(348);
  for (std::size_t i = 0; i < 6; ++i) header.quaternion[i] = bytes.Double(352 + 8 * i);
  for (std::size_t i = 0; i < 12; ++i) header.rows[i] = bytes.Double(400 + 8 * i);
  return header;
}

void CheckFields(const NiftiHeader& header, double first_voxel, const std::string& path) {
  if (header.sizes.empty()) throw Error(fmt::format("{}: the header's number of dimensions is not 1 to 7", path));
  for (std::size_t a = 0; a < std::min<std::size_t>(header.sizes.size(), 3); ++a) {
    const double spacing = header.spacing[static_cast<int>(a)];
    if (!std::isfinite(spacing) || spacing <= 0) {
      throw Error(fmt::format("{}: the header's voxel spacing pixdim[{}] is {}; it must be a length in mm above 0",
                              path, a + 1, spacing));
    }
  }
  if (!(header.offset >= first_voxel && header.offset < 1e9 && header.offset == std::floor(header.offset))) {
    throw Error(
        fmt::format("{}: the header's vox_offset, the byte at which the voxels begin, is {}; it must be a whole number "
                    "of at least {}, so the position of the voxels in the file is unknown; export the file again",
                    path, header.offset, first_voxel));
  }
}

}  // namespace

NiftiHeader ReadNiftiHeader(const std::string& path) {
  const NiftiFiles files = FindFiles(path);
  const bool pair = files.header != files.voxels;
  HeaderBytes bytes = ReadHeaderBytes(files.header);
  const auto refuse = [&files] { RefuseHeader(files.header); };
  if (bytes.bytes.size() < kHeaderBytes) refuse();
  const int size = bytes.Int(0);
  bytes.swapped = size != static_cast<int>(kHeaderBytes) && size != static_cast<int>(kHeader2Bytes);
  const bool is_second = bytes.Int(0) == static_cast<int>(kHeader2Bytes);
  const std::string magic = bytes.bytes.substr(is_second ? 4 : 344, 3);
  const char* version = is_second ? "2" : "1";
  const bool is_nifti = magic == std::string(pair ? "ni" : "n+") + version;
  if (is_second ? !is_nifti || bytes.bytes.size() < kHeader2Bytes
                : bytes.Int(0) != static_cast<int>(kHeaderBytes) || (!is_nifti && (!pair || magic == "n+1"))) {
    refuse();
  }
  NiftiHeader header = is_second ? TakeNifti2(bytes) : TakeNifti1(bytes);
  header.data_file = files.voxels;
  if (!is_nifti) {
    header.analyze = true;
    header.qform_code = header.sform_code = 0;
    header.offset = std::abs(header.offset);  // negative: the same for each volume
  }
  while (header.sizes.size() > 3 && header.sizes.back() == 1) header.sizes.pop_back();
  CheckFields(header, pair ? 0 : is_second ? kFirstVoxel2 : kFirstVoxel, files.header);
  return header;
}

Volume ReadNifti(const std::string& path, const std::string& frame, double scale, std::int16_t blank) {
  const NiftiHeader header = ReadNiftiHeader(path);
  if (header.sizes.size() != 3) {
    throw Error(fmt::format("{}: the image has {} dimensions; kerf requires 3", path, header.sizes.size()));
  }
  const VoxelType type = FindType(header, path);
  const std::size_t bytes = CalcBytes(type);
  if (header.bits != static_cast<int>(8 * bytes)) {
    throw Error(fmt::format("{}: the header contradicts itself: voxels of NIfTI type {} have {} bits, not {}", path,
                            header.datatype, 8 * bytes, header.bits));
  }
  Volume volume;
  volume.frame = frame.empty() ? "RAS" : frame;
  for (int a = 0; a < 3; ++a) volume.size[a] = static_cast<int>(header.sizes[static_cast<std::size_t>(a)]);
  const double unit_mm = FindUnit(header, path, volume.warnings);
  const Form form = ChooseForm(header, unit_mm, !frame.empty(), volume);
  PlaceLattice(form.origin, form.steps, unit_mm, volume);
  CheckLattice(volume, path);

  ImageLayout layout;
  layout.data_file = header.data_file;
  layout.type = type;
  layout.swapped = header.swapped;
  if (IsGzip(header.data_file)) {
    layout.packing = VoxelPacking::kGzip;
    layout.lead = header.offset;
  } else {
    layout.offset = static_cast<std::uint64_t>(header.offset);
  }
  const std::vector<char> values = ReadVoxels(layout, volume.count(), path);
  const auto [slope, intercept] = ReadRescale(header, path, volume.warnings);
  const Overflow overflow = AppendHu(values, layout.type, scale * slope, scale * intercept, volume.hu, blank);
  volume.padding = overflow.is_blank;
  volume.exact = overflow.count == 0 && !overflow.rounded;
  AddWarnings(overflow, volume.count(), blank, volume.warnings);
  return volume;
}

}  // namespace kerf
