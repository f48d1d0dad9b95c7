// Replacement for the import of CT scans and surfaces in a build without ITK.
#include "bone/import/import.h"

#include "base/core/not_built.h"
#include "bone/import/dicom_input.h"
#include "bone/import/dicom_segments.h"
#include "bone/import/image_file.h"
#include "bone/import/isolate.h"
#include "bone/import/label_image.h"
#include "bone/import/write_dicom_segments.h"

namespace kerf {
namespace {

[[noreturn]] void Fail() {
  FailNotBuilt("reading CT scans and surfaces", "KERF_WITH_IMPORT");
}

}  // namespace

bool IsSurfacePath(const std::string&) {
  Fail();
}
ImportResult Import(const std::string&, const ImportOptions&) {
  Fail();
}
Volume ReadCt(const std::string&, const ImportOptions&, ImportReport&) {
  Fail();
}
bool DicomInput::Is(const std::string&) {
  Fail();
}
DicomInput::DicomInput(const std::string&, const std::function<void(double)>&) {
  Fail();
}
DicomSeries DicomInput::Choose(const std::string&) const {
  Fail();
}
DicomSeries TakeAsCt(DicomSeries, bool) {
  Fail();
}
bool IsDicomFile(const std::string&) {
  Fail();
}
DicomSeries CheckSeries(const DicomSeries&, double) {
  Fail();
}
void CheckContains(const DicomSeries&, const Box3&, const std::string&) {
  Fail();
}
DicomStudy ReadDicomStudy(const DicomSeries&) {
  Fail();
}
void WriteDicomSegments(const DicomWriting&, const DicomStudy&, const std::string&) {
  Fail();
}
DicomSegments ReadDicomSegments(const std::string&, double) {
  Fail();
}
LayeredImage ReadLayeredImage(const std::string&, const std::string&, double) {
  Fail();
}
Isolation Isolate(const Volume&, const IsolateOptions&, const std::function<void(double)>&) {
  Fail();
}
std::string FindLabelObjection(std::span<const std::int16_t>, bool, std::size_t) {
  Fail();
}
Volume ReadLabelImage(const std::string&) {
  Fail();
}
Volume ReadDicomSeries(const DicomSeries&, const std::function<void(double)>&, double) {
  Fail();
}

}  // namespace kerf
