#include "bone/import/dicom_slices.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>

#include "bone/import/dicom_text.h"
#include "bone/import/limits.h"
#include "kerf/error.h"

namespace kerf {

std::vector<DicomSlice> ListSlices(const gdcm::Reader& reader, gdcm::StringFilter& filter, const std::string& path) {
  const int rows = GetInteger(filter, 0x0028, 0x0010, 0);
  const int columns = GetInteger(filter, 0x0028, 0x0011, 0);
  DicomSlice slice;
  slice.path = path;
  slice.size = {columns, rows};
  if (static_cast<std::uint64_t>(rows) * static_cast<std::uint64_t>(columns) > kMaxSlicePixels) {
    throw Error(fmt::format("{}: a slice of {} x {} pixels, more than the 2^26 that kerf reads", path, columns, rows));
  }
  slice.samples = GetInteger(filter, 0x0028, 0x0002, 1);
  slice.bits = GetInteger(filter, 0x0028, 0x0100, 16);
  slice.inverted = GetText(filter, 0x0028, 0x0004) == "MONOCHROME1";
  slice.frames = std::max(1, GetInteger(filter, 0x0028, 0x0008, 1));
  const std::vector<double> spacing = GetNumbers(filter, 0x0028, 0x0030);  // the distance between rows comes first
  const std::vector<double> position = GetNumbers(filter, 0x0020, 0x0032);
  const std::vector<double> orientation = GetNumbers(filter, 0x0020, 0x0037);
  if (spacing.size() == 2 && position.size() == 3 && orientation.size() == 6) {
    slice.pixel_mm = {spacing[1], spacing[0]};
    slice.origin_W = {position[0], position[1], position[2]};
    slice.row_W = {orientation[0], orientation[1], orientation[2]};
    slice.column_W = {orientation[3], orientation[4], orientation[5]};
    const double row = glm::length(slice.row_W);
    const double column = glm::length(slice.column_W);
    slice.has_geometry = std::abs(row - 1) < 1e-2 && std::abs(column - 1) < 1e-2 &&
                         std::abs(glm::dot(slice.row_W, slice.column_W)) < 1e-2;
    if (slice.has_geometry) {
      slice.row_W /= row;
      slice.column_W /= column;
    }
  }
  const gdcm::TransferSyntax& syntax = reader.GetFile().GetHeader().GetDataSetTransferSyntax();
  slice.compressed = syntax.IsEncapsulated() || syntax == gdcm::TransferSyntax::DeflatedExplicitVRLittleEndian;
  const char* name = gdcm::TransferSyntax::GetTSString(syntax);
  slice.transfer_syntax = name == nullptr ? "unknown" : name;
  return {std::move(slice)};
}

}  // namespace kerf
