#include "bone/import/dicom_study.h"

#include <fmt/format.h>
#include <gdcmReader.h>

#include <algorithm>
#include <array>
#include <nlohmann/json.hpp>
#include <set>
#include <utility>

#include "base/files/child.h"
#include "bone/import/dicom_elements.h"
#include "bone/import/dicom_header.h"
#include "kerf/error.h"

namespace kerf {
namespace {

using Json = nlohmann::json;

constexpr ChildLimits kReadingStudy{std::uint64_t{512} << 20, 120};

struct ElementTag {
  std::uint16_t group, element;
  bool operator==(const ElementTag&) const = default;
};
constexpr ElementTag kPatientName{0x0010, 0x0010}, kPatientId{0x0010, 0x0020};
constexpr ElementTag kStudyUid{0x0020, 0x000d}, kFrameOfReference{0x0020, 0x0052};
// Also kept: the character set of the texts; date, time, accession number, physician and identifier of the study; the
// patient's date of birth and sex; the anatomical reference of the frame.
constexpr std::array kKept{ElementTag{0x0008, 0x0005},
                           ElementTag{0x0008, 0x0020},
                           ElementTag{0x0008, 0x0030},
                           ElementTag{0x0008, 0x0050},
                           ElementTag{0x0008, 0x0090},
                           kPatientName,
                           kPatientId,
                           ElementTag{0x0010, 0x0030},
                           ElementTag{0x0010, 0x0040},
                           kStudyUid,
                           ElementTag{0x0020, 0x0010},
                           kFrameOfReference,
                           ElementTag{0x0020, 0x1040}};
// They are the same in all slices.
constexpr std::array kIdentifying{kPatientName, kPatientId, kStudyUid, kFrameOfReference};

// For a child process.
Json ReadInChild(const DicomSeries& series, ChildReport& report) {
  Json json{{"elements", Json::array()}, {"instances", Json::array()}};
  std::set<std::string> paths;
  for (const DicomSlice& slice : series.slices) {
    if (!paths.insert(slice.path).second) continue;  // another frame of the file
    report.SetName(slice.path);
    CheckDicomHeader(slice.path);
    gdcm::Reader reader;
    reader.SetFileName(slice.path.c_str());
    if (!reader.ReadUpToTag(gdcm::Tag(0x7fe0, 0x0010))) {
      throw Error(fmt::format("{}: the DICOM header can't be read; the file is damaged or cut off", slice.path));
    }
    const gdcm::DataSet& data = reader.GetFile().GetDataSet();
    if (json["instances"].empty()) {
      json["class"] = ReadText(data, 0x0008, 0x0016);
      for (const ElementTag& tag : kKept) json["elements"].push_back(ReadText(data, tag.group, tag.element));
    }
    for (std::size_t i = 0; i < kKept.size(); ++i) {
      const bool identifies = std::find(kIdentifying.begin(), kIdentifying.end(), kKept[i]) != kIdentifying.end();
      if (identifies && json["elements"][i] != ReadText(data, kKept[i].group, kKept[i].element)) {
        throw Error(fmt::format(
            "{}: names another patient, study or frame of reference than the first slice of its series", slice.path));
      }
    }
    json["instances"].push_back(ReadText(data, 0x0008, 0x0018));
    report.SetProgress(static_cast<double>(json["instances"].size()) / static_cast<double>(series.slices.size()));
  }
  return json;
}

}  // namespace

void CheckContains(const DicomSeries& series, const Box3& box_W, const std::string& name) {
  constexpr double kSlack_mm = 5;
  Box3 slices_W;
  for (const DicomSlice& slice : series.slices) {
    if (!slice.has_geometry) continue;
    for (int corner = 0; corner < 4; ++corner) {
      const double along_row_mm = (corner & 1) * slice.size[0] * slice.pixel_mm[0];
      const double along_column_mm = (corner >> 1) * slice.size[1] * slice.pixel_mm[1];
      slices_W.Include(slice.origin_W + along_row_mm * slice.row_W + along_column_mm * slice.column_W);
    }
  }
  const Box3 grown_W = slices_W.Grown(kSlack_mm);
  Box3 both_W = grown_W;
  both_W.Include(box_W.lower);
  both_W.Include(box_W.upper);
  if (both_W.lower != grown_W.lower || both_W.upper != grown_W.upper) {
    throw Error(fmt::format("{}: the bone is not inside this CT", name));
  }
}

DicomStudy ReadDicomStudy(const DicomSeries& series) {
  const std::string& first = series.slices.front().path;
  const auto read = [&series](ChildReport& report) {
    std::string cbor;
    Json::to_cbor(ReadInChild(series, report), cbor);
    return cbor;
  };
  const Json json = Json::from_cbor(RunInChild(first, kReadingStudy, read, {}));
  DicomStudy study;
  study.series_uid = series.uid;
  json.at("class").get_to(study.class_uid);
  json.at("instances").get_to(study.instance_uids);
  for (std::size_t i = 0; i < kKept.size(); ++i) {
    study.elements.push_back({kKept[i].group, kKept[i].element, json.at("elements").at(i).get<std::string>()});
    if (!study.elements.back().value.empty()) continue;
    for (const auto& [needed, name] :
         {std::pair{kStudyUid, "identifier of the study"}, {kFrameOfReference, "frame of reference"}}) {
      if (kKept[i] == needed) throw Error(fmt::format("{}: lacks the {}, to which a segmentation refers", first, name));
    }
  }
  const bool all_named = std::none_of(study.instance_uids.begin(), study.instance_uids.end(),
                                      [](const std::string& uid) { return uid.empty(); });
  if (study.series_uid.empty() || study.class_uid.empty() || !all_named) {
    throw Error(fmt::format("{}: a slice of the series has no identifier that a segmentation can refer to", first));
  }
  return study;
}

}  // namespace kerf
