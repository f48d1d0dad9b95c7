// Reading of scans: the value and the position of every voxel, and an error message for files that are not a CT.
#include <gmock/gmock.h>

#include <filesystem>
#include <glm/gtc/quaternion.hpp>

#include "bone/import/dicom.h"
#include "bone/import/image_file.h"
#include "bone/import/import.h"
#include "ct_files.h"

// GDCM 3.0 itself leaks its decoder if a JPEG is broken. The leak sanitizer calls this function, which is otherwise
// unused. NOLINTBEGIN(bugprone-reserved-identifier): the sanitizer's name
extern "C" const char* __lsan_default_suppressions();
extern "C" const char* __lsan_default_suppressions() {
  return "leak:gdcm::ImageChangeTransferSyntax::Change";
}
// NOLINTEND(bugprone-reserved-identifier)

namespace kerf {
namespace {

using test::Folder;
using test::MessageOf;
using test::ReadBytes;
using test::SliceSpec;
using test::WriteBytes;
using ::testing::HasSubstr;

// Returns a CT that is rotated about a skew axis and has three different spacings, so that any swapped axis or sign is
// noticed.
Volume SkewCt(const std::array<int, 3>& size = {9, 8, 7}) {
  const glm::dmat3 axes = glm::mat3_cast(glm::angleAxis(0.4, glm::normalize(Vec3(1, 2, -0.5))));
  Volume ct = test::MakeCt(size, {0.75, 0.5, 1.25}, {-31.5, 12.25, 140}, axes, test::Ball({0, 0, 0}, 1));
  for (std::size_t v = 0; v < ct.hu.size(); ++v)
    ct.hu[v] = static_cast<std::int16_t>(static_cast<int>(v * 7 % 3000) - 1000);
  return ct;
}

void ExpectSame(const Volume& a, const Volume& b, double tolerance_mm) {
  ASSERT_EQ(a.size, b.size);
  EXPECT_EQ(a.hu, b.hu);
  for (const Vec3& p : {Vec3(0, 0, 0), Vec3(8, 0, 0), Vec3(0, 7, 0), Vec3(0, 0, 6), Vec3(8, 7, 6)}) {
    EXPECT_LT(glm::length(a.WorldFromVoxel(p) - b.WorldFromVoxel(p)), tolerance_mm);
  }
}

Volume ReadFolder(const std::string& folder, const std::string& uid = "") {
  return ReadDicomSeries(ChooseSeries(ListDicomSeries(folder), uid, folder), {});
}

TEST(ReadDicom, SlicesAreOrderedByPositionAndLieWhereTheHeaderSays) {
  const Folder folder;
  const Volume ct = SkewCt();
  test::WriteDicom(ct, folder.path());
  // 1e-6 mm is sufficient, because positions are written with eight decimals.
  ExpectSame(ReadFolder(folder.path()), ct, 1e-6);
}

TEST(ReadDicom, RescaleSlopeAndInterceptGiveHu) {
  const Folder folder;
  Volume ct = SkewCt();
  for (auto& hu : ct.hu) hu = static_cast<std::int16_t>(hu / 2 * 2);
  SliceSpec spec;
  spec.slope = 2;
  spec.intercept = -1000;
  test::WriteDicom(ct, folder.path(), spec);
  EXPECT_EQ(ReadFolder(folder.path()).hu, ct.hu);
}

TEST(ReadDicom, ATiltedGantryShearsTheLattice) {
  const Folder folder;
  Volume ct = SkewCt();
  ct.axes_W = glm::dmat3(1);
  ct.axes_W[2] = glm::normalize(Vec3(0, 0.3, 1));
  test::WriteDicom(ct, folder.path());
  ExpectSame(ReadFolder(folder.path()), ct, 1e-6);
}

TEST(ReadDicom, RunLengthEncodedSlicesAreUnpacked) {
  const Folder folder;
  const Volume ct = SkewCt();
  for (int k = 0; k < ct.size[2]; ++k) {
    WriteBytes(folder.file(fmt::format("{}.dcm", 50 - k)), test::DicomSlice(ct, k, test::RunLengthSpec(ct, k)));
  }
  ExpectSame(ReadFolder(folder.path()), ct, 1e-6);
}

TEST(ReadDicom, ListNamesEverySeriesAndChoosesTheOnlyCt) {
  const Folder folder;
  const Volume ct = SkewCt();
  test::WriteDicom(ct, folder.path());
  SliceSpec mr;
  mr.series_uid = "1.2.99.7";
  mr.modality = "MR";
  mr.description = "T1";
  test::WriteDicom(SkewCt({9, 8, 12}), folder.path(), mr);
  const auto all = ListDicomSeries(folder.path());
  ASSERT_EQ(all.size(), 2u);
  EXPECT_EQ(all[0].uid, "1.2.99.7");  // the largest series first
  EXPECT_EQ(all[0].modality, "MR");
  EXPECT_EQ(all[0].description, "T1");
  EXPECT_EQ(all[1].slices.size(), 7u);
  EXPECT_NEAR(all[1].gap_mm, 1.25, 1e-6);
  EXPECT_EQ(ReadFolder(folder.path()).hu, ct.hu);
  EXPECT_THAT(MessageOf([&] { ReadFolder(folder.path(), "99.7"); }), HasSubstr("the modality is MR, not CT"));
  EXPECT_THAT(MessageOf([&] { ReadFolder(folder.path(), "1.2.3.777"); }), HasSubstr("no series match '1.2.3.777'"));
}

TEST(ReadDicom, SeveralCtSeriesAreRefusedUntilOneIsChosen) {
  const Folder folder;
  const Volume ct = SkewCt();
  test::WriteDicom(ct, folder.path());
  SliceSpec other;
  other.series_uid = "1.2.99.8";
  test::WriteDicom(SkewCt({9, 8, 5}), folder.path(), other);
  EXPECT_THAT(MessageOf([&] { ReadFolder(folder.path()); }),
              HasSubstr("the folder contains 2 CT series; choose one with --series UID"));
  EXPECT_THAT(MessageOf([&] { ReadFolder(folder.path()); }), testing::Not(HasSubstr("damaged file")));
  EXPECT_EQ(ReadFolder(folder.path(), "1.2.3.4.5").size[2], 7);
  EXPECT_EQ(ReadFolder(folder.path(), "99.8").size[2], 5);
}

TEST(ReadDicom, ASliceWithAnotherSeriesUidIsLeftOutAndNamed) {
  const Folder folder;
  const Volume ct = SkewCt();
  test::WriteDicom(ct, folder.path());
  SliceSpec other;
  other.series_uid = "1.2.3.4.6";
  WriteBytes(folder.file("stray.dcm"), test::DicomSlice(ct, 3, other));
  const DicomSeries chosen = ChooseSeries(ListDicomSeries(folder.path()), "", folder.path());
  ExpectSame(ReadDicomSeries(chosen, {}), ct, 1e-6);
  ASSERT_EQ(chosen.warnings.size(), 1u);
  EXPECT_THAT(chosen.warnings[0], HasSubstr("the folder contains 2 CT series"));
  EXPECT_THAT(chosen.warnings[0],
              testing::EndsWith("; one of them has 1 slice and may be a scout view or a damaged file: stray.dcm"));
}

// One slice of a good series is damaged, in a different way each time.
class SpoiltSeries : public ::testing::Test {
 protected:
  std::string Message(int k, const std::string& bytes) {
    const Folder folder;
    test::WriteDicom(ct_, folder.path());
    for (const auto& entry : std::filesystem::directory_iterator(folder.path())) {
      if (ReadBytes(entry.path()) == test::DicomSlice(ct_, k, {})) {
        std::filesystem::remove(entry.path());
        break;
      }
    }
    if (!bytes.empty()) WriteBytes(folder.file("spoilt.dcm"), bytes);
    return MessageOf([&] { ReadFolder(folder.path()); });
  }
  const Volume ct_ = SkewCt();
};

TEST_F(SpoiltSeries, MissingSliceIsNamedWithItsPlace) {
  const std::string message = Message(3, "");
  EXPECT_THAT(message, HasSubstr("1 slice is missing between"));
  EXPECT_THAT(message, HasSubstr("slices elsewhere are 1.25 mm apart"));
}

TEST_F(SpoiltSeries, UnequalGapIsRefused) {
  Volume moved = ct_;
  moved.origin_W += 0.4 * ct_.axes_W[2];
  EXPECT_THAT(Message(3, test::DicomSlice(moved, 3, {})), HasSubstr("the slices are unequally spaced: "));
}

TEST_F(SpoiltSeries, DoubledSliceIsRefused) {
  Volume moved = ct_;
  moved.origin_W -= ct_.spacing_mm.z * ct_.axes_W[2];
  EXPECT_THAT(Message(3, test::DicomSlice(moved, 3, {})), HasSubstr("lie at the same place"));
}

TEST_F(SpoiltSeries, SliceOfAnotherSizeOrOrientationIsRefused) {
  EXPECT_THAT(Message(3, test::DicomSlice(SkewCt({10, 8, 7}), 3, {})), HasSubstr("1 slice is missing between"));
  Volume turned = ct_;
  std::swap(turned.axes_W[0], turned.axes_W[1]);
  EXPECT_THAT(Message(3, test::DicomSlice(turned, 3, {})), HasSubstr("1 slice is missing between"));
}

TEST_F(SpoiltSeries, TruncatedSliceIsRefusedEvenByOneByte) {
  const std::string whole = test::DicomSlice(ct_, 3, {});
  for (const std::size_t cut : {std::size_t{1}, std::size_t{20}, whole.size() / 5}) {
    const std::string message = Message(3, whole.substr(0, whole.size() - cut));
    EXPECT_THAT(message, HasSubstr("spoilt.dcm")) << cut;
    EXPECT_THAT(message, HasSubstr("cut off")) << cut;
  }
}

// The series is whole without the file.
TEST_F(SpoiltSeries, AFileCutOffWithinItsHeaderIsLeftOutAndNamed) {
  const std::string whole = test::DicomSlice(ct_, 3, {});
  ASSERT_GT(whole.size(), 700u);
  const Folder folder;
  const Volume ct = SkewCt();
  test::WriteDicom(ct, folder.path());
  for (std::size_t length = 0; length <= 700; length += length < 150 ? 50 : 7) {
    WriteBytes(folder.file("spoilt.dcm"), whole.substr(0, length));
    const DicomSeries chosen = ChooseSeries(ListDicomSeries(folder.path()), "", folder.path());
    EXPECT_EQ(chosen.slices.size(), 7u) << length;
    EXPECT_THAT(chosen.warnings, testing::ElementsAre(testing::StartsWith("1 file was left out: spoilt.dcm (")))
        << length;
  }
  const std::string within = Message(3, whole.substr(0, 200));
  EXPECT_THAT(within, HasSubstr("spoilt.dcm: the DICOM header can't be read: the meta information is "));
  EXPECT_THAT(within, HasSubstr(" bytes long but only 56 are left; the file is damaged or cut off"));
  EXPECT_THAT(Message(3, whole.substr(0, 138)),
              HasSubstr("the DICOM header can't be read: the file ends within it, after 138 bytes"));
}

TEST_F(SpoiltSeries, SliceCutOffBetweenElementsIsRefused) {
  const std::string whole = test::DicomSlice(ct_, 3, {});
  const std::string modality("\x08\x00\x60\x00", 4);
  EXPECT_THAT(Message(3, whole.substr(0, whole.find(modality))),
              HasSubstr("spoilt.dcm: a CT slice without rows and columns; the file is damaged or cut off"));
}

TEST_F(SpoiltSeries, ElementLongerThanTheFileIsRefused) {
  const std::string whole = test::DicomSlice(ct_, 3, {});
  const auto spoil = [&](const std::string& tag, std::size_t skip, const std::string& with) {
    std::string bytes = whole;
    return bytes.replace(bytes.find(tag) + skip, with.size(), with);
  };
  const std::string modality("\x08\x00\x60\x00", 4);
  const std::string meta_length("\x02\x00\x00\x00", 4);
  const std::string meta_uid("\x02\x00\x03\x00", 4);
  EXPECT_THAT(
      Message(3, spoil(modality, 6, "\xff\x7f")),
      HasSubstr("spoilt.dcm: the DICOM header can't be read: element (0008,0060) is 32767 bytes long but only "));
  // A damaged type and length can declare a text of 4 GB; none of it is allocated.
  EXPECT_THAT(Message(3, spoil(modality, 4, std::string("UT\0\0\xf0\xff\xff\xff", 8))),
              HasSubstr("element (0008,0060) is 4294967280 bytes long but only "));
  EXPECT_THAT(Message(3, spoil(meta_uid, 6, "\xff\x7f")), HasSubstr("element (0002,0003) is 32767 bytes"));
  EXPECT_THAT(Message(3, spoil(meta_length, 8, "\xff\xff\xff\x7f")),
              HasSubstr("the meta information is 2147483647 bytes long but only "));
  EXPECT_THAT(Message(3, spoil(meta_uid, 4, "??")),
              HasSubstr("element (0002,0003) of the meta information has no valid type"));
  // The damaged element is inside a sequence and an item that end with delimiters.
  const std::string within(
      "\x08\x00\x32\x10SQ\0\0\xff\xff\xff\xff\xfe\xff\x00\xe0\xff\xff\xff\xff\x08\x00\x04\x01LO\x00\x70", 28);
  std::string nested = whole;
  nested.insert(nested.find(std::string("\x10\x00\x10\x00", 4)), within);
  EXPECT_THAT(Message(3, nested), HasSubstr("element (0008,0104) is 28672 bytes long but only "));
}

TEST_F(SpoiltSeries, SequencesOfDefinedAndUndefinedLengthAreAccepted) {
  const std::string inner("\x08\x00\x04\x01LO\x02\x00hi", 10);
  const std::string open = std::string("\x08\x00\x32\x10SQ\0\0\xff\xff\xff\xff\xfe\xff\x00\xe0\xff\xff\xff\xff", 20) +
                           inner + std::string("\xfe\xff\x0d\xe0\0\0\0\0\xfe\xff\xdd\xe0\0\0\0\0", 16);
  const std::string closed = std::string("\x08\x00\x32\x10SQ\0\0\x12\0\0\0\xfe\xff\x00\xe0\x0a\0\0\0", 20) + inner;
  for (const std::string& sequence : {open, closed}) {
    std::string slice = test::DicomSlice(ct_, 3, {});
    slice.insert(slice.find(std::string("\x10\x00\x10\x00", 4)), sequence);
    EXPECT_EQ(Message(3, slice), "");
  }
}

TEST_F(SpoiltSeries, TextFileNamedDcmIsRefused) {
  EXPECT_THAT(Message(3, "This is no image.\n"), HasSubstr("spoilt.dcm: not a DICOM file despite its name"));
}

TEST_F(SpoiltSeries, ColourIsRefused) {
  SliceSpec rgb;
  rgb.samples = 3;
  EXPECT_THAT(Message(3, test::DicomSlice(ct_, 3, rgb)), HasSubstr("1 slice is missing between"));
}

TEST_F(SpoiltSeries, InvertedDisplayIsRefused) {
  SliceSpec inverted;
  inverted.photometric = "MONOCHROME1";
  EXPECT_THAT(Message(3, test::DicomSlice(ct_, 3, inverted)),
              HasSubstr("is stored for inverted display (MONOCHROME1)"));
}

TEST_F(SpoiltSeries, PixelsThatCannotBeUnpackedAreRefusedByTransferSyntax) {
  SliceSpec jpeg;
  jpeg.transfer_syntax = "1.2.840.10008.1.2.4.70";
  jpeg.encapsulated = true;
  jpeg.pixels = "these are not the bytes of a JPEG";
  const std::string message = Message(3, test::DicomSlice(ct_, 3, jpeg));
  EXPECT_THAT(message, HasSubstr("spoilt.dcm: the transfer syntax 1.2.840.10008.1.2.4.70 can't be unpacked, or the "
                                 "slice's pixels are damaged; convert"));
  EXPECT_THAT(message, testing::Not(HasSubstr("Cannot read")));
}

// Without Bits Allocated, (0028,0100), GDCM cannot read the pixels and gives no reason.
TEST_F(SpoiltSeries, UnreadablePixelsAreReportedAsDamaged) {
  std::string bytes = test::DicomSlice(ct_, 3, {});
  const std::size_t at = bytes.find(std::string("\x28\0\0\x01US", 6));
  ASSERT_NE(at, std::string::npos);
  bytes[at] = static_cast<char>(bytes[at] ^ 0x55);
  EXPECT_THAT(Message(3, bytes), testing::EndsWith("spoilt.dcm: the slice's pixels are damaged, or the header "
                                                   "describes them wrongly"));
}

TEST(ReadDicom, NonCtModalityIsRefused) {
  const Folder folder;
  SliceSpec mr;
  mr.modality = "MR";
  test::WriteDicom(SkewCt(), folder.path(), mr);
  EXPECT_THAT(MessageOf([&] { ReadFolder(folder.path()); }),
              HasSubstr("the modality is MR, not CT; kerf needs Hounsfield units"));
}

TEST(ReadDicom, EmptyFolderAndFolderWithoutDicomAreRefused) {
  const Folder folder;
  EXPECT_THAT(MessageOf([&] { ReadFolder(folder.path()); }), HasSubstr("the folder is empty"));
  WriteBytes(folder.file("notes.txt"), "nothing");
  EXPECT_THAT(MessageOf([&] { ReadFolder(folder.path()); }),
              HasSubstr("none of the 1 files in the folder is a DICOM image"));
  EXPECT_THAT(MessageOf([&] { ListDicomSeries(folder.file("gone")); }), HasSubstr("no such folder"));
}

TEST(ReadImage, NrrdNiftiAndMetaImageGiveTheSameVolume) {
  const Folder folder;
  const Volume ct = SkewCt();
  test::WriteNrrd(ct, folder.file("a.nrrd"));
  test::WriteNifti(ct, folder.file("a.nii"));
  test::WriteMeta(ct, folder.file("a.mha"));
  ExpectSame(ReadImageFile(folder.file("a.nrrd")), ct, 1e-9);
  ExpectSame(ReadImageFile(folder.file("a.mha")), ct, 1e-9);
  // NIfTI stores the lattice in single precision, which is 1e-5 mm at 140 mm.
  ExpectSame(ReadImageFile(folder.file("a.nii")), ct, 1e-4);
}

TEST(ReadImage, RasNrrdBecomesLps) {
  const Folder folder;
  Volume ct = SkewCt();
  std::string header = test::NrrdHeader(ct);
  header.replace(header.find("left-posterior-superior"), 23, "right-anterior-superior");
  WriteBytes(folder.file("a.nrrd"), header + "\n" + test::Bytes(ct.hu));
  for (int a = 0; a < 3; ++a) {
    ct.axes_W[a].x *= -1;
    ct.axes_W[a].y *= -1;
  }
  ct.origin_W.x *= -1;
  ct.origin_W.y *= -1;
  ExpectSame(ReadImageFile(folder.file("a.nrrd")), ct, 1e-9);
}

TEST(ReadImage, NrrdShorterThanItsHeaderStatesIsRefused) {
  const Folder folder;
  const Volume ct = SkewCt();
  Volume lying = ct;
  lying.size = {90, 80, 70};
  WriteBytes(folder.file("a.nrrd"), test::NrrdHeader(lying) + "\n" + test::Bytes(ct.hu));
  EXPECT_THAT(
      MessageOf([&] { ReadImageFile(folder.file("a.nrrd")); }),
      HasSubstr("the header states 90 x 80 x 70 voxels (1008000 bytes), but the file contains 1008 bytes of them"));
  // The memory is never allocated; 10^15 voxels would need 2 PB.
  lying.size = {100000, 100000, 100000};
  WriteBytes(folder.file("a.nrrd"), test::NrrdHeader(lying) + "\n" + test::Bytes(ct.hu));
  EXPECT_THAT(MessageOf([&] { ReadImageFile(folder.file("a.nrrd")); }),
              HasSubstr("more than the 2^31 that kerf reads"));
}

TEST(ReadImage, TruncatedNiftiAndMetaImageAreRefused) {
  const Folder folder;
  test::WriteNifti(SkewCt(), folder.file("a.nii"));
  test::WriteMeta(SkewCt(), folder.file("a.mha"));
  for (const char* name : {"a.nii", "a.mha"}) {
    const std::string whole = ReadBytes(folder.file(name));
    WriteBytes(folder.file(name), whole.substr(0, whole.size() - 2));
    EXPECT_THAT(MessageOf([&] { ReadImageFile(folder.file(name)); }),
                HasSubstr("the header states 9 x 8 x 7 voxels (1008 bytes), but the file contains 1006 bytes of them"));
  }
}

TEST(ReadImage, InvalidNiftiSpacingIsRefused) {
  const Folder folder;
  test::WriteNifti(SkewCt(), folder.file("a.nii"));
  const std::string whole = ReadBytes(folder.file("a.nii"));
  const float inf = std::numeric_limits<float>::infinity();
  for (std::size_t axis = 1; axis <= 3; ++axis) {
    for (const float spacing : {0.0f, std::nanf(""), inf, -inf, -0.5f}) {
      std::string bytes = whole;
      bytes.replace(76 + 4 * axis, 4, reinterpret_cast<const char*>(&spacing), 4);
      WriteBytes(folder.file("a.nii"), bytes);
      EXPECT_EQ(MessageOf([&] { ReadImageFile(folder.file("a.nii")); }),
                fmt::format("{}: the header's voxel spacing pixdim[{}] is {}; it must be a length in mm above 0",
                            folder.file("a.nii"), axis, spacing));
    }
  }
}

TEST(ReadImage, GarbageWithAnImageExtensionIsRefused) {
  const Folder folder;
  for (const char* name : {"a.nrrd", "a.nii", "a.nii.gz", "a.mha"}) {
    WriteBytes(folder.file(name), "This is no image, whatever it is called.\n");
    EXPECT_THAT(MessageOf([&] { ReadImageFile(folder.file(name)); }), HasSubstr("despite its name")) << name;
  }
  EXPECT_THAT(MessageOf([&] { ReadImageFile(folder.file("gone.nrrd")); }), HasSubstr("the file can't be opened"));
}

TEST(ReadImage, ColourAndFlatImagesAreRefused) {
  const Folder folder;
  WriteBytes(
      folder.file("rgb.nrrd"),
      "NRRD0004\ntype: uchar\ndimension: 4\nsizes: 3 4 4 4\nkinds: RGB-color domain domain domain\nencoding: raw\n\n" +
          std::string(192, '\1'));
  EXPECT_THAT(MessageOf([&] { ReadImageFile(folder.file("rgb.nrrd")); }), HasSubstr("each voxel has 3 components"));
  WriteBytes(folder.file("flat.nrrd"),
             "NRRD0004\ntype: uchar\ndimension: 2\nsizes: 4 4\nencoding: raw\n\n" + std::string(16, '\1'));
  EXPECT_THAT(MessageOf([&] { ReadImageFile(folder.file("flat.nrrd")); }),
              HasSubstr("has 2 dimensions; kerf requires 3"));
}

TEST(ReadImage, DamagedFilesPrintNothing) {
  const Folder folder;
  test::WriteDicom(SkewCt(), folder.path());
  const Volume ct = SkewCt();
  WriteBytes(folder.file("a.nrrd"), test::NrrdHeader(ct) + "\n" + test::Bytes(ct.hu).substr(0, 900));
  ::testing::internal::CaptureStderr();
  ::testing::internal::CaptureStdout();
  MessageOf([&] { ReadFolder(folder.path()); });
  MessageOf([&] { ReadImageFile(folder.file("a.nrrd")); });
  EXPECT_EQ(::testing::internal::GetCapturedStderr(), "");
  EXPECT_EQ(::testing::internal::GetCapturedStdout(), "");
}

// Returns a zlib stream with one stored (uncompressed) block, which needs no library to write.
std::string Zlib(const std::string& bytes) {
  std::uint32_t a = 1, b = 0;
  for (const char c : bytes) {
    a = (a + static_cast<unsigned char>(c)) % 65521;
    b = (b + a) % 65521;
  }
  const auto two = [](std::size_t v) { return std::string{static_cast<char>(v & 0xff), static_cast<char>(v >> 8)}; };
  const std::size_t n = bytes.size();
  return "\x78\x01\x01" + two(n) + two(~n & 0xffff) + bytes +
         std::string{static_cast<char>(b >> 8), static_cast<char>(b), static_cast<char>(a >> 8), static_cast<char>(a)};
}

// Reads a MetaImage with some additional header lines and the given bytes as its voxels.
class MetaVoxels : public ::testing::Test {
 protected:
  std::string Header(const std::string& lines) const {
    test::WriteMeta(ct_, folder_.file("plain.mha"));
    std::string bytes = ReadBytes(folder_.file("plain.mha"));
    bytes.resize(bytes.size() - 2 * ct_.count());
    return bytes.insert(bytes.find("ElementType"), lines);
  }
  Volume Read(const std::string& lines, const std::string& voxels) const {
    WriteBytes(folder_.file("a.mha"), Header(lines) + voxels);
    return ReadImageFile(folder_.file("a.mha"));
  }
  const Folder folder_;
  const Volume ct_ = SkewCt();
  const std::string voxels_ = test::Bytes(ct_.hu);
};

TEST_F(MetaVoxels, CompressedDataIsReadWithAndWithoutItsSize) {
  for (const char* lines : {"CompressedData = True\n", "CompressedData = T\nCompressedDataSize = 1019\n"}) {
    const Volume read = Read(lines, Zlib(voxels_));
    ExpectSame(read, ct_, 1e-9);
    EXPECT_TRUE(read.warnings.empty());
  }
  std::string header = Header("CompressedData = True\n");
  WriteBytes(folder_.file("a.mhd"), header.replace(header.find("LOCAL"), 5, "a.zraw"));
  WriteBytes(folder_.file("a.zraw"), Zlib(voxels_));
  ExpectSame(ReadImageFile(folder_.file("a.mhd")), ct_, 1e-9);
}

TEST_F(MetaVoxels, DamagedCompressedDataIsRefused) {
  const char* lines = "CompressedData = True\n";
  std::string spoilt = Zlib(voxels_);
  spoilt[500] ^= 1;
  EXPECT_THAT(MessageOf([&] { Read(lines, spoilt); }),
              HasSubstr("a.mha: the compressed voxels are damaged: they do not match their checksum"));
  spoilt = Zlib(voxels_);
  spoilt[5] ^= 1;  // the complement of the length
  EXPECT_THAT(MessageOf([&] { Read(lines, spoilt); }), HasSubstr("only 0 of 1008 bytes can be unpacked"));
  EXPECT_THAT(MessageOf([&] { Read(lines, Zlib(voxels_).substr(0, 500)); }), HasSubstr("it is cut off"));
}

TEST_F(MetaVoxels, HeaderSizeIsHonoured) {
  const std::string lines = "HeaderSize = 1000\n";
  const std::string header = Header(lines);
  ExpectSame(Read(lines, std::string(1000 - header.size(), 'x') + voxels_), ct_, 1e-9);
  ExpectSame(Read("HeaderSize = -1\n", "whatever this is" + voxels_), ct_, 1e-9);
  EXPECT_THAT(MessageOf([&] { Read("HeaderSize = 10\n", voxels_); }), HasSubstr("HeaderSize is 10, but the header"));
  EXPECT_THAT(MessageOf([&] { Read("HeaderSize = -1\nCompressedData = True\n", Zlib(voxels_)); }),
              HasSubstr("HeaderSize of -1 is for voxels that are neither compressed nor text"));
  EXPECT_THAT(MessageOf([&] { Read("HeaderSize = much\n", voxels_); }), HasSubstr("HeaderSize is 'much'; it must be"));
}

TEST_F(MetaVoxels, TextAndSwappedByteOrderAreRead) {
  std::string text;
  for (const std::int16_t hu : ct_.hu) text += fmt::format("{} ", hu);
  ExpectSame(Read("BinaryData = False\n", text), ct_, 1e-9);
  EXPECT_THAT(MessageOf([&] { Read("BinaryData = False\n", "1 2 3"); }),
              HasSubstr("3 voxels can be read, but the header states 504"));
  EXPECT_THAT(MessageOf([&] { Read("BinaryData = False\n", "1 2 3 x"); }),
              HasSubstr("voxel 4 is 'x', which is not a number"));
  std::string swapped = voxels_;
  for (std::size_t n = 0; n < swapped.size(); n += 2) std::swap(swapped[n], swapped[n + 1]);
  ExpectSame(Read("ElementByteOrderMSB = True\n", swapped), ct_, 1e-9);
}

TEST(NrrdVoxels, SkipFieldsTextAndSwappedByteOrderAreRead) {
  const Folder folder;
  const Volume ct = SkewCt();
  const std::string voxels = test::Bytes(ct.hu);
  std::string swapped = voxels;
  for (std::size_t n = 0; n < swapped.size(); n += 2) std::swap(swapped[n], swapped[n + 1]);
  std::string text;
  for (const std::int16_t hu : ct.hu) text += fmt::format("{}\n", hu);
  struct Case {
    std::string field, by, data;
  };
  for (const Case& c : {Case{"endian: little", "endian: big", swapped}, Case{"encoding: raw", "encoding: text", text},
                        Case{"encoding: raw", "encoding: raw\nline skip: 2\nbyte skip: 3", "a\nb\nabc" + voxels},
                        Case{"encoding: raw", "encoding: raw\nbyte skip: -1", "whatever" + voxels}}) {
    std::string header = test::NrrdHeader(ct);
    header.replace(header.find(c.field), c.field.size(), c.by);
    WriteBytes(folder.file("a.nrrd"), header + "\n" + c.data);
    ExpectSame(ReadImageFile(folder.file("a.nrrd")), ct, 1e-9);
  }
}

TEST(ReadImage, BrokenHeadersAreRefusedWithKerfsOwnMessages) {
  const Folder folder;
  const Volume ct = SkewCt();
  struct Case {
    std::string name, field, by, said;
  };
  for (const Case& c : {
           Case{"a.nrrd", "dimension: 3", "dimension: 4", "gives 4 dimensions in 'dimension' and 3 sizes in 'sizes'"},
           Case{"a.nrrd", "endian: little", "endian: middle", "'endian: little' or 'endian: big', but as 'middle'"},
           Case{"a.nrrd", "endian: little\n", "", "does not give the byte order of its voxels"},
           Case{"a.nrrd", "encoding: raw\n", "", "the NRRD header does not name an encoding"},
           Case{"a.nrrd", "encoding: raw", "encoding: hex", "voxels with encoding 'hex' are not supported; kerf reads"},
           Case{"a.nrrd", "encoding: raw", "encoding: gzip\nbyte skip: -1", "'byte skip: -1' is for raw voxels"},
           Case{"a.nrrd", "encoding: raw", "encoding: raw\nline skip: 100000", "has fewer lines than the header's"},
           Case{"a.nrrd", "encoding: raw", "encoding: raw\nline skip: -1", "'line skip' is -1, below 0"},
           Case{"a.nrrd", "encoding: raw", "encoding: raw\ndata file: s%03d.raw 1 99 1", "names 99 data files for"},
           Case{"a.nrrd", "encoding: raw", "encoding: raw\ndata file: LIST",
                "(-31.5,12.25,140), which can't be opened"},
           Case{"a.nrrd", "encoding: raw", "encoding: raw\ndata file: listed50%.raw", "listed50%.raw, which can't be"},
           Case{"a.nrrd", "type: short", "type: block", "voxels of type 'block' are not supported"},
           Case{"a.mha", "Offset = ", "Offset = x", "the MetaImage header's Offset 'x"},
           Case{"a.mha", "TransformMatrix = ", "TransformMatrix = nan ", "header's TransformMatrix 'nan"},
           Case{"a.mha", "MET_SHORT", "MET_OTHER", "voxels of type 'MET_OTHER' are not supported"},
           Case{"a.mha", "LOCAL", "gone.raw", "gone.raw, which can't be opened"},
       }) {
    test::WriteNrrd(ct, folder.file("a.nrrd"));
    test::WriteMeta(ct, folder.file("a.mha"));
    std::string bytes = ReadBytes(folder.file(c.name));
    WriteBytes(folder.file(c.name), bytes.replace(bytes.find(c.field), c.field.size(), c.by));
    const std::string message = MessageOf([&] { ReadImageFile(folder.file(c.name)); });
    EXPECT_THAT(message, HasSubstr(c.said)) << c.by;
    EXPECT_EQ(message.rfind(folder.file(c.name) + ": ", 0), 0) << message;
  }
}

TEST(ReadImage, DamagedAndTruncatedGzipFilesAreReportedAsSuch) {
  const Folder folder;
  test::WriteNifti(SkewCt(), folder.file("a.nii"));
  ASSERT_EQ(std::system(("gzip -n '" + folder.file("a.nii") + "'").c_str()), 0);
  const std::string whole = ReadBytes(folder.file("a.nii.gz"));
  const auto said = [&](const std::string& bytes) {
    WriteBytes(folder.file("a.nii.gz"), bytes);
    return MessageOf([&] { ReadImageFile(folder.file("a.nii.gz")); });
  };
  for (std::size_t at = 10; at < whole.size() - 4; at += 7) {
    std::string spoilt = whole;
    spoilt[at] = static_cast<char>(spoilt[at] ^ 0x55);
    EXPECT_THAT(said(spoilt), ::testing::AnyOf(HasSubstr("damaged"), HasSubstr("cut off"))) << at;
  }
  EXPECT_THAT(said(whole.substr(0, 30)), HasSubstr("the file is cut off:"));
  EXPECT_THAT(said(whole.substr(0, whole.size() / 2)), HasSubstr("cut off"));
}

}  // namespace
}  // namespace kerf
