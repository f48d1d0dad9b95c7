// Tests how a file's header places the voxels in the patient. The placement is used where the format defines it;
// otherwise the file is refused, or read with a warning that also appears in the bone's provenance.
#include "bone/import/patient_frame.h"

#include <gmock/gmock.h>

#include <cstdlib>
#include <filesystem>
#include <numbers>

#include "bone/import/dicom.h"
#include "bone/import/image_file.h"
#include "bone/import/import.h"
#include "ct_files.h"
#include "test_paths.h"

namespace kerf {
namespace {

using test::Folder;
using test::MessageOf;
using test::Put;
using test::WriteBytes;
using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

// Returns a CT that is different along each axis and without symmetry. All its numbers are exact in single precision.
Volume StraightCt() {
  Volume ct;
  ct.size = {7, 6, 5};
  ct.spacing_mm = {0.5, 0.75, 2};
  ct.origin_W = {-10.5, 20.25, 31};
  for (std::size_t v = 0; v < ct.count(); ++v) {
    ct.hu.push_back(static_cast<std::int16_t>(static_cast<int>(v * 37 % 3000) - 1000));
  }
  return ct;
}

void ExpectSame(const Volume& a, const Volume& b) {
  ASSERT_EQ(a.size, b.size);
  EXPECT_EQ(a.hu, b.hu);
  for (const Vec3& p : {Vec3(0, 0, 0), Vec3(6, 0, 0), Vec3(0, 5, 0), Vec3(0, 0, 4)}) {
    EXPECT_LT(glm::length(a.WorldFromVoxel(p) - b.WorldFromVoxel(p)), 1e-9);  // all numbers are exact
  }
}

// Returns the same scan stored in a different order: axis a of the file is axis order[a] of `ct`, reversed where bit a
// of `backwards` is set.
Volume StoredOtherwise(const Volume& ct, const std::array<int, 3>& order, int backwards) {
  Volume file;
  Vec3 first(0);
  for (int a = 0; a < 3; ++a) {
    const int from = order[static_cast<std::size_t>(a)];
    const bool back = ((backwards >> a) & 1) != 0;
    file.size[a] = ct.size[from];
    file.spacing_mm[a] = ct.spacing_mm[from];
    file.axes_W[a] = back ? -ct.axes_W[from] : ct.axes_W[from];
    if (back) first[from] = ct.size[from] - 1;
  }
  file.origin_W = ct.WorldFromVoxel(first);
  for (int k = 0; k < file.size[2]; ++k) {
    for (int j = 0; j < file.size[1]; ++j) {
      for (int i = 0; i < file.size[0]; ++i) {
        const Vec3 at = glm::round(ct.VoxelFromWorld(file.WorldFromVoxel({i, j, k})));
        file.hu.push_back(ct.hu[ct.Index(static_cast<int>(at.x), static_cast<int>(at.y), static_cast<int>(at.z))]);
      }
    }
  }
  return file;
}

TEST(PatientFrame, LettersAndSignedPermutationsAreInverse) {
  for (const char* frame : {"LPS", "RAS", "LAS", "SPL", "AIR"}) EXPECT_EQ(FrameName(LpsFromFrame(frame)), frame);
  EXPECT_EQ(LpsFromFrame("ras") * Vec3(1, 2, 3), Vec3(-1, -2, 3));
  EXPECT_EQ(LpsFromFrame("SRA") * Vec3(1, 2, 3), Vec3(-2, -3, 1));
  for (const char* none : {"", "LP", "LPSS", "LLS", "LRS", "XYZ"}) {
    EXPECT_THAT(MessageOf([&] { LpsFromFrame(none); }), HasSubstr("is unknown; give three letters")) << none;
  }
}

TEST(PatientFrame, AnyStorageOrderGivesABitIdenticalVolume) {
  const Volume ct = StraightCt();
  std::array<int, 3> order = {0, 1, 2};
  do {
    for (int backwards = 0; backwards < 8; ++backwards) {
      EXPECT_EQ(CalcHash(StoreAlongPatient(StoredOtherwise(ct, order, backwards))), CalcHash(ct));
    }
  } while (std::next_permutation(order.begin(), order.end()));
}

TEST(PatientFrame, NiftiInTheOrderOfDcm2niixIsBitIdenticalToDicom) {
  // In the file, rows are reversed (front to back becomes back to front), and values are int16 with slope 1 and
  // intercept -1024.
  const Volume ct = StraightCt();
  const Folder folder;
  test::WriteDicom(ct, folder.path());
  const Volume dicom = ReadDicomSeries(ChooseSeries(ListDicomSeries(folder.path()), "", folder.path()), {});
  Volume stored = StoredOtherwise(ct, {0, 1, 2}, 0b010);
  std::string header = test::NiftiHeader(stored);
  Put(header, 112, 1.0f);
  Put(header, 116, -1024.0f);
  for (std::int16_t& hu : stored.hu) hu = static_cast<std::int16_t>(hu + 1024);
  WriteBytes(folder.file("a.nii"), header + test::Bytes(stored.hu));
  EXPECT_EQ(CalcHash(StoreAlongPatient(ReadImageFile(folder.file("a.nii")))), CalcHash(StoreAlongPatient(dicom)));
}

// Expects that a DICOM folder and the plain and compressed NIfTI files that dcm2niix makes of it give the same volume.
void ExpectSameByDcm2niix(const std::string& dicom) {
  const std::uint64_t expected =
      CalcHash(StoreAlongPatient(ReadDicomSeries(ChooseSeries(ListDicomSeries(dicom), "", dicom), {})));
  const Folder folder;
  for (const auto& [packing, file] : {std::pair("n", "n.nii"), std::pair("i", "i.nii.gz")}) {
    const std::string command =
        fmt::format("dcm2niix -z {0} -f {0} -o '{1}' '{2}' >/dev/null 2>&1", packing, folder.path(), dicom);
    ASSERT_EQ(std::system(command.c_str()), 0);
    const Volume nifti = ReadImageFile(folder.file(file));
    EXPECT_THAT(nifti.warnings, IsEmpty());
    EXPECT_EQ(CalcHash(StoreAlongPatient(nifti)), expected) << dicom << " " << file;
  }
}

bool HasDcm2niix() {
  return std::system("command -v dcm2niix >/dev/null 2>&1") == 0;
}

TEST(Dcm2niix, NiftiIsBitIdenticalToDicom) {
  if (!HasDcm2niix()) GTEST_SKIP() << "dcm2niix is not installed";
  const std::filesystem::path folder = std::filesystem::temp_directory_path() / fmt::format("kerf_dicom_{}", getpid());
  std::filesystem::create_directories(folder);
  test::WriteDicom(StraightCt(), folder);
  ExpectSameByDcm2niix(folder);
  std::filesystem::remove_all(folder);
}

TEST(Dcm2niix, NiftiOfRealScansIsBitIdenticalToDicom) {
  if (!HasDcm2niix()) GTEST_SKIP() << "dcm2niix is not installed";
  for (const char* name : {"visible_human_female", "phantom_siemens"}) {
    const std::string dicom = std::string(KERF_TEST_DATA) + "/" + name + "/dicom";
    if (!std::filesystem::exists(dicom)) GTEST_SKIP() << "not found: " << dicom;
    ExpectSameByDcm2niix(dicom);
  }
}

TEST(NiftiValues, SlopeAndInterceptGiveHu) {
  const Folder folder;
  const Volume ct = StraightCt();
  struct Case {
    float slope, intercept;
    bool scaled;  // whether the header defines a rescale
  };
  for (const Case& c :
       {Case{1, -1024, true}, Case{0.5, -1000, true}, Case{0, 0, false}, Case{0, 7, false}, Case{1, 0, true}}) {
    std::string header = test::NiftiHeader(ct);
    Put(header, 112, c.slope);
    Put(header, 116, c.intercept);
    std::vector<std::int16_t> stored;
    for (const std::int16_t hu : ct.hu) {
      const float value = c.scaled ? (static_cast<float>(hu) - c.intercept) / c.slope : static_cast<float>(hu);
      stored.push_back(static_cast<std::int16_t>(std::lround(value)));
    }
    WriteBytes(folder.file("a.nii"), header + test::Bytes(stored));
    ExpectSame(ReadImageFile(folder.file("a.nii")), ct);
  }
}

TEST(NiftiValues, NonFiniteRescaleCausesAWarningOrIsRefused) {
  const Folder folder;
  const Volume ct = StraightCt();
  const float nan = std::numeric_limits<float>::quiet_NaN();
  const auto read = [&](float slope, float intercept) {
    std::string header = test::NiftiHeader(ct);
    Put(header, 112, slope);
    Put(header, 116, intercept);
    WriteBytes(folder.file("a.nii"), header + test::Bytes(ct.hu));
    return ReadImageFile(folder.file("a.nii"));
  };
  for (const float slope : {nan, std::numeric_limits<float>::infinity()}) {
    const Volume stored = read(slope, nan);
    ExpectSame(stored, ct);
    EXPECT_THAT(stored.warnings, ElementsAre(HasSubstr("the values were used as stored")));
  }
  EXPECT_THAT(MessageOf([&] { read(1, nan); }), HasSubstr("(scl_inter) is nan, which is not a number"));
  EXPECT_THAT(read(0, nan).warnings, IsEmpty());  // a slope of 0 means no rescale
}

TEST(NiftiValues, SwappedByteOrderIsRead) {
  const Volume ct = StraightCt();
  std::string bytes = test::NiftiHeader(ct) + test::Bytes(ct.hu);
  const auto swap = [&bytes](std::size_t from, std::size_t size, std::size_t count) {
    for (std::size_t n = 0; n < count; ++n) {
      const auto at = bytes.begin() + static_cast<std::ptrdiff_t>(from + n * size);
      std::reverse(at, at + static_cast<std::ptrdiff_t>(size));
    }
  };
  swap(0, 4, 1);
  swap(40, 2, 8);
  swap(70, 2, 2);
  swap(76, 4, 11);
  swap(252, 2, 2);
  swap(256, 4, 18);
  swap(352, 2, ct.count());
  const Folder folder;
  WriteBytes(folder.file("a.nii"), bytes);
  ExpectSame(ReadImageFile(folder.file("a.nii")), ct);
}

TEST(NiftiValues, InconsistentBitsAreRefusedAndNonFiniteValuesAreAir) {
  const Folder folder;
  const Volume ct = StraightCt();
  std::string bytes = test::NiftiHeader(ct) + test::Bytes(ct.hu);
  Put(bytes, 70, std::int16_t{2});
  WriteBytes(folder.file("a.nii"), bytes);
  EXPECT_THAT(MessageOf([&] { ReadImageFile(folder.file("a.nii")); }),
              HasSubstr("the header contradicts itself: voxels of NIfTI type 2 have 8 bits, not 16"));
  std::vector<float> values(ct.hu.begin(), ct.hu.end());
  values[3] = std::numeric_limits<float>::quiet_NaN();
  std::string header = test::NiftiHeader(ct);
  Put(header, 70, std::int16_t{16});
  Put(header, 72, std::int16_t{32});
  WriteBytes(folder.file("a.nii"), header + std::string(reinterpret_cast<const char*>(values.data()), 4 * ct.count()));
  const Volume read = ReadImageFile(folder.file("a.nii"));
  EXPECT_EQ(read.hu[3], -1024);
  EXPECT_THAT(read.warnings,
              Contains(HasSubstr("1 of 210 voxels are not finite numbers (NaN or infinite); they were taken as air")));
}

// Reads a NIfTI file whose header has been changed.
class NiftiForms : public ::testing::Test {
 protected:
  Volume Read(const std::function<void(std::string&)>& change, const std::string& frame = "") {
    std::string header = test::NiftiHeader(ct_);
    change(header);
    WriteBytes(folder_.file("a.nii"), header + test::Bytes(ct_.hu));
    return ReadImageFile(folder_.file("a.nii"), frame);
  }
  // Writes the qform of the axes of ct_: half a turn about z, from RAS to LPS.
  static void PutQForm(std::string& header, const Vec3& origin_lps) {
    Put(header, 252, std::int16_t{1});
    Put(header, 264, 1.0f);
    Put(header, 268, static_cast<float>(-origin_lps.x));
    Put(header, 272, static_cast<float>(-origin_lps.y));
    Put(header, 276, static_cast<float>(origin_lps.z));
  }
  const Folder folder_;
  const Volume ct_ = StraightCt();
};

TEST_F(NiftiForms, SFormQFormOrBothGiveTheLatticeWithoutAWarning) {
  for (const int forms : {1, 2, 3}) {
    const Volume read = Read([&](std::string& h) {
      if ((forms & 1) == 0) Put(h, 254, std::int16_t{0});
      if ((forms & 2) != 0) PutQForm(h, ct_.origin_W);
    });
    ExpectSame(read, ct_);
    EXPECT_THAT(read.warnings, IsEmpty());
  }
}

TEST_F(NiftiForms, AMirroredQFormIsHonoured) {
  const Volume read = Read([&](std::string& h) {
    Put(h, 254, std::int16_t{0});
    PutQForm(h, ct_.origin_W);
    Put(h, 76, -1.0f);
  });
  EXPECT_EQ(read.axes_W[2], Vec3(0, 0, -1));
}

TEST_F(NiftiForms, WithoutAFormRasIsAssumedWithAWarning) {
  const auto none = [](std::string& h) { Put(h, 254, std::int16_t{0}); };
  const Volume read = Read(none);
  EXPECT_THAT(read.warnings, ElementsAre(HasSubstr("sform_code and qform_code are 0); its axes were taken as RAS")));
  EXPECT_EQ(read.axes_W[0], Vec3(-1, 0, 0));
  EXPECT_EQ(read.axes_W[1], Vec3(0, -1, 0));
  EXPECT_EQ(read.spacing_mm, ct_.spacing_mm);
  const Volume stated = Read(none, "LPS");
  EXPECT_THAT(stated.warnings, IsEmpty());
  EXPECT_EQ(stated.axes_W, glm::dmat3(1));
}

TEST_F(NiftiForms, DifferentSFormAndQFormCauseAWarning) {
  const Volume read = Read([&](std::string& h) { PutQForm(h, ct_.origin_W + Vec3(30, 0, 40)); });
  ExpectSame(read, ct_);  // the sform places it
  EXPECT_THAT(read.warnings,
              ElementsAre(HasSubstr("gives two positions of the scan, up to 50.0 mm apart; its sform was used")));
}

TEST_F(NiftiForms, ScannerSpaceIsPreferredToAStandardSpace) {
  const Volume both = Read([&](std::string& h) {
    Put(h, 254, std::int16_t{4});
    PutQForm(h, ct_.origin_W + Vec3(0, 50, 0));
  });
  EXPECT_EQ(both.origin_W, ct_.origin_W + Vec3(0, 50, 0));
  EXPECT_THAT(both.warnings, ElementsAre(HasSubstr("its qform was used, in the scanner's coordinates")));
  const Volume alone = Read([](std::string& h) { Put(h, 254, std::int16_t{4}); });
  EXPECT_THAT(alone.warnings, ElementsAre(HasSubstr("in MNI coordinates, to which it may have been stretched")));
}

TEST_F(NiftiForms, MetresAndMicrometresAreReadAndUnknownUnitsCauseAWarning) {
  for (const auto& [code, per_mm] : {std::pair(1, 1e-3f), std::pair(3, 1e3f)}) {
    const Volume read = Read([&, unit = code, f = per_mm](std::string& h) {
      h[123] = static_cast<char>(unit + 8);  // the unit of length, plus 8 for seconds
      for (std::size_t at = 80; at < 92; at += 4) {
        float v = 0;
        std::memcpy(&v, &h[at], 4);
        Put(h, at, v * f);
      }
      for (std::size_t at = 280; at < 328; at += 4) {
        float v = 0;
        std::memcpy(&v, &h[at], 4);
        Put(h, at, v * f);
      }
    });
    EXPECT_THAT(read.warnings, IsEmpty());
    EXPECT_LT(glm::length(read.origin_W - ct_.origin_W), 1e-5);  // single precision at 31 mm
    EXPECT_LT(glm::length(read.spacing_mm - ct_.spacing_mm), 1e-6);
  }
  EXPECT_THAT(Read([](std::string& h) { h[123] = 0; }).warnings, ElementsAre(HasSubstr("no unit of length")));
  EXPECT_THAT(MessageOf([&] { Read([](std::string& h) { h[123] = 5; }); }), HasSubstr("is unknown"));
}

TEST_F(NiftiForms, AffineInMetresDeclaredAsMillimetresIsRecognised) {
  const std::string message = MessageOf([&] {
    Read([](std::string& h) {
      for (std::size_t row = 0; row < 3; ++row) Put(h, 280 + 20 * row, 0.001f);
    });
  });
  EXPECT_THAT(message, HasSubstr("the voxel spacing along axis 1 is 0.001"));
  EXPECT_THAT(message, HasSubstr("the header is probably in metres"));
}

TEST_F(NiftiForms, ShearedAffineIsReadUnlessTheAxesAreDependent) {
  Volume sheared = ct_;
  sheared.axes_W[2] = glm::normalize(Vec3(0, 0.3, 1));
  const auto write = [](const Volume& ct) { return [ct](std::string& h) { h = test::NiftiHeader(ct); }; };
  const Volume read = Read(write(sheared));
  EXPECT_THAT(read.warnings, IsEmpty());
  for (const Vec3& p : {Vec3(6, 0, 0), Vec3(0, 5, 0), Vec3(0, 0, 4)}) {
    EXPECT_LT(glm::length(read.WorldFromVoxel(p) - sheared.WorldFromVoxel(p)), 1e-5);  // single precision
  }
  sheared.axes_W[2] = glm::normalize(Vec3(0, 2, 1));
  EXPECT_THAT(MessageOf([&] { Read(write(sheared)); }), HasSubstr("the image axes do not span space"));
}

TEST_F(NiftiForms, ContradictorySpacingsCauseAWarning) {
  const Volume read = Read([](std::string& h) { Put(h, 88, 3.0f); });
  EXPECT_THAT(read.warnings, ElementsAre(HasSubstr("along axis 3, 2 mm by its sform and 3 mm by its pixdim")));
}

// Reads an NRRD file in which a line has been replaced by `by`, or removed if `by` is empty.
class NrrdFrames : public ::testing::Test {
 protected:
  std::string Header(const std::string& line, const std::string& by, const std::string& frame = "LPS") const {
    Volume file = ct_;
    const glm::dmat3 from_lps = glm::inverse(LpsFromFrame(frame));
    file.origin_W = from_lps * file.origin_W;
    file.axes_W = from_lps * file.axes_W;
    std::string header = test::NrrdHeader(file);
    const std::size_t at = header.find(line + ":");
    EXPECT_NE(at, std::string::npos);
    return header.replace(at, header.find('\n', at) + 1 - at, by);
  }
  Volume Read(const std::string& header, const std::string& frame = "") const {
    WriteBytes(folder_.file("a.nrrd"), header + "\n" + test::Bytes(ct_.hu));
    return ReadImageFile(folder_.file("a.nrrd"), frame);
  }
  const Folder folder_;
  const Volume ct_ = StraightCt();
};

TEST_F(NrrdFrames, PatientSpacesAreReadByLongAndShortName) {
  for (const auto& [name, frame] : {std::pair("right-anterior-superior", "RAS"), std::pair("RAS", "RAS"),
                                    std::pair("left-anterior-superior", "LAS"), std::pair("LAS", "LAS"),
                                    std::pair("left-posterior-superior", "LPS"), std::pair("LPS", "LPS")}) {
    const Volume read = Read(Header("space", fmt::format("space: {}\n", name), frame));
    ExpectSame(read, ct_);
    EXPECT_THAT(read.warnings, IsEmpty()) << name;
  }
}

TEST_F(NrrdFrames, SpacesWithoutOrientationAreTakenAsLpsWithAWarning) {
  for (const auto& [line, warning] :
       {std::pair("space: scanner-xyz\n", "is the scanner's, not the patient's; LPS was assumed"),
        std::pair("space: 3D-right-handed\n", "does not say how the scan lies in the patient"),
        std::pair("space dimension: 3\n", "names no space")}) {
    const Volume read = Read(Header("space", line));
    ExpectSame(read, ct_);
    EXPECT_THAT(read.warnings, ElementsAre(HasSubstr(warning)));
    const Volume stated = Read(Header("space", line, "RAS"), "RAS");
    ExpectSame(stated, ct_);
    EXPECT_THAT(stated.warnings, IsEmpty());
  }
}

TEST_F(NrrdFrames, LeftHandedAndUnknownSpacesAreRefused) {
  EXPECT_THAT(MessageOf([&] { Read(Header("space", "space: 3D-left-handed\n")); }),
              HasSubstr("specify where x, y and z point with --frame"));
  ExpectSame(Read(Header("space", "space: 3D-left-handed\n", "LAS"), "LAS"), ct_);
  EXPECT_THAT(MessageOf([&] { Read(Header("space", "space: mars\n")); }), HasSubstr("space 'mars' is unknown"));
}

TEST_F(NrrdFrames, TheSizeOfAVoxelMustBeGiven) {
  EXPECT_THAT(MessageOf([&] { Read(Header("space directions", "")); }), HasSubstr("gives no 'space directions'"));
  const auto with = [&](const std::string& spacings) {
    return fmt::format("NRRD0004\ntype: short\ndimension: 3\nsizes: 7 6 5\nencoding: raw\nendian: little\n{}",
                       spacings);
  };
  EXPECT_THAT(MessageOf([&] { Read(with("")); }),
              HasSubstr("does not give the size of a voxel, neither by 'space directions' nor by 'spacings'"));
  const Volume read = Read(with("spacings: 0.5 0.75 2\n"));
  EXPECT_EQ(read.hu, ct_.hu);
  EXPECT_EQ(read.spacing_mm, ct_.spacing_mm);
  EXPECT_THAT(read.warnings, ElementsAre(HasSubstr("names no space")));
  EXPECT_THAT(MessageOf([&] { Read(with("spacings: 0.5 nan 2\n")); }), HasSubstr("size of a voxel"));
  EXPECT_THAT(MessageOf([&] { Read(Header("space directions", "space directions: (1,0) (0,1) none\n")); }),
              HasSubstr("should be vectors of three numbers"));
}

TEST_F(NrrdFrames, UnitsOfLengthAreHonoured) {
  Volume metres = ct_;
  metres.spacing_mm *= 1e-3;
  metres.origin_W *= 1e-3;
  const auto with = [&](const std::string& units) { return test::NrrdHeader(metres) + "space units: " + units + "\n"; };
  ExpectSame(Read(with("\"m\" \"m\" \"m\"")), ct_);
  EXPECT_THAT(MessageOf([&] { Read(with("\"m\" \"mm\" \"m\"")); }), HasSubstr("gives its axes different units"));
  EXPECT_THAT(MessageOf([&] { Read(with("\"ell\" \"ell\" \"ell\"")); }), HasSubstr("unit of length 'ell' is unknown"));
}

TEST(MetaFrames, TheSizeOfAVoxelMustBeGivenAndItsUnitIsHonoured) {
  const Folder folder;
  const Volume ct = StraightCt();
  test::WriteMeta(ct, folder.file("a.mha"));
  const std::string whole = test::ReadBytes(folder.file("a.mha"));
  const std::size_t at = whole.find("ElementSpacing");
  std::string without = whole;
  WriteBytes(folder.file("a.mha"), without.erase(at, whole.find('\n', at) + 1 - at));
  EXPECT_THAT(MessageOf([&] { ReadImageFile(folder.file("a.mha")); }),
              HasSubstr("does not give the size of a voxel, neither by ElementSpacing nor by ElementSize"));
  std::string centimetres = whole;
  WriteBytes(folder.file("a.mha"), centimetres.insert(at, "DistanceUnits = cm\n"));
  EXPECT_EQ(ReadImageFile(folder.file("a.mha")).spacing_mm, 10.0 * ct.spacing_mm);
  WriteBytes(folder.file("a.mha"), whole);
  const Volume stated = ReadImageFile(folder.file("a.mha"), "RAS");
  EXPECT_EQ(stated.origin_W, Vec3(-1, -1, 1) * ct.origin_W);
}

TEST(MetaFrames, MissingFieldsCauseWarningsAndInvalidRotationsAreRefused) {
  const Folder folder;
  test::WriteMeta(StraightCt(), folder.file("a.mha"));
  const std::string whole = test::ReadBytes(folder.file("a.mha"));
  EXPECT_THAT(ReadImageFile(folder.file("a.mha")).warnings, testing::IsEmpty());
  const auto with = [&](const std::string& key, const std::string& line) {
    const std::size_t at = whole.find(key + " =");
    std::string changed = whole;
    WriteBytes(folder.file("a.mha"), changed.replace(at, whole.find('\n', at) + 1 - at, line));
    return folder.file("a.mha");
  };
  EXPECT_THAT(ReadImageFile(with("TransformMatrix", "")).warnings,
              testing::ElementsAre(HasSubstr("has no TransformMatrix: its axes were taken to point left")));
  EXPECT_THAT(ReadImageFile(with("Offset", "")).warnings, testing::ElementsAre(HasSubstr("has no Offset")));
  EXPECT_THAT(MessageOf([&] { ReadImageFile(with("TransformMatrix", "TransformMatrix = 2 0 0 0 2 0 0 0 2\n")); }),
              HasSubstr("an axis of the header's TransformMatrix has the length 2 instead of 1"));
}

TEST(MetaFrames, NDimsThatContradictsTheSizesIsRefused) {
  const Folder folder;
  test::WriteMeta(StraightCt(), folder.file("a.mha"));
  const std::string whole = test::ReadBytes(folder.file("a.mha"));
  const std::size_t at = whole.find("NDims = 3");
  ASSERT_NE(at, std::string::npos);
  for (const char* dimensions : {"-3", "2147483647", "99999999999", "4", "x"}) {
    std::string changed = whole;
    WriteBytes(folder.file("a.mha"), changed.replace(at, 9, std::string("NDims = ") + dimensions));
    EXPECT_THAT(MessageOf([&] { ReadImageFile(folder.file("a.mha")); }), HasSubstr("dimensions in NDims and 3 sizes"))
        << dimensions;
  }
}

TEST(Provenance, AssumptionsAreStatedInTheReportAndInTheBone) {
  const Volume ball =
      test::MakeCt({30, 30, 30}, {1, 1, 1}, {-15, -15, -15}, glm::dmat3(1), test::Ball(Vec3(3.2, 4.3, -0.1), 9));
  std::string header = test::NrrdHeader(ball);
  const std::string space = "space: left-posterior-superior";
  header.replace(header.find(space), space.size(), "space: scanner-xyz");
  const Folder folder;
  WriteBytes(folder.file("a.nrrd"), header + "\n" + test::Bytes(ball.hu));
  ImportOptions options;
  options.voxel_mm = 1;
  options.isolate.isolate = false;
  const ImportResult result = Import(folder.file("a.nrrd"), options);
  EXPECT_THAT(result.report.warnings, ElementsAre(HasSubstr("scanner-xyz")));
  EXPECT_THAT(result.bone.notes().at("import_warnings"), HasSubstr("scanner-xyz"));
  options.frame = "RAS";
  const ImportResult stated = Import(folder.file("a.nrrd"), options);
  EXPECT_THAT(stated.report.warnings, IsEmpty());
  EXPECT_EQ(stated.bone.notes().at("import_frame"), "RAS, as stated by --frame");
  // The stated frame rotates the bone by half a turn about z. The surface's position is known to a fraction of the 1 mm
  // voxel.
  EXPECT_LT(glm::length(result.report.box.centre() - Vec3(3.2, 4.3, -0.1)), 0.3);
  EXPECT_LT(glm::length(stated.report.box.centre() - Vec3(-3.2, -4.3, -0.1)), 0.3);
}

TEST(MeshFrames, SurfaceIsRotatedOrMirroredToTheStatedFrame) {
  // A block of 10 x 20 x 30 mm with a corner at the origin, facing outward.
  std::string block;
  for (int n = 0; n < 8; ++n) block += fmt::format("v {} {} {}\n", n % 2 * 10, n / 2 % 2 * 20, n / 4 * 30);
  for (const char* face : {"1 3 4 2", "5 6 8 7", "1 2 6 5", "3 7 8 4", "1 5 7 3", "2 4 8 6"}) {
    block += fmt::format("f {}\n", face);
  }
  const Folder folder;
  WriteBytes(folder.file("a.obj"), block);
  ImportOptions options;
  options.voxel_mm = 1;
  for (const auto& [frame, upper] : {std::pair("", Vec3(10, 20, 30)), std::pair("RAS", Vec3(0, 0, 30)),
                                     std::pair("LAS", Vec3(10, 0, 30)), std::pair("SPL", Vec3(30, 20, 10))}) {
    options.frame = frame;
    const ImportReport report = Import(folder.file("a.obj"), options).report;
    EXPECT_LT(glm::length(report.box.upper - upper), 0.01) << frame;
    // A level set with 1 mm voxels loses less than 0.5 mm2 of cross-section along the 240 mm of edges.
    EXPECT_NEAR(report.solid_mm3, 6000, 120) << frame;
  }
}

}  // namespace
}  // namespace kerf
