#include "bone/import/series_bytes.h"

#include <nlohmann/json.hpp>

#include "kerf/error.h"

namespace kerf {
namespace {

using Json = nlohmann::json;

Json ToJson(const Vec3& v) {
  return {v.x, v.y, v.z};
}
Vec3 ToVec3(const Json& json) {
  return {json.at(0).get<double>(), json.at(1).get<double>(), json.at(2).get<double>()};
}

Json ToJson(const DicomSlice& s) {
  return {s.path, ToJson(s.origin_W), ToJson(s.row_W), ToJson(s.column_W), s.pixel_mm, s.size,           s.samples,
          s.bits, s.frames,           s.has_geometry,  s.compressed,       s.inverted, s.transfer_syntax};
}
DicomSlice ToSlice(const Json& json) {
  DicomSlice s;
  json.at(0).get_to(s.path);
  s.origin_W = ToVec3(json.at(1));
  s.row_W = ToVec3(json.at(2));
  s.column_W = ToVec3(json.at(3));
  json.at(4).get_to(s.pixel_mm);
  json.at(5).get_to(s.size);
  json.at(6).get_to(s.samples);
  json.at(7).get_to(s.bits);
  json.at(8).get_to(s.frames);
  json.at(9).get_to(s.has_geometry);
  json.at(10).get_to(s.compressed);
  json.at(11).get_to(s.inverted);
  json.at(12).get_to(s.transfer_syntax);
  return s;
}

}  // namespace

std::string Encode(const std::vector<DicomSeries>& all) {
  Json list = Json::array();
  for (const DicomSeries& series : all) {
    Json slices = Json::array();
    for (const DicomSlice& slice : series.slices) slices.push_back(ToJson(slice));
    list.push_back({series.uid, series.description, series.modality, std::move(slices), series.gap_mm});
  }
  // CBOR preserves each double's bits, and text that is not UTF-8.
  std::string bytes;
  Json::to_cbor(list, bytes);
  return bytes;
}

std::vector<DicomSeries> DecodeSeries(std::string_view bytes) {
  std::vector<DicomSeries> all;
  try {
    for (const Json& item : Json::from_cbor(bytes)) {
      DicomSeries& series = all.emplace_back();
      item.at(0).get_to(series.uid);
      item.at(1).get_to(series.description);
      item.at(2).get_to(series.modality);
      for (const Json& slice : item.at(3)) series.slices.push_back(ToSlice(slice));
      item.at(4).get_to(series.gap_mm);
    }
  } catch (const Json::exception&) {
    throw Error("the process that listed the DICOM files sent invalid data");
  }
  return all;
}

}  // namespace kerf
