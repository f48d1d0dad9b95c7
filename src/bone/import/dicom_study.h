// What a DICOM file that refers to a CT takes from it.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "bone/import/dicom.h"

namespace kerf {

/// Patient and study of a CT series, and the identifiers of its slices.
struct DicomStudy {
  struct Element {
    std::uint16_t group = 0, element = 0;
    std::string value;  // as it is stored
  };
  std::vector<Element> elements;  // patient, study and frame of reference, by ascending tag
  std::string series_uid;
  std::string class_uid;                   // of the slices
  std::vector<std::string> instance_uids;  // of the slices, along the normal
  glm::dmat3 file_from_lps{1};             // turns vectors to the frame of the slices, if that is not LPS
};

/// Throws kerf::Error, with `name` in the message, unless a box (LPS, mm) lies in the box around the slices, grown by
/// 5 mm.
void CheckContains(const DicomSeries& series, const Box3& box_W, const std::string& name);

/// Reads them from the headers of the slices, including the patient's name. Throws kerf::Error if a slice cannot be
/// read, if the slices name different patients, studies or frames of reference, or if they do not name them.
DicomStudy ReadDicomStudy(const DicomSeries& series);

}  // namespace kerf
