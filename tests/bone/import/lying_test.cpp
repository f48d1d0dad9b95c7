// Scans whose headers declare more data than the files contain are refused with a one-sentence message, without
// allocating the memory.
#include <fmt/format.h>
#include <gmock/gmock.h>

#include <algorithm>
#include <array>
#include <cstdlib>
#include <iostream>
#include <map>

#include "bone/import/dicom.h"
#include "bone/import/image_file.h"
#include "ct_files.h"
#include "kerf/error.h"
#include "support/folder.h"
#include "support/memory_limit.h"
#include "support/one_core.h"

namespace kerf {
namespace {

using test::SliceSpec;

struct Lie {
  std::string name;                   // file name
  std::vector<std::string> contents;  // contents of the file, or of each slice
  std::string said;
};

Volume Shape(int side) {
  Volume ct;
  ct.size = {side, side, 3};
  ct.spacing_mm = Vec3(0.1, 0.1, 1);
  return ct;
}

std::string Nrrd(int side, const std::string& encoding) {
  std::string header = test::NrrdHeader(Shape(side));
  header.replace(header.find("raw"), 3, encoding);
  return header + "\n" + std::string(30, 'x');
}

/// Returns a slice with a sequence of 20 bytes whose item declares a value of 4 GB.
std::string NestedLie() {
  const std::string lie = std::string("\x08\x00\x40\x11SQ\0\0\x14\0\0\0", 12) +
                          std::string("\xfe\xff\x00\xe0\x0c\0\0\0", 8) +
                          std::string("\x08\x00\x60\x00OB\0\0\xf0\xff\xff\xff", 12);
  std::string slice =
      test::DicomSlice(test::MakeCt({4, 4, 3}, Vec3(1), Vec3(0), glm::dmat3(1), test::Ball(Vec3(2), 1)), 0, {});
  const std::size_t at = slice.find(std::string("\x08\x00\x60\x00", 4));
  return slice.insert(at, lie);
}

/// Returns a slice with items nested deeper than GDCM's stack allows.
std::string DeepLie() {
  std::string lie;
  for (int n = 0; n < 500'000; ++n) {
    lie +=
        std::string("\x08\x00\x40\x11SQ\0\0\xff\xff\xff\xff", 12) + std::string("\xfe\xff\x00\xe0\xff\xff\xff\xff", 8);
  }
  std::string slice =
      test::DicomSlice(test::MakeCt({4, 4, 3}, Vec3(1), Vec3(0), glm::dmat3(1), test::Ball(Vec3(2), 1)), 0, {});
  return slice.insert(slice.find(std::string("\x08\x00\x60\x00", 4)), lie);
}

std::string Gzip(const std::string& bytes) {
  const test::Folder folder;
  test::WriteBytes(folder.file("a"), bytes);
  EXPECT_EQ(std::system(("gzip -n '" + folder.file("a") + "'").c_str()), 0);
  return test::ReadBytes(folder.file("a.gz"));
}

/// Returns a stream of two megabytes that unpacks to 2^31 zeros.
std::string PackedZeros() {
  const std::string one = Gzip(std::string(std::size_t{1} << 20, '\0'));
  std::string all;
  for (int n = 0; n < 2048; ++n) all += one;
  return all;
}

/// Returns the headers of compressed images of `size` voxels of 16 bits, by their files' names.
std::map<std::string, std::string> PackedHeaders(const std::array<int, 3>& size) {
  Volume ct;
  ct.size = size;
  std::string nrrd = test::NrrdHeader(ct);
  nrrd.replace(nrrd.find("raw"), 3, "gzip");
  const std::string meta = fmt::format(
      "ObjectType = Image\nNDims = 3\nBinaryData = True\nBinaryDataByteOrderMSB = False\nCompressedData = True\n"
      "ElementSpacing = 1 1 1\nDimSize = {} {} {}\nElementType = MET_SHORT\nElementDataFile = LOCAL\n",
      size[0], size[1], size[2]);
  return {{"a.nii.gz", Gzip(test::NiftiHeader(ct))}, {"a.nrrd", nrrd + "\n"}, {"a.mha", meta}};
}

std::vector<Lie> MakeLies() {
  SliceSpec packed;
  packed.transfer_syntax = "1.2.840.10008.1.2.5";  // RLE
  packed.encapsulated = true;
  packed.pixels = std::string(64, '\0');
  SliceSpec deflated;
  deflated.transfer_syntax = "1.2.840.10008.1.2.1.99";
  deflated.pixels = std::string(32, '\0');
  std::string channels =
      "ObjectType = Image\nNDims = 3\nDimSize = 2 2 2\nElementType = MET_SHORT\nElementNumberOfChannels = 1000000000\n"
      "ElementDataFile = LOCAL\n";
  std::vector<std::string> slices;
  for (int k = 0; k < 3; ++k) slices.push_back(test::DicomSlice(Shape(8192), k, packed));
  return {{"a.nrrd", {Nrrd(26000, "raw")}, "the header states 26000 x 26000 x 3 voxels"},
          {"a.nrrd", {Nrrd(26000, "gzip")}, "the header states 26000 x 26000 x 3 voxels"},
          {"a.nrrd", {Nrrd(26000, "bzip2")}, "the header states 26000 x 26000 x 3 voxels"},
          {"a.nrrd", {Nrrd(60000, "raw")}, "more than the 2^31 that kerf reads"},
          {"a.mha", {channels}, "a voxel has 2000000000 bytes"},
          {"a.dcm", slices, "its header states 8192 x 8192 pixels of 16 bits, but not all are present"},
          {"a.dcm", {test::DicomSlice(Shape(40000), 0, packed)}, "a slice of 40000 x 40000 pixels, more than the 2^26"},
          {"a.dcm", {test::DicomSlice(Shape(4), 0, deflated)}, "its deflated data set does not unpack to its end"},
          {"a.dcm", {NestedLie()}, "element (0008,0060) is 4294967280 bytes long but only 0 are left"},
          {"a.dcm", {DeepLie()}, "are nested more than 64 deep"}};
}

std::string Read(const Lie& lie, const test::Folder& folder) {
  for (std::size_t k = 0; k < lie.contents.size(); ++k) {
    test::WriteBytes(folder.file(fmt::format("{}{}", k, lie.name)), lie.contents[k]);
  }
  return test::MessageOf(
      [&] {
        if (lie.name == "a.dcm") {
          const auto series = ListDicomSeries(folder.path());
          ReadDicomSeries(ChooseSeries(series, "", folder.path()), {});
        } else {
          ReadImageFile(folder.file("0" + lie.name));
        }
      },
      "accepted");
}

/// Reads compressed images whose voxels are 2^31 zeros. Returns what is wrong.
std::string ReadPackedZeros() {
  const std::string zeros = PackedZeros();
  for (const auto& [name, header] : PackedHeaders({1024, 1024, 1024})) {
    const test::Folder folder;
    const std::string said = Read({name, {header + zeros}, ""}, folder);
    if (said.find("the compressed image has 1073741824 values, which take 4.0 GiB of memory") == std::string::npos)
      return fmt::format("{}: {}", name, said);
  }
  for (const auto& [name, header] : PackedHeaders({16, 16, 16})) {
    const test::Folder folder;
    test::WriteBytes(folder.file(name), header + zeros);
    const Volume read = ReadImageFile(folder.file(name));
    if (read.hu.size() != 4096) return fmt::format("{}: {} voxels", name, read.hu.size());
    const bool warned = std::any_of(read.warnings.begin(), read.warnings.end(), [](const std::string& warning) {
      return warning.find("at least 16 slices more; they were left out") != std::string::npos;
    });
    if (!warned) return name + ": no warning";
  }
  return "";
}

[[noreturn]] void ReadAllLies() {
  test::UseOneCore();
  test::LimitMemory(std::uint64_t{256} << 20);
  if (const std::string wrong = ReadPackedZeros(); !wrong.empty()) {
    std::cerr << wrong << "\n";
    std::_Exit(1);
  }
  for (const Lie& lie : MakeLies()) {
    const test::Folder folder;
    const std::string said = Read(lie, folder);
    if (said.find(lie.said) != std::string::npos) continue;
    std::cerr << "expected '" << lie.said << "' but it was '" << said << "'\n";
    std::_Exit(1);
  }
  std::_Exit(0);
}

TEST(LyingScan, IsRefusedInOneSentenceWithoutAllocation) {
  testing::FLAGS_gtest_death_test_style = "threadsafe";
  EXPECT_EXIT(ReadAllLies(), testing::ExitedWithCode(0), "");
}

}  // namespace
}  // namespace kerf
