#include "bone/import/series_bytes.h"

#include <nlohmann/json.hpp>

#include "kerf/error.h"

namespace kerf {

NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(LeftOutFile, path, kind, fault, may_be_slice)

namespace {

using Json = nlohmann::json;

void Put(Json& list, const Vec3& v) {
  list.push_back({v.x, v.y, v.z});
}
void Get(const Json& json, Vec3& v) {
  v = {json.at(0).get<double>(), json.at(1).get<double>(), json.at(2).get<double>()};
}

template <typename T>
void Put(Json& list, const T& value) {
  list.push_back(value);
}
template <typename T>
void Get(const Json& json, T& value) {
  json.get_to(value);
}

// Calls visit(field) for each field, except the slices of a series.
template <typename Slice, typename Visit>
void VisitSlice(Slice& s, Visit&& visit) {
  visit(s.path);
  visit(s.origin_W);
  visit(s.row_W);
  visit(s.column_W);
  visit(s.pixel_mm);
  visit(s.size);
  visit(s.samples);
  visit(s.bits);
  visit(s.frames);
  visit(s.has_geometry);
  visit(s.compressed);
  visit(s.inverted);
  visit(s.transfer_syntax);
  visit(s.class_uid);
  visit(s.instance_uid);
  visit(s.modality);
  visit(s.image_type);
  visit(s.patient);
  visit(s.study);
  visit(s.phase);
  visit(s.acquisition);
  visit(s.acquisition_time);
  visit(s.kernel);
  visit(s.telling);
  visit(s.thickness_mm);
  visit(s.pixels_at);
  visit(s.damage);
  visit(s.frame);
  visit(s.stack);
  visit(s.spacing_from);
  visit(s.has_spacing);
  visit(s.has_orientation);
  visit(s.bits_stored);
  visit(s.is_signed);
  visit(s.slope);
  visit(s.intercept);
  visit(s.rescale);
  visit(s.has_padding);
  visit(s.padding);
  visit(s.fault);
}
template <typename Series, typename Visit>
void VisitSeries(Series& s, Visit&& visit) {
  visit(s.uid);
  visit(s.description);
  visit(s.modality);
  visit(s.study_date);
  visit(s.frame_uid);
  visit(s.gap_mm);
  visit(s.part);
  visit(s.part_name);
  visit(s.left_out);
  visit(s.warnings);
}

}  // namespace

std::string Encode(const std::vector<DicomSeries>& all) {
  Json list = Json::array();
  for (const DicomSeries& series : all) {
    Json fields = Json::array();
    VisitSeries(series, [&fields](const auto& field) { Put(fields, field); });
    Json slices = Json::array();
    for (const DicomSlice& slice : series.slices) {
      VisitSlice(slice, [&item = slices.emplace_back(Json::array())](const auto& field) { Put(item, field); });
    }
    fields.push_back(std::move(slices));
    list.push_back(std::move(fields));
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
      std::size_t at = 0;
      VisitSeries(series, [&](auto& field) { Get(item.at(at++), field); });
      for (const Json& fields : item.at(at)) {
        std::size_t n = 0;
        VisitSlice(series.slices.emplace_back(), [&](auto& field) { Get(fields.at(n++), field); });
      }
    }
  } catch (const Json::exception&) {
    throw Error("the process that listed the DICOM files sent invalid data");
  }
  return all;
}

}  // namespace kerf
