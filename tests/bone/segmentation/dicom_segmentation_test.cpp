// DICOM segmentations, written by pydicom, which is independent of the library that reads them.
#include "bone/segmentation/dicom_segmentation.h"

#include <gmock/gmock.h>

#include <cstdlib>

#include "label_files.h"
#include "support/message_of.h"

namespace kerf {
namespace {

using test::Folder;
using test::MessageOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

// Two segments of 3 slices of 5 x 4 pixels that overlap in one pixel; the third, a tooth, has one slice, the topmost.
constexpr const char* kWrite = R"(
import sys
import numpy
from pydicom.dataset import Dataset, FileDataset, FileMetaDataset
from pydicom.sequence import Sequence
from pydicom.uid import ExplicitVRLittleEndian, ImplicitVRLittleEndian

def item(**values):
    data = Dataset()
    for key, value in values.items():
        setattr(data, key, value)
    return data

def code(value, meaning):
    return Sequence([item(CodeValue=value, CodingSchemeDesignator='SCT', CodeMeaning=meaning)])

how = sys.argv[1]
meta = FileMetaDataset()
meta.MediaStorageSOPClassUID = '1.2.840.10008.5.1.4.1.1.' + ('2' if how == 'ct' else '66.4')
meta.MediaStorageSOPInstanceUID = '1.2.3'
meta.TransferSyntaxUID = ImplicitVRLittleEndian if how == 'implicit' else ExplicitVRLittleEndian
d = FileDataset('a.dcm', {}, file_meta=meta, preamble=b'\0' * 128)
d.is_little_endian, d.is_implicit_VR = True, how == 'implicit'
d.SOPClassUID, d.SOPInstanceUID, d.Modality = meta.MediaStorageSOPClassUID, '1.2.3', 'SEG'
d.Rows, d.Columns, d.SamplesPerPixel, d.PhotometricInterpretation = 4, 5, 1, 'MONOCHROME2'
d.PixelRepresentation = 0
d.SegmentationType = 'FRACTIONAL' if how in ('fraction', 'zero') else 'BINARY'
d.ReferencedSeriesSequence = Sequence([item(SeriesInstanceUID='1.2.840.1')])
d.SegmentSequence = Sequence([
    item(SegmentNumber=n, SegmentLabel=label, SegmentedPropertyCategoryCodeSequence=code('123037004', 'Anatomical Structure'),
         SegmentedPropertyTypeCodeSequence=code(value, label))
    for n, label, value in ((1, 'Jaw', '91609006'), (1 if how == 'same' else 9 if how == 'orphan' else 2, 'Other', '70925003'), (7, 'T', '866006002'))])
c, s = 0.8, 0.6
d.SharedFunctionalGroupsSequence = Sequence([item(
    PixelMeasuresSequence=Sequence([item(PixelSpacing=[-0.5 if how == 'negative' else 0.5, 0.4], SliceThickness=2)]),
    PlaneOrientationSequence=Sequence([item(ImageOrientationPatient=[c, s, 0, -s, c, 0])]))])
planes, frames = [], []
for n, slices in ((1, (0, 1, 2)), (2, (2, 0, 1)), (7, (2,))):
    for k in slices:
        gap = 1.7 if how == 'uneven' and k == 2 else 0 if how == 'twice' and n == 1 and k == 1 else 1.5
        frames.append(item(
            SegmentIdentificationSequence=Sequence([item(ReferencedSegmentNumber=n)]),
            PlanePositionSequence=Sequence([item(ImagePositionPatient=[-10, 20, 30 + gap * k])])))
        plane = numpy.zeros((4, 5), numpy.uint8)
        if n == 1:
            plane[0:2, k:k + 2] = 1
        elif n == 2:
            plane[1:3, 1:4] = 1
        else:
            plane[3, 4] = 1
        planes.append(plane)
d.PerFrameFunctionalGroupsSequence = Sequence(frames)
d.NumberOfFrames = len(frames) - (how == 'count')
bits = numpy.concatenate([p.ravel() for p in planes])
if how in ('fraction', 'zero'):
    d.BitsAllocated, d.BitsStored, d.HighBit = 8, 8, 7
    d.MaximumFractionalValue = 200 if how == 'fraction' else 0
    data = (bits * 100).astype(numpy.uint8).tobytes()
else:
    d.BitsAllocated, d.BitsStored, d.HighBit = 1, 1, 0
    data = numpy.packbits(bits, bitorder='little').tobytes()
if how == 'short':
    data = data[:6]
d.PixelData = data + b'\0' * (len(data) % 2)
d['PixelData'].VR = 'OB'
d.save_as('a.dcm', write_like_original=False)
)";

class DicomSegmentation : public ::testing::Test {
 protected:
  void SetUp() override {
    if (std::system("/usr/bin/python3 -c 'import pydicom' >/dev/null 2>&1") != 0)
      GTEST_SKIP() << "python3-pydicom is not installed";
    test::WriteBytes(folder_.file("w.py"), kWrite);
  }
  std::string Write(const char* how) const {
    const std::string command = fmt::format("cd '{}' && /usr/bin/python3 w.py {} >log 2>&1", folder_.path(), how);
    EXPECT_EQ(std::system(command.c_str()), 0) << test::ReadBytes(folder_.file("log"));
    return folder_.file("a.dcm");
  }
  const Folder folder_;
};

TEST_F(DicomSegmentation, GivesNamesCodesPlacesAndLayers) {
  for (const char* how : {"binary", "implicit", "fraction"}) {
    const Segmentation read = ReadDicomSegmentation(Write(how));
    EXPECT_TRUE(read.named);
    EXPECT_EQ(read.series_uid, "1.2.840.1");
    ASSERT_EQ(read.segments.size(), 3u) << how;
    EXPECT_EQ(read.segments[0].name, "Jaw");
    EXPECT_EQ(read.segments[0].category, "123037004");
    EXPECT_THAT(read.segments[0].codes, ElementsAre("91609006"));
    EXPECT_EQ(read.segments[0].voxels, 12u);
    EXPECT_EQ(read.segments[1].voxels, 18u);
    EXPECT_EQ(read.segments[1].layer, 1) << "the second segment overlaps the first";
    EXPECT_EQ(read.segments[2].label, 7);
    EXPECT_EQ(read.segments[2].layer, 0);
    EXPECT_NEAR(read.segments[2].volume_mm3, 0.5 * 0.4 * 1.5, 1e-9);
    EXPECT_EQ(read.lattice.size, (std::array<int, 3>{5, 4, 3}));
    // The tooth is in column 4 (0.4 mm along the row), row 3 (0.5 mm) and slice 2.
    EXPECT_EQ(read.layers[0][read.lattice.Index(4, 3, 2)], 7);
    const Vec3 p_W = Vec3(-10, 20, 33) + 1.6 * Vec3(0.8, 0.6, 0) + 1.5 * Vec3(-0.6, 0.8, 0);
    EXPECT_LT(glm::length(read.lattice.WorldFromVoxel({4, 3, 2}) - p_W), 1e-9);
    EXPECT_EQ(read.layers[0][read.lattice.Index(1, 0, 1)], 1);
    EXPECT_EQ(read.layers[1][read.lattice.Index(1, 1, 1)], 2);
  }
}

TEST_F(DicomSegmentation, RefusesFaultsWithOneSentence) {
  EXPECT_THAT(MessageOf([&] { ReadDicomSegmentation(Write("uneven")); }), HasSubstr("are not evenly spaced"));
  EXPECT_THAT(MessageOf([&] { ReadDicomSegmentation(Write("short")); }),
              HasSubstr("its 7 frames of 5 x 4 pixels need 18 bytes, but it has 6"));
  EXPECT_THAT(MessageOf([&] { ReadDicomSegmentation(Write("twice")); }),
              HasSubstr("two frames of segment 1 have the same position"));
  EXPECT_THAT(MessageOf([&] { ReadDicomSegmentation(Write("count")); }), HasSubstr("states 6 frames, but describes 7"));
  EXPECT_THAT(MessageOf([&] { ReadDicomSegmentation(Write("zero")); }),
              HasSubstr("maximum fractional value is missing or 0"));
  EXPECT_THAT(MessageOf([&] { ReadDicomSegmentation(Write("same")); }),
              HasSubstr("more than one segment has the number 1"));
  EXPECT_THAT(MessageOf([&] { ReadDicomSegmentation(Write("orphan")); }),
              HasSubstr("frame 4 belongs to segment 2, which the file does not describe"));
  EXPECT_THAT(MessageOf([&] { ReadDicomSegmentation(Write("ct")); }),
              HasSubstr("a DICOM file, but not a segmentation"));
  EXPECT_THAT(MessageOf([&] { ReadDicomSegmentation(Write("negative")); }),
              HasSubstr("distances between the segmentation's pixels are -0.5 and 0.4 mm"));
  const std::string path = Write("binary");
  const std::string bytes = test::ReadBytes(path);
  for (std::size_t length = 140; length + 1 < bytes.size(); length += 97) {
    test::WriteBytes(path, bytes.substr(0, length));
    const std::string said = MessageOf([&] { ReadDicomSegmentation(path); });
    EXPECT_FALSE(said.empty()) << length;
    EXPECT_EQ(said.find('\n'), std::string::npos) << said;
  }
  for (const char* how : {"binary", "implicit", "fraction"}) {
    const std::string all = test::ReadBytes(Write(how));
    for (std::size_t cut = 1; cut < 18; ++cut) {
      test::WriteBytes(path, all.substr(0, all.size() - cut));
      EXPECT_NE(MessageOf([&] { ReadDicomSegmentation(path); }), "") << how << " without " << cut << " bytes";
    }
  }
}

}  // namespace
}  // namespace kerf
