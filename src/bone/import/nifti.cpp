#include "bone/import/nifti.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <glm/geometric.hpp>
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
constexpr double kFormsAgree_mm = 0.1;    // sform and qform have single precision
constexpr double kSpacingsAgree = 1e-3;   // relative, between the sform's steps and pixdim
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

double Real(const NiftiHeader& header, std::size_t offset) {
  return static_cast<double>(Field<float>(header.bytes, offset, header.swapped));
}

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
    const std::size_t at = 280 + 16 * static_cast<std::size_t>(row);
    for (int a = 0; a < 3; ++a) form.steps[a][row] = Real(header, at + 4 * static_cast<std::size_t>(a));
    form.origin[row] = Real(header, at + 12);
  }
  return form;
}

Vec3 Spacing(const NiftiHeader& header) {
  return {Real(header, 80), Real(header, 84), Real(header, 88)};
}

Form QForm(const NiftiHeader& header) {
  const double b = Real(header, 256), c = Real(header, 260), d = Real(header, 264);
  const double rest = 1 - (b * b + c * c + d * d);
  const double a = std::sqrt(std::max(rest, 0.0));
  const double scale = 1 / std::sqrt(a * a + b * b + c * c + d * d);  // it may be longer than 1 due to single precision
  const double w = a * scale, x = b * scale, y = c * scale, z = d * scale;
  Form form;
  form.steps[0] = {w * w + x * x - y * y - z * z, 2 * (x * y + w * z), 2 * (x * z - w * y)};
  form.steps[1] = {2 * (x * y - w * z), w * w + y * y - x * x - z * z, 2 * (y * z + w * x)};
  form.steps[2] = {2 * (x * z + w * y), 2 * (y * z - w * x), w * w + z * z - x * x - y * y};
  if (Real(header, 76) < 0) form.steps[2] *= -1.0;  // the header's qfac
  const Vec3 spacing = Spacing(header);
  for (int axis = 0; axis < 3; ++axis) form.steps[axis] *= spacing[axis];
  form.origin = {Real(header, 268), Real(header, 272), Real(header, 276)};
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
  switch (static_cast<unsigned char>(header.bytes[123]) & 7) {
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
                              path, static_cast<unsigned char>(header.bytes[123])));
  }
}

// Returns slope and intercept of the stored values. In NIfTI a slope of 0 means no rescaling.
std::pair<double, double> ReadRescale(const NiftiHeader& header, const std::string& path,
                                      std::vector<std::string>& warnings) {
  const double slope = Real(header, 112);
  const double intercept = Real(header, 116);
  if (slope == 0) return {1, 0};
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
  const int s_code = Field<std::int16_t>(header.bytes, 254, header.swapped);
  const int q_code = Field<std::int16_t>(header.bytes, 252, header.swapped);
  if (s_code <= 0 && q_code <= 0) {
    if (!frame_given) {
      volume.warnings.emplace_back(
          "the NIfTI header does not say how the scan lies in the patient (sform_code and qform_code are 0); its axes "
          "were taken as RAS (right, front, head), so left and right may be swapped; set them with --frame");
    }
    Form form;
    for (int a = 0; a < 3; ++a) form.steps[a] *= Spacing(header)[a];
    return form;
  }
  const Form s = s_code > 0 ? SForm(header) : QForm(header);
  const Form q = q_code > 0 ? QForm(header) : s;
  const bool take_s = s_code > 0 && (s_code <= 2 || q_code <= 0);
  const int code = take_s ? s_code : q_code;
  if (const double apart_mm = CalcDistance(s, q, volume.size) * unit_mm; !(apart_mm <= kFormsAgree_mm)) {
    const bool mirrored = glm::determinant(s.steps) * glm::determinant(q.steps) < 0;
    volume.warnings.push_back(fmt::format(
        "the NIfTI header gives two positions of the scan, up to {:.1f} mm apart{}; its {} was used, in {} coordinates",
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
    const double spacing = Spacing(header)[a];
    if (std::abs(step - spacing) <= kSpacingsAgree * spacing) continue;
    volume.warnings.push_back(fmt::format(
        "the NIfTI header has two voxel spacings along axis {}, {:.4g} mm by its sform and {:.4g} mm by its "
        "pixdim; the sform's was used",
        a + 1, step * unit_mm, spacing * unit_mm));
  }
  return form;
}

}  // namespace

NiftiHeader ReadNiftiHeader(const std::string& path) {
  NiftiHeader header;
  header.bytes = ReadHead(path).substr(0, kHeaderBytes);
  if (IsGzip(path)) {
    std::vector<char> bytes;
    Unpack(path, 0, static_cast<double>(kHeaderBytes), 0, &bytes);
    header.bytes.assign(bytes.begin(), bytes.end());
  }
  const auto refuse = [&path] { RefuseHeader(path); };
  if (header.bytes.size() < kHeaderBytes) refuse();
  header.swapped = Field<std::int32_t>(header.bytes, 0, false) != 348;
  if (Field<std::int32_t>(header.bytes, 0, header.swapped) != 348 || header.bytes.compare(344, 3, "n+1") != 0) refuse();
  const int dimensions = Field<std::int16_t>(header.bytes, 40, header.swapped);
  if (dimensions < 1 || dimensions > 7) refuse();
  for (int a = 1; a <= dimensions; ++a) {
    header.sizes.push_back(Field<std::int16_t>(header.bytes, 40 + 2 * static_cast<std::size_t>(a), header.swapped));
  }
  while (header.sizes.size() > 3 && header.sizes.back() == 1) header.sizes.pop_back();
  for (std::size_t a = 1; a <= std::min<std::size_t>(header.sizes.size(), 3); ++a) {
    const float spacing = Field<float>(header.bytes, 76 + 4 * a, header.swapped);
    if (!std::isfinite(spacing) || spacing <= 0) {
      throw Error(fmt::format("{}: the header's voxel spacing pixdim[{}] is {}; it must be a length in mm above 0",
                              path, a, spacing));
    }
  }
  header.datatype = Field<std::int16_t>(header.bytes, 70, header.swapped);
  header.bits = Field<std::int16_t>(header.bytes, 72, header.swapped);
  header.offset = Real(header, 108);
  if (!(header.offset >= static_cast<double>(kHeaderBytes) && header.offset < 1e9)) refuse();
  return header;
}

Volume ReadNifti(const std::string& path, const std::string& frame, double scale) {
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
  layout.data_file = path;
  layout.type = type;
  layout.swapped = header.swapped;
  if (IsGzip(path)) {
    layout.packing = VoxelPacking::kGzip;
    layout.lead = header.offset;
  } else {
    layout.offset = static_cast<std::uint64_t>(header.offset);
  }
  const std::vector<char> values = ReadVoxels(layout, volume.count(), path);
  const auto [slope, intercept] = ReadRescale(header, path, volume.warnings);
  const Overflow overflow = AppendHu(values, layout.type, scale * slope, scale * intercept, path, volume.hu);
  volume.exact = overflow.count == 0 && !overflow.rounded;
  if (overflow.count > 0) volume.warnings.push_back(Describe(overflow, volume.count()));
  return volume;
}

}  // namespace kerf
