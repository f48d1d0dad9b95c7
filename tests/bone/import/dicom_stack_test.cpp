// What DICOM files state about the places of slices and their values, and how it is read if something is missing.
#include <gmock/gmock.h>

#include <filesystem>
#include <optional>
#include <set>

#include "bone/import/dicom.h"
#include "bone/import/import.h"
#include "bone/import/padding.h"
#include "ct_files.h"
#include "support/jaw_ct.h"

namespace kerf {
namespace {

using test::Folder;
using test::MessageOf;
using test::WriteBytes;
using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

constexpr std::uint32_t kPositionTag = 0x00200032;
constexpr std::uint32_t kOrientationTag = 0x00200037;
constexpr std::uint32_t kThicknessTag = 0x00180050;
constexpr std::uint32_t kFramesTag = 0x00280008;
constexpr std::uint32_t kHighBitTag = 0x00280102;
constexpr std::uint32_t kBitsStoredTag = 0x00280101;
constexpr std::uint32_t kPaddingTag = 0x00280120;
constexpr std::uint32_t kPaddingLimitTag = 0x00280121;
constexpr std::uint32_t kInterceptTag = 0x00281052;
constexpr std::uint32_t kSlopeTag = 0x00281053;

std::string Whole16(int v) {
  return {static_cast<char>(v & 0xff), static_cast<char>(v >> 8 & 0xff)};
}

std::string Whole32(std::size_t v) {
  return Whole16(static_cast<int>(v & 0xffff)) + Whole16(static_cast<int>(v >> 16));
}

// An element with explicit VR. Sequences and pixels have a long length.
std::string DicomElement(std::uint32_t tag, const std::string& vr, std::string value) {
  if (value.size() % 2 != 0) value += ' ';
  const bool is_long = vr == "SQ" || vr == "OW" || vr == "OB";
  return Whole16(static_cast<int>(tag >> 16)) + Whole16(static_cast<int>(tag & 0xffff)) + vr +
         (is_long ? Whole16(0) + Whole32(value.size()) : Whole16(static_cast<int>(value.size()))) + value;
}

std::string DicomItem(const std::string& content) {
  return Whole16(0xfffe) + Whole16(0xe000) + Whole32(content.size()) + content;
}

// Replaces an element of a file with explicit VR, little-endian, or adds or removes (nullopt) it.
void SetElement(std::string& file, std::uint32_t tag, const std::string& vr, const std::optional<std::string>& value) {
  const auto number = [&file](std::size_t at, int count) {
    std::size_t v = 0;
    for (int n = count - 1; n >= 0; --n)
      v = v << 8 | static_cast<unsigned char>(file[at + static_cast<std::size_t>(n)]);
    return v;
  };
  std::size_t at = 132;
  while (at < file.size()) {
    const std::size_t found = number(at, 2) << 16 | number(at + 2, 2);
    const std::string type = file.substr(at + 4, 2);
    const bool is_long = type == "SQ" || type == "OW" || type == "OB";
    if (found >= tag) {
      if (found == tag) file.erase(at, (is_long ? 12 + number(at + 8, 4) : 8 + number(at + 6, 2)));
      break;
    }
    at += is_long ? 12 + number(at + 8, 4) : 8 + number(at + 6, 2);
  }
  if (value) file.insert(at, DicomElement(tag, vr, *value));
}

// The scan as one file, whose frames are in the given order.
std::string MultiFrame(const Volume& ct, const std::vector<int>& order) {
  test::SliceSpec spec;
  const std::size_t n = static_cast<std::size_t>(ct.size[0]) * ct.size[1];
  for (const int k : order) {
    for (std::size_t v = 0; v < n; ++v) spec.pixels += Whole16(ct.hu[static_cast<std::size_t>(k) * n + v] + 1024);
  }
  std::string file = test::DicomSlice(ct, 0, spec);
  SetElement(file, kFramesTag, "IS", std::to_string(order.size()));
  return file;
}

std::vector<int> Forwards(const Volume& ct) {
  std::vector<int> order;
  for (int k = 0; k < ct.size[2]; ++k) order.push_back(k);
  return order;
}

Volume SevensCt() {
  Volume ct = test::MakeCt({12, 10, 9}, {0.5, 0.75, 2}, {10, -20, 30}, glm::dmat3(1), test::Ball({12.5, -17, 38}, 2.6));
  for (std::size_t v = 0; v < ct.hu.size(); ++v)
    ct.hu[v] = static_cast<std::int16_t>(ct.hu[v] + static_cast<int>(v % 7));
  return ct;
}

Volume ReadSlicesOf(const Folder& folder, double spacing_z_mm = 0) {
  return ReadDicomSeries(ListDicomSeries(folder.path()).front(), {}, spacing_z_mm);
}

Volume ReadOneFile(const std::string& file, double spacing_z_mm = 0) {
  const Folder folder;
  WriteBytes(folder.file("ct.dcm"), file);
  return ReadSlicesOf(folder, spacing_z_mm);
}

void ExpectRead(const Volume& read, const Volume& ct) {
  EXPECT_EQ(read.size, ct.size);
  EXPECT_LT(glm::length(read.origin_W - ct.origin_W), 1e-6);
  EXPECT_LT(glm::length(read.spacing_mm - ct.spacing_mm), 1e-6);
  EXPECT_EQ(read.hu, ct.hu);
}

std::string ShowTriple(const Vec3& p) {
  return fmt::format("{:.6f}\\{:.6f}\\{:.6f}", p.x, p.y, p.z);
}

// Groups of an Enhanced CT: the spacing and direction of all frames, and the place and rescale of each.
std::string EnhancedFile(const Volume& ct, const std::vector<int>& order, const std::function<std::string(int)>& stack,
                         double intercept_step, std::size_t described = 100) {
  std::string file = MultiFrame(ct, order);
  for (const std::uint32_t tag :
       {kPositionTag, kOrientationTag, kThicknessTag, 0x00280030u, kInterceptTag, kSlopeTag}) {
    SetElement(file, tag, "", std::nullopt);
  }
  const std::string shared =
      DicomElement(
          0x00209116, "SQ",
          DicomItem(DicomElement(kOrientationTag, "DS", ShowTriple(ct.axes_W[0]) + "\\" + ShowTriple(ct.axes_W[1])))) +
      DicomElement(0x00289110, "SQ",
                   DicomItem(DicomElement(0x00280030, "DS", fmt::format("{}\\{}", ct.spacing_mm.y, ct.spacing_mm.x))));
  std::string frames;
  for (const int k : order) {
    if (described-- == 0) break;
    frames += DicomItem(
        DicomElement(0x00209111, "SQ", DicomItem(DicomElement(0x00209056, "SH", stack(k)))) +
        DicomElement(0x00209113, "SQ",
                     DicomItem(DicomElement(kPositionTag, "DS", ShowTriple(ct.WorldFromVoxel({0, 0, k}))))) +
        DicomElement(0x00289145, "SQ",
                     DicomItem(DicomElement(kInterceptTag, "DS", fmt::format("{}", -1024 + intercept_step * k)) +
                               DicomElement(kSlopeTag, "DS", "1"))));
  }
  SetElement(file, 0x52009229, "SQ", DicomItem(shared));
  SetElement(file, 0x52009230, "SQ", frames);
  return file;
}

TEST(EnhancedCt, FramesInAnyOrderGiveTheSlicesAtTheirPlaces) {
  const Volume ct = SevensCt();
  for (const std::vector<int>& order : {Forwards(ct), {8, 7, 6, 5, 4, 3, 2, 1, 0}, {4, 0, 8, 2, 6, 1, 7, 3, 5}}) {
    const Volume read = ReadOneFile(EnhancedFile(
        ct, order, [](int) { return "1"; }, 0));
    ExpectRead(read, ct);
    EXPECT_THAT(read.warnings, IsEmpty());
  }
}

TEST(EnhancedCt, FramesWithoutAGroupAreLeftOutAndNamed) {
  const Volume ct = SevensCt();
  const Volume read = ReadOneFile(EnhancedFile(
      ct, Forwards(ct), [](int) { return "1"; }, 0, 7));
  EXPECT_EQ(read.size[2], 7);
  EXPECT_TRUE(std::equal(read.hu.begin(), read.hu.end(), ct.hu.begin()));
  const Folder folder;
  WriteBytes(folder.file("ct.dcm"), EnhancedFile(
                                        ct, Forwards(ct), [](int) { return "1"; }, 0, 7));
  EXPECT_THAT(ListDicomSeries(folder.path()).front().warnings,
              ElementsAre("ct.dcm has 9 frames, but PerFrameFunctionalGroupsSequence (5200,9230) describes only the "
                          "first 7: the others were left out"));
}

TEST(EnhancedCt, EachFrameHasItsOwnRescale) {
  Volume ct = SevensCt();
  const Volume read = ReadOneFile(EnhancedFile(
      ct, Forwards(ct), [](int) { return "1"; }, 10));
  for (std::size_t v = 0; v < ct.hu.size(); ++v)
    ct.hu[v] = static_cast<std::int16_t>(ct.hu[v] + 10 * static_cast<int>(v / 120));
  ExpectRead(read, ct);
}

TEST(EnhancedCt, TheLargestOfSeveralStacksIsReadAndTheOthersAreNamed) {
  const Volume ct = SevensCt();
  const Volume read = ReadOneFile(EnhancedFile(
      ct, Forwards(ct), [](int k) { return k < 6 ? "A" : "B"; }, 0));
  EXPECT_EQ(read.size[2], 6);
  EXPECT_THAT(read.warnings, Contains(HasSubstr("'A' with 6 slices was taken and the others left out: 'B' (3)")));
}

// Each file calls its stack as it likes.
TEST(EnhancedCt, OneStackInTwoFilesIsJoined) {
  const Volume ct = SevensCt();
  const Folder folder;
  WriteBytes(folder.file("a.dcm"), EnhancedFile(
                                       ct, {8, 7, 6, 5}, [](int) { return "2"; }, 0));
  WriteBytes(folder.file("b.dcm"), EnhancedFile(
                                       ct, {0, 1, 2, 3, 4}, [](int) { return "1"; }, 0));
  const Volume read = ReadSlicesOf(folder);
  ExpectRead(read, ct);
  EXPECT_THAT(read.warnings, IsEmpty());
}

TEST(EnhancedCt, ADamagedFrameIsLeftOutAlone) {
  Volume ct = test::JawCt();
  const std::size_t n = static_cast<std::size_t>(ct.size[0]) * ct.size[1];
  std::fill_n(ct.hu.begin() + static_cast<std::ptrdiff_t>(43 * n), n, std::int16_t{-1000});
  const Volume read = ReadOneFile(EnhancedFile(
      ct, Forwards(ct), [](int) { return "1"; }, 0));
  EXPECT_EQ(read.size, ct.size);
  EXPECT_EQ(read.hu[43 * n + n / 2], 40);  // as above and below
  EXPECT_THAT(read.warnings, Contains(HasSubstr("left out: ct.dcm (frame 44) (")));
  ASSERT_EQ(read.gaps.size(), 1u);
}

TEST(EnhancedCt, APartOfAConcatenationMeansTheWhole) {
  const Volume ct = SevensCt();
  const Folder folder;
  const auto write = [&](const std::string& name, const std::vector<int>& order) {
    std::string file = EnhancedFile(
        ct, order, [](int) { return "1"; }, 0);
    SetElement(file, 0x00209161, "UI", "1.2.7");
    WriteBytes(folder.file(name), file);
  };
  write("a.dcm", {0, 1, 2, 3, 4});
  write("b.dcm", {5, 6, 7, 8});
  ExpectRead(ReadDicomSeries(ListDicomSeries(folder.file("b.dcm")).front(), {}), ct);
}

TEST(FramesWithoutPositions, OfTwoFilesAreSpacedByTheirOwnFrames) {
  const Volume ct = SevensCt();
  const Folder folder;
  const auto write = [&](const std::string& name, const std::vector<int>& order) {
    std::string file = MultiFrame(ct, order);
    SetElement(file, kPositionTag, "DS", ShowTriple(ct.WorldFromVoxel({0, 0, order.front()})));
    WriteBytes(folder.file(name), file);
  };
  write("a.dcm", {0, 1, 2, 3, 4});
  write("b.dcm", {5, 6, 7, 8});
  const Volume read = ReadSlicesOf(folder);
  ExpectRead(read, ct);
  EXPECT_THAT(read.warnings,
              ElementsAre(HasSubstr("normal of their plane"), HasSubstr("2 mm apart, by SliceThickness")));
  ExpectRead(ReadSlicesOf(folder, 2), ct);
}

TEST(FramesWithoutPositions, AreSpacedByWhatTheFileStatesWithAWarning) {
  const Volume ct = SevensCt();
  const std::string file = MultiFrame(ct, Forwards(ct));
  const Volume by_thickness = ReadOneFile(file);
  ExpectRead(by_thickness, ct);
  EXPECT_THAT(by_thickness.warnings, Contains(HasSubstr("2 mm apart, by SliceThickness (0018,0050)")));

  std::string by_spacing = file;
  SetElement(by_spacing, kThicknessTag, "DS", "5");
  SetElement(by_spacing, 0x00180088, "DS", "2");
  const Volume contradictory = ReadOneFile(by_spacing);
  ExpectRead(contradictory, ct);
  EXPECT_THAT(contradictory.warnings,
              Contains(HasSubstr("2 mm apart, by SpacingBetweenSlices (0018,0088), although SliceThickness (0018,0050) "
                                 "is 5 mm; check the size of the bone, and correct it with --spacing-z")));

  std::string by_offsets = file;
  SetElement(by_offsets, kThicknessTag, "", std::nullopt);
  SetElement(by_offsets, 0x3004000c, "DS", "0\\2\\4\\6\\8\\10\\12\\14\\16");
  ExpectRead(ReadOneFile(by_offsets), ct);

  std::string undirected = file;
  SetElement(undirected, kOrientationTag, "", std::nullopt);
  const Volume assumed = ReadOneFile(undirected);
  ExpectRead(assumed, ct);
  EXPECT_THAT(assumed.warnings,
              Contains(HasSubstr("rows were taken from right to left and columns from front to back")));
}

TEST(FramesWithoutPositions, AreRefusedWithoutASpacingUnlessItIsGiven) {
  const Volume ct = SevensCt();
  std::string file = MultiFrame(ct, Forwards(ct));
  SetElement(file, kThicknessTag, "", std::nullopt);
  EXPECT_THAT(MessageOf([&] { ReadOneFile(file); }),
              HasSubstr("ct.dcm gives neither the positions of its 9 frames nor their distance, by SliceThickness "
                        "(0018,0050) or SpacingBetweenSlices (0018,0088); state it in mm with --spacing-z"));
  const Volume read = ReadOneFile(file, 2);
  ExpectRead(read, ct);
  EXPECT_THAT(read.warnings, Not(Contains(HasSubstr("mm apart"))));
}

TEST(FramesWithoutPositions, AreToBeCheckedByWhoLooksAtTheImport) {
  const Volume ct = SevensCt();
  const Folder folder;
  Vec3 shown_mm(0);
  ImportOptions options;
  options.check_placing = true;
  options.take_ct = [&](const std::shared_ptr<const Volume>& read) { shown_mm = read->spacing_mm; };
  const auto ask = [&](const std::string& file) -> std::optional<AssumedPlacing> {
    WriteBytes(folder.file("ct.dcm"), file);
    try {
      Import(folder.file("ct.dcm"), options);
    } catch (const NotPlaced& e) {
      return e.placing();
    } catch (const Error& e) {  // it is no mandible
      EXPECT_THAT(e.what(), testing::Not(HasSubstr("--spacing-z")));
    }
    return std::nullopt;
  };
  std::string file = MultiFrame(ct, Forwards(ct));
  std::optional<AssumedPlacing> placing = ask(file);
  ASSERT_TRUE(placing);
  EXPECT_EQ(placing->spacing_mm, 2);
  EXPECT_EQ(placing->spacing_from, "SliceThickness (0018,0050)");
  EXPECT_TRUE(placing->has_orientation);
  EXPECT_EQ(placing->axis, 2);
  std::string contradictory = file;
  SetElement(contradictory, 0x00180088, "DS", "1");
  placing = ask(contradictory);
  ASSERT_TRUE(placing);
  EXPECT_EQ(placing->spacing_from, "SpacingBetweenSlices (0018,0088); SliceThickness (0018,0050): 2 mm");

  // Coronal slices, and nothing that tells how far apart: as far as the pixels.
  SetElement(file, kThicknessTag, "", std::nullopt);
  SetElement(file, kOrientationTag, "DS", "1\\0\\0\\0\\0\\-1");
  placing = ask(file);
  ASSERT_TRUE(placing);
  EXPECT_EQ(placing->spacing_mm, 0.5);
  EXPECT_EQ(placing->spacing_from, "");
  EXPECT_EQ(placing->axis, 1);
  EXPECT_EQ(shown_mm, Vec3(0.5, 0.5, 0.75));

  SetElement(file, kOrientationTag, "", std::nullopt);
  placing = ask(file);
  ASSERT_TRUE(placing);
  EXPECT_FALSE(placing->has_orientation);

  EXPECT_FALSE(ask(EnhancedFile(
      ct, Forwards(ct), [](int) { return "1"; }, 0)));
}

TEST(FramesWithoutPositions, ACutOffFileIsRefused) {
  const Volume ct = SevensCt();
  const std::string file = MultiFrame(ct, Forwards(ct));
  EXPECT_THAT(MessageOf([&] { ReadOneFile(file.substr(0, file.size() - 2)); }), HasSubstr("cut off"));
}

// Writes the slices of a scan, each changed by `change`, which returns false to leave it out.
void WriteSlices(const Volume& ct, const Folder& folder, const std::function<bool(int, std::string&)>& change) {
  for (int k = 0; k < ct.size[2]; ++k) {
    std::string file = test::DicomSlice(ct, k, {});
    if (change(k, file)) WriteBytes(folder.file(fmt::format("{:03}.dcm", k)), file);
  }
}

TEST(SpacingGiven, IsRefusedWhereTheFilesStateIt) {
  const Folder folder;
  test::WriteDicom(SevensCt(), folder.path());
  EXPECT_THAT(MessageOf([&] { ReadSlicesOf(folder, 2); }), HasSubstr("leave out --spacing-z"));
}

TEST(Rescale, WhatIsNoNumberIsRefusedByFileAndTag) {
  for (const std::string value : {"0", "abc", "nan", "", "1\\2"}) {
    const Folder folder;
    WriteSlices(SevensCt(), folder, [&](int k, std::string& file) {
      if (k >= 3) SetElement(file, kSlopeTag, "DS", value);
      return true;
    });
    EXPECT_THAT(MessageOf([&] { ReadSlicesOf(folder); }),
                HasSubstr("6 of its 9 slices can't be read, such as 003.dcm: its RescaleSlope (0028,1053) is"))
        << value;
  }
}

TEST(Rescale, OfOneSliceUnlikeTheOthersLeavesItOut) {
  const auto write = [](const Folder& folder, bool usual) {
    WriteSlices(SevensCt(), folder, [usual](int k, std::string& file) {
      if ((k == 8) != usual) return true;
      SetElement(file, kSlopeTag, "", std::nullopt);
      SetElement(file, kInterceptTag, "", std::nullopt);
      return true;
    });
  };
  for (const bool usual : {true, false}) {
    const Folder folder;
    write(folder, usual);
    const Volume read = ReadSlicesOf(folder);
    EXPECT_EQ(read.size[2], 8);
    EXPECT_THAT(read.warnings,
                ElementsAre(fmt::format("1 file was left out: 008.dcm (it has {}RescaleSlope (0028,1053) and "
                                        "RescaleIntercept (0028,1052), unlike the other slices)",
                                        usual ? "no " : "")));
  }
}

TEST(StoredBits, OverlaysAboveTheValueAreIgnoredAndAWrongHighBitIsRefused) {
  const Volume ct = SevensCt();
  const Folder good, wrong;
  const auto with = [](int high_bit) {
    return [high_bit](int, std::string& file) {
      SetElement(file, kBitsStoredTag, "US", Whole16(12));
      SetElement(file, kHighBitTag, "US", Whole16(high_bit));
      // Two overlays, in bits 14 and 15.
      file[file.size() - 1] = static_cast<char>(file[file.size() - 1] | 0x40);
      file[file.size() - 3] = static_cast<char>(file[file.size() - 3] | 0x80);
      return true;
    };
  };
  WriteSlices(ct, good, with(11));
  ExpectRead(ReadSlicesOf(good), ct);
  WriteSlices(ct, wrong, with(15));
  EXPECT_THAT(MessageOf([&] { ReadSlicesOf(wrong); }), HasSubstr("its HighBit (0028,0102) is 15, but 12 of 16 bits"));
}

// Slices whose four corner pixels are `stored`.
void WritePadded(const Volume& ct, const Folder& folder, int stored, const std::function<void(std::string&)>& tag) {
  WriteSlices(ct, folder, [&](int, std::string& file) {
    const std::size_t start = file.size() - 2 * static_cast<std::size_t>(ct.size[0] * ct.size[1]);
    const int w = ct.size[0], n = ct.size[0] * ct.size[1];
    for (const int v : {0, w - 1, n - w, n - 1})
      file.replace(start + 2 * static_cast<std::size_t>(v), 2, Whole16(stored));
    tag(file);
    return true;
  });
}

TEST(Padding, IsAirWithAndWithoutItsTag) {
  Volume ct = SevensCt();
  for (std::size_t v = 0; v < ct.hu.size(); ++v) {
    const std::size_t in_slice = v % 120;
    if (in_slice == 0 || in_slice == 11 || in_slice == 108 || in_slice == 119) ct.hu[v] = -1024;
  }
  const std::vector<std::function<void(std::string&)>> tags{
      [](std::string&) {}, [](std::string& file) { SetElement(file, kPaddingTag, "US", Whole16(63536)); },
      [](std::string& file) { SetElement(file, kPaddingTag, "SS", Whole16(63536)); },
      [](std::string& file) {
        SetElement(file, kPaddingTag, "US", Whole16(65000));
        SetElement(file, kPaddingLimitTag, "US", Whole16(63000));
      }};
  for (const auto& tag : tags) {
    const Folder folder;
    WritePadded(SevensCt(), folder, 63536, tag);
    const Volume read = ReadSlicesOf(folder);
    ExpectRead(read, ct);
    ASSERT_EQ(read.warnings.size(), 1u);
    EXPECT_THAT(read.warnings[0], HasSubstr("36 voxels"));
  }
}

TEST(Padding, IsRecognisedInVolumesAndOtherValuesAreKept) {
  Volume ct = SevensCt();
  EXPECT_EQ(ClearPadding(ct), 0u);
  EXPECT_EQ(ct.hu, SevensCt().hu);
  ct.hu[500] = 15000;  // metal
  ct.hu[501] = -1500;  // an artefact beside it
  const std::vector<std::int16_t> with_metal = ct.hu;
  EXPECT_EQ(ClearPadding(ct), 0u);
  EXPECT_EQ(ct.hu, with_metal);
  for (std::size_t v = 0; v < 12; ++v) ct.hu[v] = -32768;
  EXPECT_EQ(ClearPadding(ct), 13u);  // and the artefact
  EXPECT_EQ(ct.hu[0], -1024);
  EXPECT_EQ(ct.hu[500], 15000);
}

TEST(Padding, OfOneBrightValueOutsideTheCircleIsAir) {
  Volume ct = test::JawCt(4);
  ct.hu[ct.hu.size() / 2] = 3071;  // metal
  for (const int bright : {1500, 2500}) {
    Volume padded = ct;
    std::size_t outside = 0;
    for (int v = 0; v < static_cast<int>(ct.hu.size()); ++v) {
      const double x = v % ct.size[0] - 0.5 * (ct.size[0] - 1);
      const double y = v / ct.size[0] % ct.size[1] - 0.5 * (ct.size[1] - 1);
      if (x * x + y * y < 17 * 17) continue;
      padded.hu[static_cast<std::size_t>(v)] = static_cast<std::int16_t>(bright);
      ++outside;
    }
    EXPECT_EQ(ClearPadding(padded), outside);
    EXPECT_THAT(padded.warnings, ElementsAre(HasSubstr(fmt::format("with the value {} HU are padding", bright))));
  }
  // Air of grey values, which is as bright, has nothing darker.
  for (std::int16_t& hu : ct.hu) hu = static_cast<std::int16_t>(hu + 2500);
  EXPECT_EQ(ClearPadding(ct), 0u);
}

TEST(Padding, SingleVoxelsBeyondMetalGetTheValueOfANeighbour) {
  Volume ct = SevensCt();
  ct.hu[500] = 32767;
  ct.hu[700] = ct.hu[701] = 32767;  // two together are metal
  EXPECT_EQ(ClearPadding(ct), 0u);
  EXPECT_LE(ct.hu[500], 1006);
  EXPECT_EQ(ct.hu[700], 32767);
  ASSERT_EQ(ct.warnings.size(), 1u);
  EXPECT_THAT(ct.warnings[0], HasSubstr("1 single voxels"));
}

TEST(SliceSpacing, RoundedPositionsAreMadeEvenAndTheErrorIsStated) {
  Volume ct = SevensCt();
  ct.spacing_mm.z = 0.25;
  const Folder folder;
  WriteSlices(ct, folder, [&](int k, std::string& file) {
    SetElement(file, kPositionTag, "DS", fmt::format("10\\-20\\{:.1f}", 30 + 0.25 * k + 1e-9));
    return true;
  });
  const Volume read = ReadSlicesOf(folder);
  EXPECT_EQ(read.hu, ct.hu);
  // Rounding moves each by at most 0.05 mm.
  EXPECT_NEAR(read.origin_W.z, 30, 0.05);
  EXPECT_NEAR(read.spacing_mm.z, 0.25, 0.1 / 8);
  EXPECT_THAT(read.warnings, Contains(HasSubstr("the positions of the slices are rounded")));
}

// Steps of 2 and 4 mm are no rounded steps of 3 mm.
TEST(SliceSpacing, EveryThirdSliceMissingIsNoRounding) {
  Volume ct = SevensCt();
  ct.size[2] = 24;
  ct.hu.resize(ct.count());
  const Folder folder;
  WriteSlices(ct, folder, [](int k, std::string&) { return k % 3 != 2; });
  EXPECT_THAT(MessageOf([&] { ReadSlicesOf(folder); }), HasSubstr("1 slice is missing between 001.dcm and 003.dcm"));
}

TEST(PixelData, OfAThumbnailIsNotTaken) {
  const Volume ct = SevensCt();
  const Folder folder;
  WriteSlices(ct, folder, [&ct](int, std::string& file) {
    const std::string zeros(std::size_t{2} * ct.size[0] * ct.size[1], '\0');
    SetElement(file, 0x00880200, "SQ", DicomItem(DicomElement(0x7fe00010, "OW", zeros)));
    return true;
  });
  ExpectRead(ReadSlicesOf(folder), ct);
}

TEST(SliceSpacing, ThickerSlicesAboveThinOnesAreResampled) {
  Volume ct = SevensCt();
  ct.hu.clear();
  ct.size[2] = 25;
  for (int v = 0; v < 25 * 120; ++v) ct.hu.push_back(static_cast<std::int16_t>(10 * (v / 120)));  // linear along z
  const Folder folder;
  WriteSlices(ct, folder, [](int k, std::string&) { return k < 12 || k % 2 == 0; });
  // What belongs to no stack does not make the uneven slices an error.
  test::SliceSpec colour;
  colour.samples = 3;
  WriteBytes(folder.file("capture.dcm"), test::DicomSlice(ct, 0, colour));
  const Volume read = ReadSlicesOf(folder);
  ExpectRead(read, ct);
  EXPECT_THAT(read.gaps, IsEmpty());
  EXPECT_THAT(read.warnings, Contains(HasSubstr("all were resampled to 2.00 mm by linear interpolation")));
}

class MissingSlice : public ::testing::Test {
 protected:
  void Write(int missing) { Write(std::set{missing}); }
  void Write(const std::set<int>& missing) {
    WriteSlices(test::JawCt(), folder_, [&missing](int k, std::string&) { return missing.count(k) == 0; });
    options_.voxel_mm = 1;
  }
  const Folder folder_;
  ImportOptions options_;
};

TEST_F(MissingSlice, BeyondTheJawDoesNotMatterAndIsSaid) {
  Write(43);
  const ImportReport report = Import(folder_.path(), options_).report;
  const Folder whole;
  test::WriteDicom(test::JawCt(), whole.path());
  // The tip of the jaw ends beside the missing slice.
  EXPECT_NEAR(report.iso_mm3 / Import(whole.path(), options_).report.iso_mm3, 1, 0.005);
  EXPECT_THAT(report.warnings, Contains(HasSubstr("1 slice is missing between 042.dcm and 044.dcm")));
}

// The file is there, but cut off, can't be unpacked, or is empty.
TEST_F(MissingSlice, ADamagedFileIsAMissingSlice) {
  const Volume ct = test::JawCt();
  test::SliceSpec spoilt;
  spoilt.transfer_syntax = "1.2.840.10008.1.2.4.70";
  spoilt.encapsulated = true;
  spoilt.pixels = "these are not the bytes of a JPEG";
  Write(-1);
  const double whole_mm3 = Import(folder_.path(), options_).report.iso_mm3;
  for (const int damaged : {12, 43}) {
    const std::string whole = test::DicomSlice(ct, damaged, {});
    for (const std::string& bytes :
         {whole.substr(0, whole.size() - 100), test::DicomSlice(ct, damaged, spoilt), std::string()}) {
      Write(-1);
      const std::string file = fmt::format("{:03}.dcm", damaged);
      WriteBytes(folder_.file(file), bytes);
      if (damaged == 12) {
        EXPECT_THAT(MessageOf([&] { Import(folder_.path(), options_); }), HasSubstr(file + ": "));
        continue;
      }
      const ImportReport report = Import(folder_.path(), options_).report;
      EXPECT_THAT(report.warnings, Contains(HasSubstr("1 file was left out: 043.dcm (")));
      EXPECT_NEAR(report.iso_mm3 / whole_mm3, 1, 0.005);
    }
  }
}

// One file of the series is as another program or a slip of the hand left it.
TEST_F(MissingSlice, AFaultySliceIsAMissingSlice) {
  Write(-1);
  const double whole_mm3 = Import(folder_.path(), options_).report.iso_mm3;
  using Spoil = std::function<void(std::string&)>;
  const auto set = [](std::uint32_t tag, const std::string& vr, const std::string& value) -> Spoil {
    return [=](std::string& file) { SetElement(file, tag, vr, value); };
  };
  const auto moved = [](const Vec3& by_mm, int k) {
    return ShowTriple(test::JawCt().WorldFromVoxel({0, 0, k}) + by_mm);
  };
  for (const int k : {12, 44}) {
    const std::vector<std::pair<std::string, Spoil>> faults{
        {"its RescaleSlope (0028,1053) is '0', not a number other than 0", set(kSlopeTag, "DS", "0")},
        {"its RescaleSlope (0028,1053) is 'abc', not a number other than 0", set(kSlopeTag, "DS", "abc")},
        {"its RescaleSlope (0028,1053) is empty, not a number other than 0", set(kSlopeTag, "DS", "")},
        {"its RescaleIntercept (0028,1052) is 'x', not a number", set(kInterceptTag, "DS", "x")},
        {"its HighBit (0028,0102) is 11, but 16 of 16 bits are stored", set(kHighBitTag, "US", Whole16(11))},
        {"it is stored for inverted display (MONOCHROME1)", set(0x00280004, "CS", "MONOCHROME1")},
        {"of another patient", set(0x00100010, "PN", "OTHER^ONE")},
        {"it is shifted sideways by 5.00 mm relative to the others", set(kPositionTag, "DS", moved({3, 4, 0}, k))},
        {"it lies 0.80 mm beside the even places of the others", set(kPositionTag, "DS", moved({0, 0, 0.8}, k))},
        {"without position, orientation or pixel spacing", set(kPositionTag, "DS", "")}};
    for (const auto& [what, spoil] : faults) {
      std::string file = test::DicomSlice(test::JawCt(), k, {});
      spoil(file);
      WriteBytes(folder_.file(fmt::format("{:03}.dcm", k)), file);
      if (k == 12) {
        const std::string refusal = MessageOf([&] { Import(folder_.path(), options_); });
        EXPECT_THAT(refusal, HasSubstr("1 slice is missing between 011.dcm and 013.dcm"));
        EXPECT_THAT(refusal, HasSubstr("012.dcm: "));
        continue;
      }
      const ImportReport report = Import(folder_.path(), options_).report;
      EXPECT_THAT(report.warnings, Contains(testing::StartsWith("1 file was left out: 044.dcm (" + what)));
      EXPECT_NEAR(report.iso_mm3 / whole_mm3, 1, 0.005);
    }
    Write(-1);
  }
}

TEST_F(MissingSlice, TwoSlicesAtOnePlaceAreBothLeftOut) {
  Write(-1);
  std::string file = test::DicomSlice(test::JawCt(), 44, {});
  SetElement(file, kPositionTag, "DS", ShowTriple(test::JawCt().WorldFromVoxel({0, 0, 43})));
  file[file.size() - 2] = 5;  // no copy of the other slice
  WriteBytes(folder_.file("044.dcm"), file);
  EXPECT_THAT(
      Import(folder_.path(), options_).report.warnings,
      Contains(HasSubstr("2 files were left out: 043.dcm and 1 more (043.dcm and 044.dcm lie at the same place")));
}

TEST_F(MissingSlice, ManySlicesBesideTheOthersAreRefused) {
  WriteSlices(test::JawCt(), folder_, [](int k, std::string& file) {
    if (k % 8 == 3) SetElement(file, kPositionTag, "DS", ShowTriple(test::JawCt().WorldFromVoxel({2, 0, k})));
    return true;
  });
  EXPECT_THAT(MessageOf([&] { ReadSlicesOf(folder_); }),
              HasSubstr("6 of its 45 slices can't be read, such as 003.dcm: it is shifted sideways by 4.00 mm"));
}

// The bone lies on one side of the missing slices only.
TEST_F(MissingSlice, AtTheEndOfTheJawEndsItThere) {
  const Volume ct = test::JawCt();
  const Isolation isolation = Isolate(ct, {}, {});
  double top_mm = -100;
  std::size_t below = 0;
  const auto count = [&](auto&& is_counted) {
    for (std::size_t v = 0; v < isolation.bone.size(); ++v) {
      if (isolation.bone[v] == 0) continue;
      const int k = static_cast<int>(v / (static_cast<std::size_t>(isolation.ct.size[0]) * isolation.ct.size[1]));
      is_counted(isolation.ct.WorldFromVoxel({0, 0, k}).z);
    }
  };
  count([&](double z) { top_mm = std::max(top_mm, z); });
  const int top = static_cast<int>(std::lround((top_mm - ct.origin_W.z) / 2));
  const double last_mm = top_mm - 4;  // what was scanned of it
  count([&](double z) { below += z < last_mm + 1 ? 1 : 0; });
  Write(std::set{top - 1, top});
  const ImportReport report = Import(folder_.path(), options_).report;
  EXPECT_NEAR(report.iso_mm3, static_cast<double>(below) * 8, 1);
  EXPECT_GT(report.box.upper.z, last_mm - 0.5);
  EXPECT_LT(report.box.upper.z, last_mm + 3);  // half the gap
  EXPECT_THAT(report.warnings, Contains(HasSubstr("was ended there; up to 6.00 mm of it may be missing")));
}

TEST_F(MissingSlice, InsideTheJawIsRefusedByName) {
  Write(12);
  EXPECT_THAT(MessageOf([&] { Import(folder_.path(), options_); }),
              HasSubstr("1 slice is missing between 011.dcm and 013.dcm (at -23.60 and -19.60 mm"));
}

}  // namespace
}  // namespace kerf
