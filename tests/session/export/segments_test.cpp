// A bone and its cut as a segmentation, read back by kerf and by teem, which is independent of it.
#include "session/export/segments.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <numbers>
#include <sstream>

#include "bone/import/ct_files.h"
#include "bone/import/patient_frame.h"
#include "bone/segmentation/dicom_segmentation.h"
#include "bone/segmentation/roles.h"
#include "bone/segmentation/segmentation.h"
#include "session/marks/jaw.h"
#include "support/folder.h"
#include "support/message_of.h"

namespace kerf {
namespace {

using test::Folder;
using test::kVoxel_mm;
using test::MakeSegmentedJaw;
using ::testing::HasSubstr;

const Segment& Find(const Segmentation& all, const std::string& name) {
  for (const Segment& segment : all.segments) {
    if (segment.name == name) return segment;
  }
  ADD_FAILURE() << "no segment " << name;
  static const Segment kNone;
  return kNone;
}

/// Returns the sum of the coordinates of the segment's voxels, mm.
Vec3 SumPlaces(const Segmentation& all, const Segment& segment) {
  Vec3 sum_W{0};
  const auto& labels = all.layers[static_cast<std::size_t>(segment.layer)];
  for (std::size_t v = 0; v < labels.size(); ++v) {
    if (labels[v] != segment.label) continue;
    const auto width = static_cast<std::size_t>(all.lattice.size[0]);
    const auto height = static_cast<std::size_t>(all.lattice.size[1]);
    sum_W += all.lattice.WorldFromVoxel({v % width, v / width % height, v / width / height});
  }
  return sum_W;
}

class Segments : public ::testing::Test {
 protected:
  // A slot through the whole block, and one in tooth 36.
  void Write() {
    const Bone before = MakeSegmentedJaw(), after = MakeSegmentedJaw(6, 17);
    written_ = WriteSegments(after, &before, kVoxel_mm, path_);
    read_ = ReadSegmentation(path_);
  }
  int LabelAt(int layer, const Vec3& p_W) const {
    const Vec3 at = glm::round(read_.lattice.VoxelFromWorld(p_W));
    return read_.layers[static_cast<std::size_t>(layer)]
                       [read_.lattice.Index(static_cast<int>(at.x), static_cast<int>(at.y), static_cast<int>(at.z))];
  }
  bool IsIn(const std::string& name, const Vec3& p_W) const {
    const Segment& segment = Find(read_, name);
    return LabelAt(segment.layer, p_W) == segment.label;
  }

  const Folder folder_;
  const std::string path_ = folder_.file("cut.seg.nrrd");
  SegmentationWriting written_;
  Segmentation read_;
};

TEST_F(Segments, HoldTheBoneItsPiecesTheCutAndTheStructures) {
  Write();
  EXPECT_TRUE(read_.warnings.empty());
  ASSERT_EQ(read_.segments.size(), written_.segments.size());
  for (std::size_t i = 0; i < read_.segments.size(); ++i) {
    EXPECT_EQ(read_.segments[i].name, written_.segments[i].name);
    EXPECT_EQ(read_.segments[i].voxels, written_.segments[i].voxels);
  }
  // The faces of the block, of the slot and of the regions are faces of voxels, but the slot's, which lie in their
  // middle: its 2 voxels are 1 to 3.
  EXPECT_NEAR(Find(read_, "bone before the cut").volume_mm3, 40 * 20 * 16, 1e-6);
  EXPECT_NEAR(Find(read_, "removed").volume_mm3, 0.4 * 20 * 16, kVoxel_mm * 20 * 16);
  EXPECT_NEAR(Find(read_, "tooth 37").volume_mm3, 4 * 4 * 6, 0.5 * kVoxel_mm * (2 * 16 + 4 * 24));
  EXPECT_NEAR(Find(read_, "lesion").volume_mm3, 4.0 / 3 * std::numbers::pi * 8, 3);
  EXPECT_NEAR(Find(read_, "metal").volume_mm3, 4 * 20 * 16, 0.5 * kVoxel_mm * 2 * 20 * 16);
  // Places, in the patient's frame. The larger piece is on the patient's right.
  EXPECT_TRUE(IsIn("piece 1", {-10, 0, -12}));
  EXPECT_TRUE(IsIn("piece 2", {10, 0, -12}));
  EXPECT_TRUE(IsIn("removed", {6, 0, -12}));
  EXPECT_TRUE(IsIn("tooth 36", {5, 0, -3}) && IsIn("tooth 37", {9, 0, -3}));
  EXPECT_TRUE(IsIn("tooth 36", {6, 0, -3})) << "structures are those before the cut";
  EXPECT_TRUE(IsIn("metal", {18, 5, -5}));
  EXPECT_FALSE(IsIn("bone before the cut", {0, 0, 0.1}));
  // kerf's own import understands the codes and the names.
  EXPECT_EQ(FindRoles(read_, {}).meanings[0].role, SegmentRole::kMandible);
  EXPECT_EQ(FindMeaning("tooth 36")->fdi, 36);
  EXPECT_EQ(FindMeaning("canal of the nerve, patient's left")->side, JawSide::kLeft);
  EXPECT_EQ(FindMeaning("metal")->role, SegmentRole::kMetal);
}

TEST_F(Segments, OfABoneWithoutACutAreTheBoneAndItsStructures) {
  const Bone bone = MakeSegmentedJaw();
  WriteSegments(bone, nullptr, 0.4, path_);
  read_ = ReadSegmentation(path_);
  std::vector<std::string> names;
  for (const Segment& segment : read_.segments) names.push_back(segment.name);
  EXPECT_THAT(names, ::testing::ElementsAre("bone", "tooth 1 from the middle, patient's right", "tooth 36", "tooth 37",
                                            "lesion", "metal"));
  EXPECT_EQ(test::MessageOf([&] { WriteSegments(Bone(), nullptr, 0.4, path_); }),
            "there is no bone to write as a segmentation");
}

TEST_F(Segments, NameNoMetalWithoutAny) {
  // The table of materials has a region of metal.
  const Bone jaw = test::MakeJaw();
  EXPECT_TRUE(WriteSegments(jaw, nullptr, 0.4, path_).without_voxels.empty());
}

TEST_F(Segments, OfACutNeedTheBoneBeforeIt) {
  const Bone before = MakeSegmentedJaw(), after = MakeSegmentedJaw(6, 17);
  EXPECT_THAT(test::MessageOf([&] { WriteSegments(before, &after, 0.4, path_); }),
              HasSubstr("1.0 % of the bone is outside the bone before the cut; they are swapped"));
}

// Runs a command in the folder; returns whether it succeeded.
bool RunIn(const std::string& command, const Folder& folder) {
  return std::system(fmt::format("cd '{}' && {}", folder.path(), command).c_str()) == 0;
}

TEST_F(Segments, AreReadAlikeByTeem) {
  if (std::system("teem-unu about >/dev/null 2>&1") != 0) GTEST_SKIP() << "teem-apps (teem-unu) is not installed";
  Write();
  for (std::size_t layer = 0; layer < read_.layers.size(); ++layer) {
    ASSERT_TRUE(
        RunIn(fmt::format("teem-unu slice -i cut.seg.nrrd -a 0 -p {} | teem-unu save -f nrrd -e raw -o a.nrrd && "
                          "teem-unu data a.nrrd >a.raw && teem-unu head a.nrrd >a.txt",
                          layer),
              folder_));
    const std::string bytes = test::ReadBytes(folder_.file("a.raw"));
    ASSERT_EQ(bytes.size(), read_.layers[layer].size());
    std::size_t different = 0;
    for (std::size_t v = 0; v < bytes.size(); ++v) {
      different += static_cast<unsigned char>(bytes[v]) != read_.layers[layer][v] ? 1 : 0;
    }
    EXPECT_EQ(different, 0u) << layer;
    const std::string header = test::ReadBytes(folder_.file("a.txt"));
    EXPECT_THAT(header, HasSubstr("space: left-posterior-superior"));
    EXPECT_THAT(header, HasSubstr("space directions: (0.2"));
  }
}

// Reads a DICOM segmentation with pydicom. Prints the identifiers, then for each segment its name, type, number of
// voxels and the sum of their coordinates, mm.
constexpr const char* kReadDicom = R"(
import numpy
import pydicom

d = pydicom.dcmread('cut.dcm')
print(d.SOPClassUID, d.Modality, d.PatientName, d.StudyInstanceUID, d.FrameOfReferenceUID)
series = d.ReferencedSeriesSequence[0]
print(series.SeriesInstanceUID, len(series.ReferencedInstanceSequence))
shared = d.SharedFunctionalGroupsSequence[0]
mm = [float(v) for v in shared.PixelMeasuresSequence[0].PixelSpacing]
assert [float(v) for v in shared.PlaneOrientationSequence[0].ImageOrientationPatient] == [1, 0, 0, 0, 1, 0]
shape = (int(d.NumberOfFrames), d.Rows, d.Columns)
pixels = numpy.unpackbits(numpy.frombuffer(d.PixelData, numpy.uint8), bitorder='little')[:numpy.prod(shape)].reshape(shape)
for segment in d.SegmentSequence:
    count, total = 0, numpy.zeros(3)
    for frame, of in zip(pixels, d.PerFrameFunctionalGroupsSequence):
        if of.SegmentIdentificationSequence[0].ReferencedSegmentNumber != segment.SegmentNumber:
            continue
        rows, columns = numpy.nonzero(frame)
        origin = numpy.array([float(v) for v in of.PlanePositionSequence[0].ImagePositionPatient])
        count += len(rows)
        total += len(rows) * origin + numpy.array([columns.sum() * mm[1], rows.sum() * mm[0], 0])
    print(segment.SegmentLabel, segment.SegmentedPropertyTypeCodeSequence[0].CodeValue, count,
          *('%.2f' % v for v in total + 0.0), sep=';')
)";

class DicomSegments : public Segments {
 protected:
  // A CT around the jaw, of which the slices have the identifiers 1.2.3.4.5.1 and on.
  DicomStudy MakeStudy() const {
    const std::string folder = folder_.file("ct");
    std::filesystem::create_directory(folder);
    test::WriteDicom(test::MakeCt(
                         {15, 9, 9}, {4, 4, 4}, {-28, -16, -26}, glm::dmat3(1),
                         [](const Vec3& p) { return glm::length(p) - 8; }, 900),
                     folder);
    const std::vector<DicomSeries> all = ListDicomSeries(folder);
    const DicomSeries& series = ChooseSeries(all, "", folder);
    CheckContains(series, MakeSegmentedJaw().CalcBounds(), folder);
    EXPECT_EQ(test::MessageOf([&] {
                CheckContains(series, {Vec3(-200), Vec3(-190)}, "ct");
              }),
              "ct: the bone is not inside this CT");
    return ReadDicomStudy(series);
  }
};

TEST_F(DicomSegments, AreThoseOfTheOtherFormat) {
  Write();
  const DicomStudy study = MakeStudy();
  EXPECT_EQ(study.instance_uids.size(), 9u);
  const Bone before = MakeSegmentedJaw(), after = MakeSegmentedJaw(6, 17);
  WriteSegments(after, &before, kVoxel_mm, folder_.file("cut.dcm"), &study);
  const Segmentation dicom = ReadDicomSegmentation(folder_.file("cut.dcm"));
  EXPECT_EQ(dicom.series_uid, study.series_uid);
  ASSERT_EQ(dicom.segments.size(), read_.segments.size());
  for (std::size_t i = 0; i < read_.segments.size(); ++i) {
    EXPECT_EQ(dicom.segments[i].name, read_.segments[i].name);
    EXPECT_EQ(dicom.segments[i].voxels, read_.segments[i].voxels);
  }
  // kerf imports the bone from it: codes and names agree.
  const SegmentationRoles roles = FindRoles(dicom, {});
  EXPECT_EQ(roles.meanings[0].role, SegmentRole::kMandible);
  EXPECT_EQ(FindCodedMeaning(Find(dicom, "tooth 36"))->fdi, 36);
  EXPECT_EQ(FindCodedMeaning(Find(dicom, "lesion"))->role, SegmentRole::kLesion);
  EXPECT_EQ(FindCodedMeaning(Find(dicom, "metal"))->role, SegmentRole::kMetal);
}

// The header of the CT states a wrong frame, which the user has corrected for the bone: the segments lie on the CT as
// other programs read it.
TEST_F(DicomSegments, LieInTheFrameOfTheFiles) {
  DicomStudy study = MakeStudy();
  const Bone bone = MakeSegmentedJaw();
  const auto write = [&](const glm::dmat3& file_from_lps) {
    study.file_from_lps = file_from_lps;
    WriteSegments(bone, nullptr, kVoxel_mm, folder_.file("bone.dcm"), &study);
    const Segmentation read = ReadDicomSegmentation(folder_.file("bone.dcm"));
    return SumPlaces(read, Find(read, "tooth 36"));
  };
  const Vec3 sum_W = write(glm::dmat3(1));
  ASSERT_GT(glm::length(sum_W), 100);
  for (const char* frame : {"RAS", "LAS", "ILP"}) {
    const glm::dmat3 lps_from_file = LpsFromFrame(frame);
    EXPECT_LT(glm::length(lps_from_file * write(glm::transpose(lps_from_file)) - sum_W), 0.02) << frame;
  }
}

TEST_F(DicomSegments, NeedOnePatientInAllSlices) {
  MakeStudy();
  const std::string folder = folder_.file("ct");
  const auto refusal = [&](int slices, const std::string& from, const std::string& to) {
    MakeStudy();
    for (const auto& file : std::filesystem::directory_iterator(folder)) {
      if (slices-- == 0) break;
      std::string changed = test::ReadBytes(file.path());
      changed.replace(changed.find(from), from.size(), to);
      test::WriteBytes(file.path(), changed);
    }
    return test::MessageOf([&] { ReadDicomStudy(ChooseSeries(ListDicomSeries(folder), "", folder)); });
  };
  EXPECT_THAT(refusal(4, "SECRET^NAME", "OTHERS^NAME"), HasSubstr("the CT slices are of 2 patients"));
  EXPECT_THAT(refusal(1, "UI\x6" + std::string(1, '\0') + "1.2.4", "UI\x6" + std::string(1, '\0') + "1.2.5"),
              HasSubstr("names another patient, study or frame of reference"));
}

TEST_F(DicomSegments, AreReadAlikeByPydicom) {
  if (std::system("/usr/bin/python3 -c 'import numpy, pydicom' >/dev/null 2>&1") != 0)
    GTEST_SKIP() << "python3-pydicom is not installed";
  Write();
  const DicomStudy study = MakeStudy();
  const Bone before = MakeSegmentedJaw(), after = MakeSegmentedJaw(6, 17);
  WriteSegments(after, &before, kVoxel_mm, folder_.file("cut.dcm"), &study);
  test::WriteBytes(folder_.file("r.py"), kReadDicom);
  ASSERT_TRUE(RunIn("/usr/bin/python3 r.py >out 2>&1", folder_)) << test::ReadBytes(folder_.file("out"));
  std::istringstream lines(test::ReadBytes(folder_.file("out")));
  std::string line;
  std::getline(lines, line);
  EXPECT_EQ(line, "1.2.840.10008.5.1.4.1.1.66.4 SEG SECRET^NAME 1.2.3 1.2.4");
  std::getline(lines, line);
  EXPECT_EQ(line, "1.2.3.4.5 9");
  for (const Segment& segment : read_.segments) {
    const Vec3 sum_W = SumPlaces(read_, segment);
    ASSERT_TRUE(std::getline(lines, line)) << segment.name;
    std::vector<std::string> fields;
    std::istringstream in(line);
    for (std::string field; std::getline(in, field, ';');) fields.push_back(field);
    ASSERT_EQ(fields.size(), 6u) << line;
    EXPECT_EQ(fields[0], segment.name);
    EXPECT_EQ(fields[2], std::to_string(segment.voxels));
    // The text of a position has 10 digits, so that the error of a sum is below its last printed digit.
    for (int axis = 0; axis < 3; ++axis) {
      EXPECT_NEAR(std::stod(fields[static_cast<std::size_t>(axis) + 3]), sum_W[axis], 0.02) << line;
    }
  }
}

}  // namespace
}  // namespace kerf
