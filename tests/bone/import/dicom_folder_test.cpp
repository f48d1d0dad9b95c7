// DICOM folders as they come: what does not belong to the series is left out and named, and the series is chosen.
#include <gmock/gmock.h>
#include <zip.h>

#include <filesystem>

#include "bone/import/dicom_charset.h"
#include "bone/import/dicom_header.h"
#include "bone/import/dicom_input.h"
#include "bone/import/dicom_zip.h"
#include "bone/import/import.h"
#include "ct_files.h"
#include "dicom_bytes.h"

namespace kerf {
namespace {

using test::DicomBytes;
using test::Folder;
using test::MessageOf;
using test::WriteBytes;
using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

// A ball of bone in a scan that is large enough for a jaw: 48 x 40 x 30 mm.
Volume BallCt(int slices = 15) {
  return test::MakeCt({24, 20, slices}, {2, 2, 2}, {-24, -20, -slices}, glm::dmat3(1), test::Ball({0, 0, 0}, 9));
}

class DicomFolder : public ::testing::Test {
 protected:
  // Writes the slices as 00.dcm, 01.dcm, ... with `change` applied to each.
  void Write(const Volume& ct, const std::string& prefix = "", const std::function<void(DicomBytes&, int)>& change = {},
             const std::string& extension = ".dcm") const {
    for (int k = 0; k < ct.size[2]; ++k) {
      DicomBytes bytes(test::DicomSlice(ct, k, {}));
      if (change) change(bytes, k);
      WriteBytes(folder_.file(fmt::format("{}{:02}{}", prefix, k, extension)), bytes.File());
    }
  }
  std::string Slice(int k, const std::function<void(DicomBytes&)>& change = {}) const {
    DicomBytes bytes(test::DicomSlice(ct_, k, {}));
    if (change) change(bytes);
    return bytes.File();
  }
  Volume Read(const std::string& series = "", const std::string& name = "") const {
    ImportOptions options;
    options.series = series;
    ImportReport report;
    return ReadCt(name.empty() ? folder_.path() : folder_.file(name), options, report);
  }
  std::string Refusal(const std::string& series = "", const std::string& name = "") const {
    return MessageOf([&] { Read(series, name); }, "read");
  }
  // The scan is read whole, with these warnings.
  template <typename Matcher>
  void ExpectRead(const Matcher& warnings, const std::string& name = "") const {
    const Volume read = Read("", name);
    EXPECT_EQ(read.hu, ct_.hu);
    EXPECT_THAT(read.warnings, warnings);
  }

  const Folder folder_;
  const Volume ct_ = BallCt();
};

TEST_F(DicomFolder, FilesOfOtherKindsAreIgnored) {
  Write(ct_);
  WriteBytes(folder_.file("._00.dcm"), std::string("\0\5\x16\7\0\2\0\0Mac OS X", 16) + std::string(200, '\0'));
  for (const char* name : {"Thumbs.db", ".DS_Store", "README", "viewer.exe"}) WriteBytes(folder_.file(name), "text");
  ExpectRead(IsEmpty());
}

TEST_F(DicomFolder, FilesThatOnlyClaimToBeDicomAreLeftOutAndNamed) {
  Write(ct_);
  WriteBytes(folder_.file("empty.dcm"), "");
  WriteBytes(folder_.file("letter.dcm"), "%PDF-1.4 a letter");
  WriteBytes(folder_.file("note.dcm"), "a note");
  WriteBytes(folder_.file("cut.dcm"), Slice(3).substr(0, 300));
  ExpectRead(ElementsAre("1 file was left out: cut.dcm (damaged or cut off)", "1 file was left out: empty.dcm (empty)",
                         "2 files were left out: letter.dcm and 1 more (no DICOM file despite its name)"));
}

TEST_F(DicomFolder, AnEmptyFileInPlaceOfASliceIsNamedAsTheReason) {
  Write(ct_);
  WriteBytes(folder_.file("07.dcm"), "");
  const Volume read = Read();
  EXPECT_EQ(read.size, ct_.size);
  EXPECT_THAT(read.warnings, Contains("1 file was left out: 07.dcm (empty)"));
  ASSERT_EQ(read.gaps.size(), 1u);
  EXPECT_THAT(read.gaps[0].what, HasSubstr("1 slice is missing between 06.dcm and 08.dcm"));
  EXPECT_THAT(read.gaps[0].what, testing::EndsWith("; perhaps " + folder_.file("07.dcm") + ": is empty"));
}

TEST_F(DicomFolder, WhatAFolderHasInsteadOfDicomIsNamed) {
  for (const auto& [name, way_out] :
       {std::pair("scan.nii.gz", "; give the path of scan.nii.gz"),
        std::pair("scan.img", "; give the path of scan.hdr"), std::pair("jaw.stl", "; give the path of jaw.stl"),
        std::pair("a.txt", "image")}) {
    WriteBytes(folder_.file(name), "x");
    if (std::string(name) == "scan.img") WriteBytes(folder_.file("scan.hdr"), "x");
    EXPECT_THAT(Refusal(), testing::EndsWith(way_out)) << name;
    for (const char* written : {name, "scan.hdr"}) std::filesystem::remove(folder_.file(written));
  }
  WriteBytes(folder_.file("00.dcm.gz"), "\x1f\x8b");
  EXPECT_EQ(Refusal(), folder_.file("00.dcm.gz") + ": is packed by gzip; unpack it");
  Write(ct_);
  ExpectRead(ElementsAre("1 file was left out: 00.dcm.gz (packed by gzip)"));
}

TEST_F(DicomFolder, ALocalizerOfItsOwnIsListedAsSuch) {
  Write(ct_);
  Write(BallCt(3), "scout",
        [](DicomBytes& b, int) { b.Set(8, 8, "CS", "ORIGINAL\\PRIMARY\\LOCALIZER").Set(0x20, 0xe, "UI", "1.2.9"); });
  const std::vector<DicomSeries> all = ListDicomSeries(folder_.path());
  ASSERT_EQ(all.size(), 2u);
  EXPECT_EQ(all[0].part_name, "");
  EXPECT_EQ(all[1].part_name, "localizer");
}

TEST_F(DicomFolder, DicomdirAndReportsAreNoImages) {
  Write(ct_);
  const auto no_image = [this](const std::string& sop_class) {
    return Slice(0, [&](DicomBytes& b) { b.Set(8, 0x16, "UI", sop_class).Remove(0x28, 0x10).Remove(0x28, 0x11); });
  };
  WriteBytes(folder_.file("DICOMDIR"), no_image("1.2.840.10008.1.3.10"));
  WriteBytes(folder_.file("dose"), no_image("1.2.840.10008.5.1.4.1.1.88.67"));
  ExpectRead(ElementsAre("1 file was left out: dose (no image)"));
  ExpectRead(ElementsAre("1 file was left out: dose (no image)"), "DICOMDIR");
}

TEST_F(DicomFolder, FilesWithoutPreambleAreRead) {
  const auto write = [this](const std::string& extension, const auto& bytes_of) {
    for (int k = 0; k < ct_.size[2]; ++k) {
      WriteBytes(folder_.file(fmt::format("{:02}{}", k, extension)),
                 bytes_of(DicomBytes(test::DicomSlice(ct_, k, {}))));
    }
    ExpectRead(IsEmpty());
  };
  write(".dcm", [](const DicomBytes& b) { return b.DataSet(false); });
  write(".dcm", [](const DicomBytes& b) { return b.DataSet(true); });
  write(".dcm", [](const DicomBytes& b) { return b.WithoutPreamble(true); });
  std::filesystem::remove_all(folder_.path());
  std::filesystem::create_directory(folder_.path());
  write("", [](const DicomBytes& b) { return b.DataSet(false); });
}

TEST_F(DicomFolder, ADicomFileBeginsWithItsPrefixOrAnEarlyElement) {
  const std::string prefix = std::string(128, 'x') + "DICM";
  EXPECT_TRUE(BeginsLikeDicom(prefix));
  EXPECT_FALSE(BeginsLikeDicom(prefix.substr(0, 131)));
  EXPECT_TRUE(BeginsLikeDicom(std::string("\x08\0\x05\0CS\x0a\0ISO_IR 100", 18)));
  EXPECT_TRUE(BeginsLikeDicom(std::string("\x08\0\x05\0\x0a\0\0\0ISO_IR 100", 18)));
  EXPECT_TRUE(BeginsLikeDicom(std::string("\x02\0\0\0UL\4\0", 8)));
  EXPECT_FALSE(BeginsLikeDicom(std::string("\x08\0\x05\0\0\0\0\x7f", 8)));  // a value of 2 GB
  EXPECT_FALSE(BeginsLikeDicom("P5 1 1 255"));
}

TEST_F(DicomFolder, ThePathOfASliceMeansItsSeries) {
  Write(ct_);
  Write(BallCt(9), "other", [](DicomBytes& b, int) { b.Set(0x20, 0xe, "UI", "1.2.9"); });
  ExpectRead(IsEmpty(), "03.dcm");
  EXPECT_EQ(Read("", "other03.dcm").size[2], 9);
  EXPECT_EQ(Read("1.2.9", "03.dcm").size[2], 9);
  WriteBytes(folder_.file("scout.dcm"),
             Slice(0, [](DicomBytes& b) { b.Set(8, 8, "CS", "ORIGINAL\\PRIMARY\\LOCALIZER"); }));
  EXPECT_THAT(Refusal("", "scout.dcm"), HasSubstr("scout.dcm: is a localizer; give a slice of the CT or its folder"));
}

TEST_F(DicomFolder, WhatDoesNotBelongToTheStackIsLeftOutAndNamed) {
  Write(ct_);
  WriteBytes(folder_.file("a_scout"), Slice(0, [](DicomBytes& b) {
               b.Set(8, 8, "CS", "ORIGINAL\\PRIMARY\\LOCALIZER").Set(0x20, 0xd, "UI", "1.2.77");  // of another study
             }));
  Volume turned = ct_;
  turned.axes_W = glm::dmat3(Vec3(0, 1, 0), Vec3(0, 0, -1), Vec3(1, 0, 0));
  WriteBytes(folder_.file("b_turned"), test::DicomSlice(turned, 0, {}));
  Volume large = ct_;
  large.size = {30, 20, 15};
  large.hu.resize(large.count());
  WriteBytes(folder_.file("c_large"), test::DicomSlice(large, 0, {}));
  test::SliceSpec colour;
  colour.samples = 3;
  WriteBytes(folder_.file("d_colour"), test::DicomSlice(ct_, 0, colour));
  WriteBytes(folder_.file("e_capture"),
             Slice(0, [](DicomBytes& b) { b.Set(8, 0x16, "UI", "1.2.840.10008.5.1.4.1.1.7"); }));
  ExpectRead(ElementsAre(
      "1 file was left out: a_scout (localizer by ImageType)", "1 file was left out: d_colour (colour image)",
      "1 file was left out: e_capture (secondary capture)",
      "1 file was left out: b_turned (another orientation or spacing)", "1 file was left out: c_large (another size)"));
}

TEST_F(DicomFolder, CopiesOfASliceAreLeftOut) {
  Write(ct_);
  WriteBytes(folder_.file("07 (1).dcm"), Slice(7));
  WriteBytes(folder_.file("another"), Slice(7, [](DicomBytes& b) { b.Set(8, 0x103e, "LO", "sent again"); }));
  WriteBytes(folder_.file("cut.dcm"), Slice(7).substr(0, Slice(7).size() - 50));
  ExpectRead(ElementsAre("2 files were left out: 07 (1).dcm and 1 more (copy of another slice)",
                         "1 file was left out: cut.dcm (cut off; there is a whole file of the same slice)"));
}

// Such as those that an archive has sent twice.
TEST_F(DicomFolder, CopiesWithIdentifiersOfTheirOwnAreLeftOut) {
  Write(ct_);
  for (const int k : {3, 7}) {
    WriteBytes(folder_.file(fmt::format("copy{}.dcm", k)),
               Slice(k, [](DicomBytes& b) { b.Set(8, 0x18, "UI", "1.2.777").Set(8, 0x103e, "LO", "sent again"); }));
  }
  ExpectRead(ElementsAre("2 files were left out: copy3.dcm and 1 more (copy of another slice)"));
}

TEST_F(DicomFolder, ASliceThatNamesAnotherStudyIsReadIfItsPlaceIsFree) {
  const auto other_study = [](DicomBytes& b) { b.Set(0x20, 0xd, "UI", "1.2.77"); };
  Write(ct_, "", [&](DicomBytes& b, int k) {
    if (k == 7) other_study(b);
  });
  ExpectRead(ElementsAre("07.dcm names another study than the other slices, and was read with them"));
  Write(ct_);
  WriteBytes(folder_.file("odd.dcm"), Slice(7, [&](DicomBytes& b) {
               other_study(b);
               b.Set(8, 0x18, "UI", "1.2.777");
             }));
  ExpectRead(ElementsAre("1 file was left out: odd.dcm (another study)"));
}

TEST_F(DicomFolder, ACutSliceOfTheSeriesIsNamedAndOneOfAnotherDoesNotMatter) {
  Write(ct_);
  const std::string other = Slice(7, [](DicomBytes& b) { b.Set(0x20, 0xe, "UI", "1.2.9"); });
  WriteBytes(folder_.file("other.dcm"), other.substr(0, other.size() - 100));
  EXPECT_EQ(Read().hu, ct_.hu);
  WriteBytes(folder_.file("07.dcm"), Slice(7).substr(0, Slice(7).size() - 100));
  const Volume read = Read();
  EXPECT_EQ(read.size, ct_.size);
  EXPECT_THAT(read.warnings, Contains("1 file was left out: 07.dcm (cut off or damaged)"));
  ASSERT_EQ(read.gaps.size(), 1u);
  EXPECT_THAT(read.gaps[0].what, testing::EndsWith("; " + folder_.file("07.dcm") + ": the slice is cut off"));
}

TEST_F(DicomFolder, DamagedSlicesAtTheEndAreLeftOut) {
  Write(ct_);
  for (const int k : {0, 1, 14}) {
    WriteBytes(folder_.file(fmt::format("{:02}.dcm", k)), Slice(k).substr(0, Slice(k).size() - 100));
  }
  const Volume read = Read();
  EXPECT_EQ(read.size[2], 12);
  EXPECT_EQ(read.origin_W.z, ct_.origin_W.z + 4);
  EXPECT_THAT(read.warnings, ElementsAre("3 files were left out: 00.dcm and 2 more (cut off or damaged)"));
  EXPECT_EQ(read.gaps.size(), 3u);
}

TEST_F(DicomFolder, TheSeriesThatSuitsAJawIsTakenAndTheOthersAreListed) {
  Write(ct_, "", [](DicomBytes& b, int) { b.Set(0x18, 0x1210, "SH", "H60s"); });
  Write(BallCt(3), "thick", [](DicomBytes& b, int) { b.Set(0x20, 0xe, "UI", "1.2.9"); });
  const std::vector<std::string> warnings = Read().warnings;
  ASSERT_EQ(warnings.size(), 1u);
  EXPECT_EQ(warnings[0],
            "the folder contains 2 CT series; the one that suits a jaw best was taken: 1.2.3.4.5 (CT, 15 slices 2 mm "
            "apart, kernel H60s, synthetic); choose another with --series UID: 1.2.9 (CT, 3 slices 2 mm apart, "
            "synthetic)");
  // With as many slices, the only one with a kernel for bone.
  Write(ct_, "soft", [](DicomBytes& b, int) { b.Set(0x20, 0xe, "UI", "1.2.8").Set(0x18, 0x1210, "SH", "H30s"); });
  EXPECT_THAT(Read().warnings[0], HasSubstr("was taken: 1.2.3.4.5 (CT, 15 slices 2 mm apart, kernel H60s"));
  Write(ct_, "soft", [](DicomBytes& b, int) { b.Set(0x20, 0xe, "UI", "1.2.8").Set(0x18, 0x1210, "SH", "H70s"); });
  EXPECT_THAT(Refusal(), HasSubstr("the folder contains 3 CT series; choose one with --series UID: "));
}

TEST_F(DicomFolder, ScoutViewsInSeriesOfTheirOwnAreListedOnly) {
  Write(ct_);
  for (const char* uid : {"1.2.8", "1.2.9"}) {
    WriteBytes(folder_.file(uid), Slice(0, [&](DicomBytes& b) {
                 b.Set(8, 8, "CS", "ORIGINAL\\PRIMARY\\LOCALIZER").Set(0x20, 0xe, "UI", uid);
               }));
  }
  ExpectRead(ElementsAre(testing::AllOf(HasSubstr("3 CT series; the one that suits a jaw best was taken: 1.2.3.4.5 ("),
                                        HasSubstr("1.2.8 (CT, 1 slice"), HasSubstr("1.2.9 (CT, 1 slice"))));
}

TEST_F(DicomFolder, TwoPatientsWithOneUidAreRefusedAndNamedByFile) {
  Write(BallCt(8));
  Volume next = ct_;
  next.origin_W.z += 100;
  Write(next, "x", [](DicomBytes& b, int) { b.Set(0x10, 0x10, "PN", "OTHER^ONE").Set(8, 0x18, "UI", "1.9"); });
  const std::string refusal = Refusal();
  EXPECT_THAT(refusal,
              HasSubstr("the CT slices are of 2 patients, such as x00.dcm and 00.dcm; choose one with --series"));
  EXPECT_THAT(refusal, testing::Not(HasSubstr("OTHER")));
  EXPECT_THAT(refusal, testing::Not(HasSubstr("SECRET")));
  EXPECT_EQ(Read("1.2.3.4.5#1").size[2], 8);
  EXPECT_EQ(Read("5#2").size[2], 15);
}

TEST_F(DicomFolder, TwoPatientsWithTheirOwnUidsAreRefused) {
  Write(ct_);
  Write(BallCt(6), "x", [](DicomBytes& b, int) { b.Set(0x10, 0x10, "PN", "OTHER^ONE").Set(0x20, 0xe, "UI", "1.2.9"); });
  EXPECT_THAT(Refusal(), HasSubstr("of 2 patients, such as 00.dcm and x00.dcm"));
}

TEST_F(DicomFolder, AFewSlicesOfAnotherPatientAreLeftOut) {
  const auto other = [](DicomBytes& b) { b.Set(0x10, 0x10, "PN", "OTHER^ONE").Set(8, 0x18, "UI", "1.9"); };
  Write(ct_);
  WriteBytes(folder_.file("odd.dcm"), Slice(7, other));
  ExpectRead(ElementsAre("1 file was left out: odd.dcm (of another patient)"));
  EXPECT_THAT(Refusal("", "odd.dcm"), HasSubstr("odd.dcm: names another patient than the other slices; give"));
  // A patient each.
  Write(ct_, "", [](DicomBytes& b, int k) { b.Set(0x10, 0x20, "LO", fmt::format("A{}", k)); });
  EXPECT_EQ(ListDicomSeries(folder_.path()).size(), 16u);
}

TEST_F(DicomFolder, APatientIsKnownByTheIdentifierAndIfItIsMissingByTheName) {
  const auto read = [this](const std::function<void(DicomBytes&, int)>& change) {
    Write(ct_, "", change);
    return ListDicomSeries(folder_.path()).size();
  };
  const auto id = [](DicomBytes& b, const std::string& value) { b.Set(0x10, 0x20, "LO", value); };
  EXPECT_EQ(read([&](DicomBytes& b, int k) {
              id(b, k % 2 == 0 ? "A7" : " a7");
              b.Set(0x10, 0x10, "PN", k % 2 == 0 ? "SECRET^NAME" : "Secret Name");
            }),
            1u);
  EXPECT_EQ(read([&](DicomBytes& b, int k) { id(b, k == 7 ? "" : "A7"); }), 1u);
  EXPECT_EQ(read([&](DicomBytes& b, int k) { id(b, k < 7 ? "A7" : "A8"); }), 2u);
  // One identifier, of two hospitals; slices without a hospital may be of either.
  const auto of_hospital = [&](int without) {
    return read([&, without](DicomBytes& b, int k) {
      id(b, "A7");
      if (k >= without) b.Set(0x10, 0x21, "LO", k < 7 ? "EAST" : "WEST");
    });
  };
  EXPECT_EQ(of_hospital(0), 2u);
  EXPECT_EQ(of_hospital(8), 1u);
}

TEST_F(DicomFolder, AcquisitionsAndPhasesWithOneUidAreToldApart) {
  const auto write = [this](std::uint16_t group, std::uint16_t number, const char* vr) {
    for (const int n : {1, 2}) {
      Write(ct_, std::to_string(n), [&](DicomBytes& b, int k) {
        b.Set(group, number, vr, std::to_string(n)).Set(8, 0x18, "UI", fmt::format("1.9.{}.{}", n, k));
      });
    }
    return ListDicomSeries(folder_.path());
  };
  for (const auto& [group, number, vr, name] :
       {std::tuple(0x20, 0x12, "IS", "acquisition"), std::tuple(0x20, 0x100, "IS", "phase")}) {
    const std::vector<DicomSeries> all =
        write(static_cast<std::uint16_t>(group), static_cast<std::uint16_t>(number), vr);
    ASSERT_EQ(all.size(), 2u);
    EXPECT_EQ(all[0].name(), "1.2.3.4.5#1");
    EXPECT_EQ(all[1].part_name, fmt::format("{} 2", name));
    EXPECT_THAT(Refusal(), HasSubstr("the folder contains 2 CT series; choose one with --series UID: 1.2.3.4.5#1 ("));
    EXPECT_EQ(Read("#2").hu, ct_.hu);
  }
}

TEST_F(DicomFolder, AcquisitionsBetweenEachOthersSlicesAreToldApart) {
  for (const int n : {1, 2}) {
    Volume ct = ct_;
    ct.origin_W.z += n;  // of a distance of 2 mm
    Write(ct, std::to_string(n), [n](DicomBytes& b, int) { b.Set(0x20, 0x12, "IS", std::to_string(n)); });
  }
  EXPECT_EQ(ListDicomSeries(folder_.path()).size(), 2u);
  EXPECT_EQ(Read("#1").size[2], 15);
}

// Each tag in turn is the only one that tells two phases apart: by one value each or, if it dates or counts slices, by
// values that follow each other.
TEST_F(DicomFolder, AnyTagThatGivesWholeStacksTellsThemApart) {
  Volume second = ct_;
  for (std::int16_t& hu : second.hu) hu = static_cast<std::int16_t>(hu + 7);
  const auto write = [&](const std::function<void(DicomBytes&, int, int)>& tell) {
    for (const int n : {1, 2}) {
      Write(n == 1 ? ct_ : second, std::to_string(n), [&](DicomBytes& b, int k) {
        b.Set(8, 0x18, "UI", fmt::format("1.9.{}.{}", n, k));
        tell(b, n, k);
      });
    }
    EXPECT_THAT(Refusal(), HasSubstr("the folder contains 2 CT series; choose one with --series UID: 1.2.3.4.5#1 ("));
    EXPECT_EQ(Read("#1").hu, ct_.hu);
    EXPECT_EQ(Read("#2").hu, second.hu);
    return ListDicomSeries(folder_.path()).back().part_name;
  };
  struct Tag {
    int group, number;
    const char *vr, *name;
    bool follows = true;
  };
  const std::vector<Tag> tags{{8, 0x32, "TM", "acquisition at"},
                              {0x18, 0x60, "DS", "kV", false},
                              {8, 0x33, "TM", "content time"},
                              {0x18, 0x81, "DS", "echo time in ms", false},
                              {8, 0x2a, "DT", "acquisition time"},
                              {0x18, 0x1060, "DS", "trigger time in ms"},
                              {0x28, 0x1050, "DS", "window centre", false}};
  for (const Tag& tag : tags) {
    const auto set = [&tag](DicomBytes& b, int value) {
      b.Set(static_cast<std::uint16_t>(tag.group), static_cast<std::uint16_t>(tag.number), tag.vr,
            std::to_string(value));
    };
    EXPECT_EQ(write([&](DicomBytes& b, int n, int) { set(b, 80 * n); }), fmt::format("{} 160", tag.name));
    if (!tag.follows) continue;
    EXPECT_EQ(write([&](DicomBytes& b, int n, int k) { set(b, 100 * n + k); }), fmt::format("{} 200 to 214", tag.name));
  }
  EXPECT_EQ(write([&](DicomBytes& b, int n, int k) { b.Set(0x20, 0x13, "IS", std::to_string(100 * n + 15 - k)); }),
            "image number 201 to 215");
}

TEST_F(DicomFolder, PhasesInFoldersOfTheirOwnAreToldApart) {
  Volume second = ct_;
  for (std::int16_t& hu : second.hu) hu = static_cast<std::int16_t>(hu + 7);
  for (const char* name : {"rest", "stress"}) std::filesystem::create_directory(folder_.file(name));
  Write(ct_, "rest/");
  Write(second, "stress/");
  EXPECT_EQ(ListDicomSeries(folder_.path()).back().part_name, "folder stress");
  EXPECT_EQ(Read("#2").hu, second.hu);
}

// Values that differ from slice to slice, such as the tube's current, do not divide slices that lie at one place.
TEST_F(DicomFolder, StacksWithHolesAreNotToldApart) {
  Volume second = ct_;
  for (std::int16_t& hu : second.hu) hu = static_cast<std::int16_t>(hu + 7);
  const auto write = [&](int n, const Volume& ct) {
    Write(ct, std::to_string(n), [&](DicomBytes& b, int k) {
      b.Set(0x18, 0x1151, "IS", std::to_string((k * k + n) % 3)).Set(8, 0x18, "UI", fmt::format("1.9.{}.{}", n, k));
    });
  };
  write(1, ct_);
  write(2, second);
  EXPECT_THAT(Refusal(), HasSubstr("lie at the same place"));
}

// Scanners that turn once for each slice number each turn as an acquisition.
TEST_F(DicomFolder, SlicesWithAnAcquisitionEachAreOneStack) {
  Write(ct_, "", [](DicomBytes& b, int k) { b.Set(0x20, 0x12, "IS", std::to_string(k)); });
  ExpectRead(IsEmpty());
}

TEST_F(DicomFolder, ASecondaryModalityIsAskedAbout) {
  Write(ct_, "", [](DicomBytes& b, int) { b.Set(8, 0x60, "CS", "OT"); });
  EXPECT_THAT(Refusal(), testing::EndsWith("has the modality OT, not CT; if it is a CT with Hounsfield units that "
                                           "another program wrote, import it with --as-ct"));
  ImportOptions options;
  options.as_ct = true;
  ImportReport report;
  const Volume read = ReadCt(folder_.path(), options, report);
  EXPECT_EQ(read.hu, ct_.hu);
  EXPECT_THAT(read.warnings,
              ElementsAre("the series has the modality OT, not CT; it was read as a CT because of --as-ct"));
}

TEST_F(DicomFolder, WhoLooksAtTheImportIsShownTheSeriesThatAreUnclear) {
  Write(ct_, "", [](DicomBytes& b, int) { b.Set(8, 0x60, "CS", "OT"); });
  ImportOptions options;
  options.take_ct = [](const std::shared_ptr<const Volume>&) {};
  const auto ask = [&](const char* why, std::size_t count) {
    try {
      Import(folder_.path(), options);
      ADD_FAILURE() << why;
    } catch (const UnclearSeries& e) {
      EXPECT_EQ(e.why(), why);
      ASSERT_EQ(e.series().size(), count);
      ASSERT_EQ(e.pictures.size(), count);
      for (const auto& picture : e.pictures) EXPECT_EQ(picture.size(), 96u * 96);
    }
  };
  ask("the series has the modality OT, not CT", 1);
  Write(ct_, "b", [](DicomBytes& b, int) { b.Set(8, 0x60, "CS", "OT").Set(0x20, 0xe, "UI", "1.2.9"); });
  ask("no series is stated to be a CT", 2);
  for (const char* uid : {"1.2.8", "1.2.7"}) {
    Write(ct_, uid, [uid](DicomBytes& b, int) { b.Set(0x20, 0xe, "UI", uid); });
  }
  ask("the folder contains 2 CT series", 2);
  Write(ct_, "c", [](DicomBytes& b, int) { b.Set(0x10, 0x10, "PN", "OTHER^ONE").Set(0x20, 0xe, "UI", "1.2.6"); });
  ask("the CT slices are of 2 patients", 3);
}

TEST_F(DicomFolder, TextsAreUtf8WithoutControlCharacters) {
  Write(ct_, "", [](DicomBytes& b, int) {
    b.Set(8, 5, "CS", "ISO_IR 100")
        .Set(8, 0x103e, "LO",
             "Sch\xe4"
             "del \x1b[2J");
  });
  EXPECT_EQ(ListDicomSeries(folder_.path())[0].description, "Schädel ?[2J");
}

TEST(DicomText, IsDecodedFromItsCharacterSet) {
  EXPECT_EQ(DecodeDicomText("Buc^J\xe9r\xf4me", "ISO_IR 100"), "Buc^Jérôme");
  EXPECT_EQ(DecodeDicomText("Kiefer \xc3\xbc", "ISO_IR 192"), "Kiefer ü");
  EXPECT_EQ(DecodeDicomText("\xbb\xe7\xda", "ISO_IR 144"), "Лчк");
  EXPECT_EQ(DecodeDicomText("\xcd\xf5", "GB18030"), "王");
  // PS3.5 annexes H and I.
  EXPECT_EQ(DecodeDicomText("\xd4\xcf\xc0\xde^\xc0\xdb\xb3=\x1b$B;3ED\x1b(J^\x1b$BB@O:\x1b(J",
                            "ISO 2022 IR 13\\ISO 2022 IR 87"),
            "ﾔﾏﾀﾞ^ﾀﾛｳ=山田^太郎");
  EXPECT_EQ(DecodeDicomText("Hong=\x1b$)C\xfb\xf3^\x1b$)C\xd1\xce\xd4\xd7", "\\ISO 2022 IR 149"), "Hong=洪^吉洞");
  EXPECT_EQ(DecodeDicomText("\xff\xfe", ""), "ÿþ");  // not UTF-8
  EXPECT_EQ(DecodeDicomText("\x1b$B;", ""), "?");    // half a character
  EXPECT_EQ(DecodeDicomText("\x1b$B\x7f", ""), "?");
  EXPECT_EQ(DecodeDicomText("a\x9b"
                            "31m",
                            "ISO_IR 100"),
            "a?31m");  // a control character of 8 bits
}

struct Member {
  std::string name, bytes;
};

std::string Zip(const Folder& folder, const std::vector<Member>& members) {
  std::string path = folder.file("packed.zip");
  int code = 0;
  zip_t* archive = zip_open(path.c_str(), ZIP_CREATE | ZIP_TRUNCATE, &code);
  for (const Member& m : members) {
    zip_source_t* source = zip_source_buffer(archive, m.bytes.data(), m.bytes.size(), 0);
    zip_file_add(archive, m.name.c_str(), source, 0);
  }
  EXPECT_EQ(zip_close(archive), 0);
  return path;
}

TEST_F(DicomFolder, AZipOfAFolderIsReadAndLeavesNothingBehind) {
  std::vector<Member> members{{"CD/", ""}, {"__MACOSX/._x.dcm", "x"}, {"CD/note.dcm", "a note"}};
  for (int k = 0; k < ct_.size[2]; ++k) members.push_back({fmt::format("CD/IM{}", k), Slice(k)});
  const std::string path = Zip(folder_, members);
  const std::string temporary = folder_.file("temporary");
  std::filesystem::create_directory(temporary);
  setenv("TMPDIR", temporary.c_str(), 1);
  ExpectRead(ElementsAre("1 file was left out: note.dcm (no DICOM file despite its name)"), "packed.zip");
  members.back().bytes.resize(members.back().bytes.size() - 100);
  Zip(folder_, members);
  const Volume read = Read("", "packed.zip");
  EXPECT_EQ(read.size[2], 14);
  ASSERT_EQ(read.gaps.size(), 1u);
  EXPECT_THAT(read.gaps[0].what, testing::EndsWith(path + "/CD/IM14: the slice is cut off"));
  EXPECT_TRUE(std::filesystem::is_empty(temporary));
  unsetenv("TMPDIR");
}

TEST_F(DicomFolder, AZipMayHaveAnyNameAndDamagedFiles) {
  std::vector<Member> members{{"viewer", std::string(500, 'x') + "y"}};
  for (int k = 0; k < ct_.size[2]; ++k) members.push_back({fmt::format("CD/IM{}", k), Slice(k)});
  std::string bytes = test::ReadBytes(Zip(folder_, members));
  bytes[40] = static_cast<char>(bytes[40] ^ 0x55);
  WriteBytes(folder_.file("scan"), bytes);
  std::filesystem::rename(folder_.file("packed.zip"), folder_.file("a.zip"));
  EXPECT_THAT(Refusal(), testing::EndsWith("is a DICOM image; give the path of a.zip"));
  ExpectRead(ElementsAre("1 file was left out: viewer (damaged in the ZIP file)"), "scan");
}

// Such as a video or a PDF of the clinic.
TEST_F(DicomFolder, ALargeFileThatIsNoSliceDoesNotStopAZip) {
  std::vector<Member> members{{"CD/movie.mp4", std::string(std::size_t{100} << 20, '\0')}};
  for (int k = 0; k < ct_.size[2]; ++k) members.push_back({fmt::format("CD/IM{}", k), Slice(k)});
  Zip(folder_, members);
  ExpectRead(ElementsAre("1 file was left out: movie.mp4 (105 MB, no DICOM file)"), "packed.zip");
}

// With blocks that are stored as they are.
std::string Deflate(const std::string& bytes) {
  std::string packed;
  constexpr std::size_t kBlock = 60000;
  for (std::size_t at = 0; at < bytes.size(); at += kBlock) {
    const std::string block = bytes.substr(at, kBlock);
    const auto length = static_cast<std::uint16_t>(block.size());
    packed += static_cast<char>(at + kBlock >= bytes.size());
    for (const unsigned half : {unsigned{length}, ~unsigned{length}}) {
      packed += {static_cast<char>(half & 0xff), static_cast<char>(half >> 8 & 0xff)};
    }
    packed += block;
  }
  return packed;
}

TEST_F(DicomFolder, DeflatedSlicesAreRead) {
  const auto deflated = [this](int k) {
    test::SliceSpec spec;
    spec.transfer_syntax = "1.2.840.10008.1.2.1.99";
    const DicomBytes bytes(test::DicomSlice(ct_, k, spec));
    const std::string data = bytes.DataSet(true);
    const std::string file = bytes.File();
    return file.substr(0, file.size() - data.size()) + Deflate(data);
  };
  for (int k = 0; k < ct_.size[2]; ++k) WriteBytes(folder_.file(fmt::format("{:02}.dcm", k)), deflated(k));
  ExpectRead(IsEmpty());
  WriteBytes(folder_.file("07.dcm"), deflated(7).substr(0, 700));
  const Volume read = Read();
  ASSERT_EQ(read.gaps.size(), 1u);
  EXPECT_THAT(read.gaps[0].what, HasSubstr("07.dcm: the file is cut off: its deflated data set does not unpack"));
}

TEST(DicomZip, NamesDoNotLeadOutOfTheFolder) {
  const Folder folder;
  const std::string path =
      Zip(folder, {{"../../escaped", "a"}, {"/absolute", "b"}, {"d\\..\\c\x1b.dcm", "c"}, {"d", "d"}});
  const std::string target = folder.file("in");
  std::filesystem::create_directory(target);
  UnpackZip(path, target, {});
  std::vector<std::string> names;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(target)) {
    names.push_back(std::filesystem::relative(entry.path(), target));
  }
  EXPECT_THAT(names, testing::UnorderedElementsAre("escaped", "absolute", "d", "d/c\u2190.dcm", "file_3"));
}

TEST(DicomZip, BombsAndDamageAreRefused) {
  const Folder folder;
  const std::string target = folder.file("in");
  std::filesystem::create_directory(target);
  const auto refusal = [&](const std::string& path) { return MessageOf([&] { UnpackZip(path, target, {}); }); };
  std::string zeros(std::size_t{70} << 20, '\0');
  EXPECT_THAT(refusal(Zip(folder, {{"a", zeros}})), HasSubstr("packed.zip: 'a' of 73.4 MB is no DICOM file"));
  zeros.replace(128, 4, "DICM");
  EXPECT_THAT(refusal(Zip(folder, {{"a", zeros}})),
              HasSubstr("packed.zip: would take 0.1 GB when unpacked, more than"));
  const std::string path = Zip(folder, {{"a", std::string(5000, 'x') + "y"}});
  std::string bytes = test::ReadBytes(path);
  bytes[45] = static_cast<char>(bytes[45] ^ 0x55);
  WriteBytes(path, bytes);
  EXPECT_THAT(refusal(path), HasSubstr("packed.zip: is damaged: 'a' can't be unpacked: "));
  WriteBytes(path, bytes.substr(0, 60));
  EXPECT_THAT(refusal(path), HasSubstr("packed.zip: is not a complete ZIP file: "));
  EXPECT_TRUE(std::filesystem::is_empty(target) || std::filesystem::file_size(target + "/a") <= 5001);
}

TEST_F(DicomFolder, TheMiddleSliceIsDrawn) {
  Write(ct_);
  const std::vector<std::uint8_t> picture = DrawMiddleSlice(ListDicomSeries(folder_.path())[0], 24);
  ASSERT_EQ(picture.size(), 576u);
  // 24 x 20 pixels, centred; the ball of 1000 HU lies in the middle of soft tissue of 0 HU.
  EXPECT_EQ(picture[12 * 24 + 12], 255);
  EXPECT_EQ(picture[3 * 24 + 2], 0);
  EXPECT_EQ(picture[0], 0);
}

}  // namespace
}  // namespace kerf
