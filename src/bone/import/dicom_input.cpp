#include "bone/import/dicom_input.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>

#include "base/core/number_text.h"
#include "base/files/files.h"
#include "bone/import/dicom_division.h"
#include "bone/import/dicom_segments.h"
#include "bone/import/dicom_zip.h"
#include "kerf/error.h"

namespace kerf {
namespace {

namespace fs = std::filesystem;

// Calls `work`; a kerf::Error that it throws names the files by their places in the input.
template <typename Work>
auto WithNames(const DicomInput& input, const Work& work) {
  try {
    return work();
  } catch (const UnclearSeries& e) {
    throw UnclearSeries(input.NameFiles(e.what()), e.why(), e.series());
  } catch (const Error& e) {
    throw Error(input.NameFiles(e.what()));
  }
}

}  // namespace

bool DicomInput::Is(const std::string& path) {
  std::error_code failed;
  return fs::is_directory(path, failed) || IsZipFile(path) || IsDicomFile(path);
}

DicomInput::DicomInput(const std::string& path, const std::function<void(double)>& progress) : path_(path) {
  std::error_code failed;
  const bool is_folder = fs::is_directory(path, failed);
  std::vector<LeftOutFile> left_out;
  if (!is_folder && IsZipFile(path)) {
    unpacked_ = std::make_unique<TemporaryFolder>("kerf_ct");
    left_out = UnpackZip(path, unpacked_->path(), progress);
  } else if (!is_folder) {
    is_slice_ = fs::exists(path, failed) && IsDicomFile(path) && !IsDicomDirectory(path);
  }
  series_ = WithNames(*this, [&] { return ListDicomSeries(unpacked_ ? unpacked_->path() : path, progress); });
  const std::vector<std::string> sentences = DescribeLeftOut(left_out);
  for (DicomSeries& series : series_) {
    series.left_out.insert(series.left_out.end(), left_out.begin(), left_out.end());
    series.warnings.insert(series.warnings.end(), sentences.begin(), sentences.end());
  }
}

DicomSeries DicomInput::Choose(const std::string& uid) const {
  return WithNames(*this, [&] {
    if (!is_slice_ || !uid.empty()) return ChooseSeries(series_, uid, path_);
    const auto is_this = [this](const std::string& other) { return IsSameFile(other, path_); };
    const auto holds = [&](const DicomSeries& series) {
      return std::any_of(series.slices.begin(), series.slices.end(),
                         [&](const DicomSlice& slice) { return is_this(slice.path); });
    };
    for (const DicomSeries& series : series_) {
      if (!holds(series)) continue;
      DicomSeries chosen = ChooseSeries({series}, series.name(), path_);
      for (const DicomSeries& other : series_) {
        if (&other == &series || !holds(other)) continue;
        chosen.warnings.push_back(
            fmt::format("the file also has {} of another stack, which were left out; choose them "
                        "with --series {}",
                        FormatCount(other.slices.size(), "slice", "slices"), other.name()));
      }
      return chosen;
    }
    for (const DicomSeries& series : series_) {
      for (const LeftOutFile& file : series.left_out) {
        if (is_this(file.path)) throw Error(fmt::format("{}; give a slice of the CT or its folder", file.fault));
      }
    }
    throw Error(fmt::format("{}: belongs to no series of its folder; give the folder of the CT", path_));
  });
}

std::string DicomInput::NameFiles(std::string message) const {
  if (!unpacked_) return message;
  const std::string& folder = unpacked_->path();
  for (std::size_t at = message.find(folder); at != std::string::npos; at = message.find(folder, at + path_.size())) {
    message.replace(at, folder.size(), path_);
  }
  return message;
}

DicomSeries TakeAsCt(DicomSeries series, bool as_ct) {
  const auto is_capture = [](const DicomSlice& s) { return s.class_uid.starts_with("1.2.840.10008.5.1.4.1.1.7"); };
  const bool captured = std::all_of(series.slices.begin(), series.slices.end(), is_capture);
  if ((series.modality == "CT" && !captured) || (series.modality != "CT" && !MayBeCt(series.modality))) return series;
  const std::string what =
      series.modality == "CT"
          ? std::string("is stored as secondary captures, that is, as pictures that another program made")
          : fmt::format("has the modality {}, not CT", series.modality.empty() ? "(not given)" : series.modality);
  if (!as_ct) {
    throw UnclearSeries(
        fmt::format("series {}: {}; if it is a CT with Hounsfield units that another program wrote, import it with "
                    "--as-ct",
                    series.name(), what),
        "the series " + what, {series});
  }
  series.modality = "CT";
  series.warnings.push_back(fmt::format("the series {}; it was read as a CT because of --as-ct", what));
  return series;
}

std::vector<std::uint8_t> DrawMiddleSlice(const DicomSeries& series, int side) {
  constexpr std::size_t kRead = 3;  // slices; a series has no fewer
  if (series.slices.size() < kRead || side < 1) return {};
  DicomSeries middle = series;
  middle.modality = "CT";
  const auto first = series.slices.begin() + static_cast<std::ptrdiff_t>((series.slices.size() - kRead) / 2);
  middle.slices.assign(first, first + kRead);
  Volume ct;
  try {
    ct = ReadDicomSeries(middle, {}, middle.slices.front().has_spacing ? 0 : 1);
  } catch (const Error&) {  // the import reports the reason
    return {};
  }
  const auto slice = ct.hu.begin() + static_cast<std::ptrdiff_t>(ct.Index(0, 0, ct.size[2] / 2));
  std::vector<std::int16_t> values(slice, slice + static_cast<std::ptrdiff_t>(ct.Index(0, 0, 1)));
  const auto quantile = [&values](double fraction) -> double {
    const auto at = values.begin() + static_cast<std::ptrdiff_t>(fraction * static_cast<double>(values.size() - 1));
    std::nth_element(values.begin(), at, values.end());
    return *at;
  };
  // Fat is dark in HU; other values, such as grey values of a cone-beam CT, are spread over all greys.
  const double black = std::max(-300.0, quantile(0.01));
  const double white = std::max(black + 1, quantile(0.998));
  const double width_mm = ct.size[0] * ct.spacing_mm.x;
  const double height_mm = ct.size[1] * ct.spacing_mm.y;
  const double pixel_mm = std::max(width_mm, height_mm) / side;
  std::vector<std::uint8_t> picture(static_cast<std::size_t>(side) * static_cast<std::size_t>(side), 0);
  for (int row = 0; row < side; ++row) {
    for (int column = 0; column < side; ++column) {
      const double x_mm = (column + 0.5) * pixel_mm - 0.5 * (side * pixel_mm - width_mm);
      const double y_mm = (row + 0.5) * pixel_mm - 0.5 * (side * pixel_mm - height_mm);
      const std::array ijk{static_cast<int>(std::floor(x_mm / ct.spacing_mm.x)),
                           static_cast<int>(std::floor(y_mm / ct.spacing_mm.y)), ct.size[2] / 2};
      if (!ct.Contains(ijk)) continue;
      const double fraction = (ct.hu[ct.Index(ijk[0], ijk[1], ijk[2])] - black) / (white - black);
      picture[static_cast<std::size_t>(row) * static_cast<std::size_t>(side) + static_cast<std::size_t>(column)] =
          static_cast<std::uint8_t>(std::lround(255 * std::clamp(fraction, 0.0, 1.0)));
    }
  }
  return picture;
}

}  // namespace kerf
