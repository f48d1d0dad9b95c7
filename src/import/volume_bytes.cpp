#include "import/volume_bytes.h"

#include <cstring>
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
  return {s.path, ToJson(s.origin_W), ToJson(s.row_W), ToJson(s.column_W), s.pixel_mm,       s.size, s.samples,
          s.bits, s.frames,           s.has_geometry,  s.compressed,       s.transfer_syntax};
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
  json.at(11).get_to(s.transfer_syntax);
  return s;
}

std::string ToBytes(const Json& json) {
  // CBOR keeps each double's bits, and text that is not UTF-8.
  std::string bytes;
  Json::to_cbor(json, bytes);
  return bytes;
}

template <typename Read>
auto FromBytes(std::string_view bytes, Read read) {
  try {
    return read(Json::from_cbor(bytes));
  } catch (const Json::exception&) {
    throw Error("the process that read the file has sent something else");
  }
}

}  // namespace

std::string Encode(const Volume& v) {
  const std::string head = ToBytes({v.size, ToJson(v.spacing_mm), ToJson(v.origin_W), ToJson(v.axes_W[0]),
                                    ToJson(v.axes_W[1]), ToJson(v.axes_W[2]), v.frame, v.warnings, v.hu.size()});
  const std::uint64_t head_bytes = head.size();
  const std::size_t hu_bytes = v.hu.size() * sizeof(std::int16_t);
  std::string bytes(sizeof head_bytes + head.size() + hu_bytes, '\0');
  std::memcpy(bytes.data(), &head_bytes, sizeof head_bytes);
  std::memcpy(&bytes[sizeof head_bytes], head.data(), head.size());
  if (hu_bytes > 0) std::memcpy(&bytes[sizeof head_bytes + head.size()], v.hu.data(), hu_bytes);
  return bytes;
}

Volume DecodeVolume(std::string_view bytes) {
  std::uint64_t head_bytes = 0;
  if (bytes.size() >= sizeof head_bytes) std::memcpy(&head_bytes, bytes.data(), sizeof head_bytes);
  bytes.remove_prefix(std::min(bytes.size(), sizeof head_bytes));
  const std::string_view head = bytes.substr(0, head_bytes);
  const std::string_view hu = bytes.substr(head.size());
  return FromBytes(head, [hu](const Json& json) {
    Volume v;
    json.at(0).get_to(v.size);
    v.spacing_mm = ToVec3(json.at(1));
    v.origin_W = ToVec3(json.at(2));
    for (int a = 0; a < 3; ++a) v.axes_W[a] = ToVec3(json.at(3 + static_cast<std::size_t>(a)));
    json.at(6).get_to(v.frame);
    json.at(7).get_to(v.warnings);
    const auto count = json.at(8).get<std::size_t>();
    if (count != hu.size() / sizeof(std::int16_t)) throw Error("the process that read the file has sent a part");
    v.hu.resize(count);
    if (count > 0) std::memcpy(v.hu.data(), hu.data(), hu.size());
    return v;
  });
}

std::string Encode(const std::vector<DicomSeries>& all) {
  Json list = Json::array();
  for (const DicomSeries& series : all) {
    Json slices = Json::array();
    for (const DicomSlice& slice : series.slices) slices.push_back(ToJson(slice));
    list.push_back({series.uid, series.description, series.modality, std::move(slices), series.gap_mm});
  }
  return ToBytes(list);
}

std::vector<DicomSeries> DecodeSeries(std::string_view bytes) {
  return FromBytes(bytes, [](const Json& json) {
    std::vector<DicomSeries> all;
    for (const Json& item : json) {
      DicomSeries& series = all.emplace_back();
      item.at(0).get_to(series.uid);
      item.at(1).get_to(series.description);
      item.at(2).get_to(series.modality);
      for (const Json& slice : item.at(3)) series.slices.push_back(ToSlice(slice));
      item.at(4).get_to(series.gap_mm);
    }
    return all;
  });
}

}  // namespace kerf
