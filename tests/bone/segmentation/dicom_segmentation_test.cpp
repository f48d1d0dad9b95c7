// DICOM segmentations, written by pydicom, which is independent of the library that reads them.
#include "bone/segmentation/dicom_segmentation.h"

#include <gmock/gmock.h>

#include <cstdlib>
#include <filesystem>

#include "label_files.h"
#include "support/message_of.h"
#include "test_paths.h"

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
from pydicom.encaps import encapsulate
from pydicom.pixel_data_handlers.rle_handler import rle_encode_frame
from pydicom.uid import (DeflatedExplicitVRLittleEndian, ExplicitVRBigEndian, ExplicitVRLittleEndian,
                         ImplicitVRLittleEndian, JPEGBaseline8Bit, RLELossless)
import zlib

def item(**values):
    data = Dataset()
    for key, value in values.items():
        setattr(data, key, value)
    return data

def code(value, meaning):
    return Sequence([item(CodeValue=value, CodingSchemeDesignator='SCT', CodeMeaning=meaning)])

how = sys.argv[1]
labels = how.startswith('labels')
fraction = how in ('fraction', 'zero', 'soft', 'rle')
big = how.endswith('big')
third = 700 if how.startswith('labels16') else 7
meta = FileMetaDataset()
meta.MediaStorageSOPClassUID = '1.2.840.10008.5.1.4.1.1.' + ('2' if how == 'ct' else '66.7' if labels else '66.4')
meta.MediaStorageSOPInstanceUID = '1.2.3'
meta.TransferSyntaxUID = {
    'implicit': ImplicitVRLittleEndian, 'deflated': DeflatedExplicitVRLittleEndian, 'rle': RLELossless,
    'labels_rle': RLELossless, 'frames': JPEGBaseline8Bit}.get(
        how, ExplicitVRBigEndian if big else ExplicitVRLittleEndian)
d = FileDataset('a.dcm', {}, file_meta=meta, preamble=b'\0' * 128)
d.is_little_endian, d.is_implicit_VR = not big, how == 'implicit'
d.SOPClassUID, d.SOPInstanceUID, d.Modality = meta.MediaStorageSOPClassUID, '1.2.3', 'SEG'
d.Rows, d.Columns, d.SamplesPerPixel, d.PhotometricInterpretation = 4, 5, 1, 'MONOCHROME2'
d.PixelRepresentation = 0
d.SegmentationType = 'FRACTIONAL' if fraction else 'LABELMAP' if labels else 'BINARY'
if how == 'tiled':
    d.DimensionOrganizationType = 'TILED_FULL'
d.FrameOfReferenceUID = '1.2.840.2'
d.ReferencedSeriesSequence = Sequence([item(SeriesInstanceUID='1.2.840.1')])
d.SegmentSequence = Sequence([
    item(SegmentNumber=n, SegmentLabel=label, SegmentedPropertyCategoryCodeSequence=code('123037004', 'Anatomical Structure'),
         SegmentedPropertyTypeCodeSequence=code(value, label))
    for n, label, value in ((1, 'Jaw', '91609006'), (1 if how == 'same' else 9 if how == 'orphan' else 2, 'Other', '70925003'), (third, 'T', '866006002'))] +
    ([item(SegmentNumber=0, SegmentLabel='Background')] if labels else []))
c, s = 0.8, 0.6
d.SharedFunctionalGroupsSequence = Sequence([item(
    PixelMeasuresSequence=Sequence([item(PixelSpacing=[-0.5 if how == 'negative' else 0.5, 0.4], SliceThickness=0.75 if how == 'second' else 2)]),
    PlaneOrientationSequence=Sequence([item(ImageOrientationPatient=[c, s, 0, -s, c, 0])]))])
planes, frames = [], []
for n, slices in ((1, (0, 1, 2)), (2, (2, 0, 1)), (7, (2,))):
    for k in slices:
        gap = 2 if how == 'uneven' and k == 2 else 0 if how == 'twice' and n == 1 and k == 1 else 1.5
        gap = 1.6 if how == 'rounded' and k == 2 else gap
        place = 2 * k if how == 'gaps' and n == 1 else k
        shear = 0.6 if how == 'sheared' else 0.3 * k if how == 'bent' else 0
        frames.append(item(
            SegmentIdentificationSequence=Sequence([item(ReferencedSegmentNumber=n)]),
            PlanePositionSequence=Sequence([item(
                ImagePositionPatient=[-10 + c * shear * k, 20 + s * shear * k, 30 + gap * place])])))
        plane = numpy.zeros((4, 5), numpy.uint8)
        if n == 1:
            plane[0:2, k:k + 2] = 1
        elif n == 2:
            plane[1:3, 1:4] = 1
        else:
            plane[3, 4] = 1
        planes.append(plane)
if labels:
    order = (1, 2, 0)
    maps = [numpy.zeros((4, 5), numpy.uint16 if third > 255 else numpy.uint8) for _ in range(3)]
    for k in range(3):
        maps[k][planes[k] > 0] = 1
        maps[k][planes[(4, 5, 3)[k]] > 0] = 2
    maps[2][planes[6] > 0] = third
    if how == 'labels_other':
        maps[0][3, 0] = 99
    frames = [item(PlanePositionSequence=frames[k].PlanePositionSequence) for k in order]
    planes = [maps[k] for k in order]
if how == 'one':
    d.SharedFunctionalGroupsSequence[0].PlanePositionSequence = frames[0].PlanePositionSequence
    d.SharedFunctionalGroupsSequence[0].SegmentIdentificationSequence = frames[0].SegmentIdentificationSequence
    frames, planes = [Dataset()], planes[:1]
d.PerFrameFunctionalGroupsSequence = Sequence(frames)
d.NumberOfFrames = len(frames) - (how == 'count')
bits = numpy.concatenate([p.ravel() for p in planes])
if fraction:
    d.BitsAllocated, d.BitsStored, d.HighBit = 8, 8, 7
    d.MaximumFractionalValue = 0 if how == 'zero' else 200
    raw = bits.astype(numpy.uint8) * (60 if how == 'soft' else 100)
    raw[:4] *= 3 if how == 'soft' else 1
    data = raw.tobytes()
    parts = [rle_encode_frame(part.reshape(4, 5)) for part in raw.reshape(-1, 20)]
elif labels:
    d.BitsAllocated = d.BitsStored = 8 * bits.dtype.itemsize
    d.HighBit = d.BitsAllocated - 1
    data = bits.astype(bits.dtype.newbyteorder('>' if big else '<')).tobytes()
    parts = [rle_encode_frame(plane) for plane in planes]
else:
    d.BitsAllocated, d.BitsStored, d.HighBit = 1, 1, 0
    data = numpy.packbits(bits, bitorder='little').tobytes()
    parts = []
    for plane in planes:
        deflate = zlib.compressobj(wbits=-15)
        parts.append(deflate.compress(numpy.packbits(plane.ravel(), bitorder='little').tobytes()) + deflate.flush())
if how == 'short':
    data = data[:6]
packed = how in ('rle', 'labels_rle', 'frames')
d.PixelData = encapsulate([part + b'\0' * (len(part) % 2) for part in parts]) if packed else data + b'\0' * (len(data) % 2)
d['PixelData'].is_undefined_length = packed
d['PixelData'].VR = 'OW' if third > 255 else 'OB'
d.save_as('a.dcm', write_like_original=False)
if how == 'frames':  # each deflated, which pydicom does not know yet
    file = open('a.dcm', 'rb').read()
    open('a.dcm', 'wb').write(file.replace(b'1.2.840.10008.1.2.4.50', b'1.2.840.10008.1.2.8.1\0'))
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
  for (const char* how : {"binary", "implicit", "fraction", "big", "deflated", "rle", "frames"}) {
    SCOPED_TRACE(how);
    const Segmentation read = ReadDicomSegmentation(Write(how));
    EXPECT_TRUE(read.named);
    EXPECT_EQ(read.series_uid, "1.2.840.1");
    EXPECT_EQ(read.frame_uid, "1.2.840.2");
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

TEST_F(DicomSegmentation, OfTheLabelMapClassHasOneLayer) {
  for (const char* how : {"labels", "labels_rle", "labels16", "labels16_big", "labels_other"}) {
    SCOPED_TRACE(how);
    const Segmentation read = ReadDicomSegmentation(Write(how));
    ASSERT_EQ(read.layers.size(), 1u);
    ASSERT_EQ(read.segments.size(), 3u) << "the background is none";
    EXPECT_EQ(read.segments[0].voxels, 7u) << "12 less 5 that are of the second segment";
    EXPECT_EQ(read.segments[1].voxels, 18u);
    EXPECT_EQ(read.segments[2].voxels, 1u);
    EXPECT_EQ(read.segments[2].label, std::string(how).find("16") != std::string::npos ? 700 : 7);
    EXPECT_EQ(read.lattice.size, (std::array<int, 3>{5, 4, 3}));
    EXPECT_EQ(read.layers[0][read.lattice.Index(4, 3, 2)], read.segments[2].label);
    EXPECT_EQ(read.layers[0][read.lattice.Index(1, 0, 1)], 1);
    EXPECT_LT(glm::length(read.lattice.origin_W - Vec3(-10, 20, 30)), 1e-9);
    EXPECT_EQ(read.warnings.empty(), std::string(how) != "labels_other");
  }
  EXPECT_THAT(ReadDicomSegmentation(Write("labels_other")).warnings, ElementsAre(HasSubstr("such as 99")));
}

TEST_F(DicomSegmentation, CountsFractionsFromTheThresholdOn) {
  const std::string path =
      Write("soft");  // 180 of 200 in the first 4 pixels, of which 2 are in the segment; 60 in the others
  EXPECT_EQ(ReadDicomSegmentation(path, 0.5).segments[0].voxels, 2u);
  EXPECT_EQ(ReadDicomSegmentation(path, 0.3).segments[0].voxels, 12u);
  EXPECT_EQ(ReadDicomSegmentation(path, 0.31).segments[0].voxels, 2u);
  EXPECT_EQ(ReadDicomSegmentation(path, 0).segments[0].voxels, 12u) << "0 is never in a segment";
  EXPECT_THAT(ReadDicomSegmentation(path, 0.3).warnings, ElementsAre(HasSubstr("those from 0.3 of its range on")));
}

TEST_F(DicomSegmentation, ReadsSlicesAsScannersAndProgramsPlaceThem) {
  // Rows are along (0.8, 0.6, 0), to which the slices of a tilted gantry are shifted by 0.6 mm for each 1.5 mm.
  const Segmentation sheared = ReadDicomSegmentation(Write("sheared"));
  EXPECT_EQ(sheared.lattice.size, (std::array<int, 3>{5, 4, 3}));
  EXPECT_LT(glm::length(sheared.lattice.WorldFromVoxel({0, 0, 2}) - Vec3(-10 + 0.96, 20 + 0.72, 33)), 1e-9);
  EXPECT_NEAR(sheared.segments[2].volume_mm3, 0.5 * 0.4 * 1.5, 1e-9);
  EXPECT_THAT(MessageOf([&] { ReadDicomSegmentation(Write("bent")); }), HasSubstr("are shifted sideways unevenly"));
  // The slices are 0.75 mm thick, but only every second has frames.
  const Segmentation second = ReadDicomSegmentation(Write("second"));
  EXPECT_EQ(second.lattice.size[2], 3);
  EXPECT_THAT(second.warnings, ElementsAre(HasSubstr("frames only at every 1.5 mm, but states slices of 0.75 mm")));
  // Only one of the segments has frames at every second slice: 0, 2 and 4.
  const Segmentation gaps = ReadDicomSegmentation(Write("gaps"));
  EXPECT_EQ(gaps.lattice.size[2], 5);
  EXPECT_EQ(gaps.segments[0].voxels, 4u * 5);
  EXPECT_EQ(gaps.layers[0][gaps.lattice.Index(1, 0, 3)], 1) << "the slice after that of frame 1";
  EXPECT_THAT(gaps.warnings, ElementsAre(HasSubstr("'Jaw' has a frame at every 2 slices only")));
  // Heights of 0, 1.5 and 3.2 mm.
  const Segmentation rounded = ReadDicomSegmentation(Write("rounded"));
  EXPECT_NEAR(rounded.lattice.spacing_mm.z, 1.6, 1e-9);
  EXPECT_THAT(rounded.warnings, ElementsAre(HasSubstr("up to 0.1 mm from an even spacing of 1.6 mm")));
  const Segmentation one = ReadDicomSegmentation(Write("one"));
  EXPECT_EQ(one.lattice.size, (std::array<int, 3>{5, 4, 1}));
  EXPECT_EQ(one.segments[0].voxels, 4u);
  EXPECT_EQ(one.segments[1].voxels, 0u) << "an empty segment";
  EXPECT_NEAR(one.lattice.spacing_mm.z, 2, 1e-9);
}

TEST_F(DicomSegmentation, RefusesFaultsWithOneSentence) {
  EXPECT_THAT(MessageOf([&] { ReadDicomSegmentation(Write("tiled")); }), HasSubstr("of a microscope's slide"));
  const std::string deflated = Write("deflated");
  test::WriteBytes(deflated, test::ReadBytes(deflated).substr(0, 600));
  EXPECT_THAT(MessageOf([&] { ReadDicomSegmentation(deflated); }), HasSubstr("the file is cut off: its deflated data"));
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
  for (const char* how : {"binary", "implicit", "fraction", "big", "labels16"}) {
    const std::string all = test::ReadBytes(Write(how));
    for (std::size_t cut = 1; cut < 18; ++cut) {
      test::WriteBytes(path, all.substr(0, all.size() - cut));
      EXPECT_NE(MessageOf([&] { ReadDicomSegmentation(path); }), "") << how << " without " << cut << " bytes";
    }
  }
}

// Files of highdicom and of 3D Slicer, with the numbers that highdicom, pydicom and teem give.
TEST(RealSegmentations, AreReadOrRefusedForTheTrueReason) {
  const std::string folder = KERF_TEST_DATA "/segmentations_public/";
  if (!std::filesystem::exists(folder)) GTEST_SKIP() << "needs the segmentations in ../shared/data";
  const auto read_dicom = [&folder](const char* name) { return ReadDicomSegmentation(folder + name); };
  for (const char* name : {"binary", "binary_fractional"}) {
    const Segmentation read = read_dicom(fmt::format("highdicom_seg_image_ct_{}.dcm", name).c_str());
    EXPECT_EQ(read.lattice.size, (std::array<int, 3>{16, 16, 3}));
    EXPECT_LT(glm::length(read.lattice.origin_W - Vec3(-125, -128.100006, 103.019997)), 1e-6);
    EXPECT_TRUE(read.warnings.empty()) << read.warnings[0];
    ASSERT_EQ(read.segments.size(), 1u);
    EXPECT_EQ(read.segments[0].voxels, 638u);
  }
  EXPECT_EQ(read_dicom("highdicom_seg_image_ct_true_fractional.dcm").segments[0].voxels, 638u);
  EXPECT_EQ(read_dicom("highdicom_seg_image_ct_binary_overlap.dcm").segments[1].layer, 1);
  const Segmentation single = read_dicom("highdicom_seg_image_ct_binary_single_frame.dcm");
  EXPECT_EQ(single.lattice.size, (std::array<int, 3>{128, 128, 1}));
  EXPECT_EQ(single.segments[0].voxels, 1832u);
  EXPECT_THAT(MessageOf([&] { read_dicom("highdicom_seg_image_sm_control_labelmap.dcm"); }),
              HasSubstr("of a microscope's slide"));
  EXPECT_THAT(MessageOf([&] { read_dicom("highdicom_ct_image.dcm"); }), HasSubstr("but not a segmentation"));
  const Segmentation slicer = ReadSegmentation(folder + "slicer_Segmentation.seg.nrrd");
  EXPECT_EQ(slicer.segments.size(), 7u);
  EXPECT_LT(slicer.lattice.axes_W[0].x, 0) << "its directions are negative";
  const Segmentation overlapping = ReadSegmentation(folder + "slicer_SegmentationOverlapping.seg.nrrd");
  ASSERT_EQ(overlapping.segments.size(), 8u);
  EXPECT_EQ(overlapping.segments[7].name, "overlapping sphere");
  EXPECT_EQ(overlapping.segments[7].layer, 1);
  EXPECT_EQ(overlapping.segments[0].voxels, slicer.segments[0].voxels);
}

}  // namespace
}  // namespace kerf
