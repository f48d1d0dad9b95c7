// Scans with a few changed bytes: whatever the libraries do with them, kerf either reads them or refuses them with a
// one-sentence message.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>

#include <algorithm>
#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <iostream>
#include <new>
#include <random>
#include <string>
#include <vector>

#include "base/files/child.h"
#include "bone/import/dicom.h"
#include "bone/import/image_file.h"
#include "bone/import/packed_segments.h"
#include "ct_files.h"
#include "dicom_segments_file.h"
#include "kerf/error.h"
#include "support/folder.h"

namespace kerf {
namespace {

Volume SmallCt() {
  return test::MakeCt({6, 5, 4}, Vec3(0.5, 0.5, 1), Vec3(0), glm::dmat3(1), test::Ball(Vec3(1.5), 1));
}

/// Changes 1 to 4 bytes, cuts off the end, or repeats a part.
std::string Damage(std::string bytes, std::mt19937_64& random) {
  const auto at = [&] { return random() % bytes.size(); };
  const auto kind = random() % 16;
  if (kind == 0) return bytes.substr(0, at());
  if (kind == 1) return bytes.insert(at(), bytes.substr(at(), random() % 64));
  for (auto n = random() % 4 + 1; n > 0; --n) bytes[at()] = static_cast<char>(random());
  return bytes;
}

struct Counts {
  int read = 0, refused = 0, failed = 0;  // failed: refused because the library that reads it crashed
};

template <typename Read>
void Try(Read&& read, Counts& counts) {
  try {
    read();
    ++counts.read;
  } catch (const Error& e) {
    ++counts.refused;
    const std::string said = e.what();
    EXPECT_FALSE(said.empty());
    EXPECT_EQ(said.find('\n'), std::string::npos) << said;
    if (said.find("the library that reads it failed") != std::string::npos) ++counts.failed;
  }
}

// Reading pipes and devices could continue forever, or wait forever for a writer.
TEST(DamagedFiles, PipesAndDevicesAreRefused) {
  const test::Folder folder;
  const auto message = [](const std::string& path) { return test::MessageOf([&] { ReadImageFile(path); }); };
  for (const char* name : {"a.nii", "a.nii.gz", "a.nrrd", "a.mha"}) {
    const std::string path = folder.file(name);
    ASSERT_EQ(mkfifo(path.c_str(), 0600), 0);
    EXPECT_EQ(message(path), path + ": is not a regular file");
  }
  test::WriteBytes(folder.file("long"), std::string(std::size_t{3} << 20, 'x'));
  for (const std::string data_file : {"/dev/zero", "long"}) {
    const std::string path = folder.file("b.nhdr");
    test::WriteBytes(path,
                     "NRRD0004\ntype: short\ndimension: 3\nspace: left-posterior-superior\nsizes: 10 10 10\n"
                     "space directions: (1,0,0) (0,1,0) (0,0,1)\nendian: little\nencoding: raw\n"
                     "space origin: (0,0,0)\nline skip: 1\ndata file: " +
                         data_file + "\n\n");
    EXPECT_THAT(message(path), testing::HasSubstr(data_file == "long" ? "is longer than" : "is not a regular file"));
  }
}

/// Returns the number of files of each format: KERF_DAMAGED_FILES, or 200 by default.
int CountFiles() {
  const char* wanted = std::getenv("KERF_DAMAGED_FILES");
  return wanted == nullptr ? 200 : std::atoi(wanted);
}

void Print(const char* format, const Counts& c) {
  std::cout << fmt::format("{}: {} read, {} refused, of these {} after the library failed\n", format, c.read, c.refused,
                           c.failed);
}

TEST(DamagedFiles, ImagesAreReadOrRefused) {
  const test::Folder folder;
  const Volume ct = SmallCt();
  test::WriteNrrd(ct, folder.path() + "/a.nrrd");
  test::WriteMeta(ct, folder.path() + "/a.mha");
  test::WriteNifti(ct, folder.path() + "/a.nii");
  for (const char* name : {"a.nrrd", "a.mha", "a.nii"}) {
    const std::string path = folder.path() + "/" + name;
    const std::string whole = test::ReadBytes(path);
    std::mt19937_64 random(20261122);
    Counts counts;
    for (int n = 0; n < CountFiles(); ++n) {
      test::WriteBytes(path, Damage(whole, random));
      Try([&] { ReadImageFile(path, ""); }, counts);
    }
    Print(name, counts);
    EXPECT_GT(counts.refused, 0);
  }
}

/// Damaged files or series of files: the n-th is at `path(n)`.
class DamagedInputs {
 public:
  virtual ~DamagedInputs() = default;
  virtual void Make(int count, std::mt19937_64& random) = 0;
  virtual void Read(int n) const = 0;
  std::string path(int n) const { return fmt::format("{}/{}", all_.path(), n); }
  /// Returns the number of the input that a message names at its beginning, or -1 if it names none.
  int Find(const std::string& message) const {
    const std::string start = all_.path() + "/";
    return message.rfind(start, 0) == 0 ? std::atoi(message.c_str() + start.size()) : -1;
  }

 private:
  test::Folder all_;
};

/// Series of three slices, of which the second is damaged.
class DamagedSeries : public DamagedInputs {
 public:
  explicit DamagedSeries(const std::vector<std::string>& slices) : slices_(slices) {
    for (const std::size_t k : {0, 2}) test::WriteBytes(good_.file(fmt::format("good_{}.dcm", k)), slices[k]);
  }
  void Make(int count, std::mt19937_64& random) override {
    for (int n = 0; n < count; ++n) {
      if (std::filesystem::create_directory(path(n))) {
        for (const int k : {0, 2}) {
          std::filesystem::create_symlink(good_.file(fmt::format("good_{}.dcm", k)),
                                          fmt::format("{}/{}.dcm", path(n), k));
        }
      }
      test::WriteBytes(path(n) + "/1.dcm", Damage(slices_[1], random));
    }
  }
  void Read(int n) const override { ReadDicomSeries(ListDicomSeries(path(n)).front(), {}); }

 private:
  test::Folder good_;
  std::vector<std::string> slices_;
};

class DamagedSegmentations : public DamagedInputs {
 public:
  explicit DamagedSegmentations(std::string whole) : whole_(std::move(whole)) {}
  void Make(int count, std::mt19937_64& random) override {
    for (int n = 0; n < count; ++n) test::WriteBytes(path(n), Damage(whole_, random));
  }
  void Read(int n) const override { ReadDicomSegments(path(n)); }

 private:
  std::string whole_;
};

/// Returns 'r' if the input is read, 'n' if it is refused with one sentence, otherwise '?': the input must be read
/// again as the program does, which makes a sentence of a library's exception. For a child process.
char ReadOne(const DamagedInputs& all, int n) {
  try {
    all.Read(n);
    return 'r';
  } catch (const Error& e) {
    const std::string said = e.what();
    return said.empty() || said.find('\n') != std::string::npos ? '?' : 'n';
  } catch (const std::bad_alloc&) {  // the program, which reads each input in a child process, refuses these too
    return 'n';
  } catch (...) {
    return '?';
  }
}

/// Reads the inputs from `first` to `last` in one child process, which a damaged file may crash. A child process for
/// each input, as in the program, would take up to 60 ms. Returns the first input that ended the process, or `last`.
int ReadInOneChild(const DamagedInputs& all, int first, int last, Counts& counts) {
  try {
    const auto read_all = [&](ChildReport& report) {
      std::string each;
      for (int n = first; n < last; ++n) {
        report.SetName(all.path(n));
        each += ReadOne(all, n);
      }
      return each;
    };
    const std::string outcomes = RunInChild("damaged", {std::uint64_t{256} << 20, 120}, read_all, {});
    EXPECT_EQ(outcomes.size(), static_cast<std::size_t>(last - first));
    if (outcomes.size() != static_cast<std::size_t>(last - first)) return last;
    for (int n = first; n < last; ++n) {
      const char outcome = outcomes[static_cast<std::size_t>(n - first)];
      if (outcome == '?') {
        Try([&] { all.Read(n); }, counts);
      } else {
        ++(outcome == 'r' ? counts.read : counts.refused);
      }
    }
    return last;
  } catch (const Error& e) {
    const int ended_at = all.Find(e.what());
    EXPECT_GE(ended_at, first) << e.what();
    EXPECT_LT(ended_at, last) << e.what();
    EXPECT_THAT(e.what(), testing::HasSubstr("the library that reads it failed"));
    return ended_at >= first ? ended_at : last;
  }
}

// Damages each number of the directions and of the origin in turn.
TEST(DamagedFiles, AbsurdNumbersOfAnNrrdAreRefused) {
  const test::Folder folder;
  const std::string path = folder.path() + "/a.nrrd";
  const Volume ct = SmallCt();
  const std::string header = test::NrrdHeader(ct);
  for (const std::string field : {"space directions:", "space origin:"}) {
    const std::size_t start = header.find(field) + field.size();
    const std::size_t line_end = header.find('\n', start);
    for (std::size_t at = start; at < line_end;) {
      const std::size_t number = header.find_first_of("-.0123456789", at);
      if (number >= line_end) break;
      const std::size_t number_end = header.find_first_of(",)", number);
      for (const std::string absurd : {"1e308", "-1e308", "1e400", "nan", "inf", "1e30"}) {
        test::WriteBytes(path,
                         header.substr(0, number) + absurd + header.substr(number_end) + "\n" + test::Bytes(ct.hu));
        EXPECT_THROW(ReadImageFile(path, ""), Error) << absurd << " at " << number;
      }
      at = number_end;
    }
  }
}

// GDCM, which unpacks pixels, reads past them, and one of its assertions ends the child process.
TEST(DamagedFiles, ASliceThatMakesGdcmAbortIsRefused) {
  const Volume ct = SmallCt();
  const test::Folder folder;
  for (int k = 0; k < 3; ++k) {
    const std::string behind = k == 1 ? std::string("\x5e\x04\0\x04", 4) : "";
    test::WriteBytes(fmt::format("{}/{}.dcm", folder.path(), k),
                     test::DicomSlice(ct, k, test::RunLengthSpec(ct, k)) + behind);
  }
  const std::vector<DicomSeries> all = ListDicomSeries(folder.path());
  ASSERT_EQ(all.size(), 1u);
  EXPECT_EQ(test::MessageOf([&] { ReadDicomSeries(all.front(), {}); }),
            folder.path() + "/1.dcm: the file is damaged: the library that reads it failed (Aborted)");
}

Counts ReadDamaged(DamagedInputs&& all, int files) {
  std::mt19937_64 random(20261122);
  Counts counts;
  for (int done = 0; done < files; done += 500) {
    const int count = std::min(files - done, 500);
    all.Make(count, random);
    for (int first = 0; first < count;) {
      const int ended_at = ReadInOneChild(all, first, count, counts);
      if (ended_at < count) {
        EXPECT_EQ(ReadInOneChild(all, first, ended_at, counts), ended_at);
        Try([&] { all.Read(ended_at); }, counts);  // as the program reads it
      }
      first = ended_at + 1;
    }
  }
  EXPECT_EQ(counts.read + counts.refused, files);
  return counts;
}

TEST(DamagedFiles, SlicesAreReadOrRefused) {
  const Volume ct = SmallCt();
  std::vector<std::string> plain, packed;
  for (int k = 0; k < 3; ++k) {
    plain.push_back(test::DicomSlice(ct, k, {}));
    packed.push_back(test::DicomSlice(ct, k, test::RunLengthSpec(ct, k)));
  }
  Print("DICOM", ReadDamaged(DamagedSeries(plain), CountFiles()));
  Print("DICOM, packed pixels", ReadDamaged(DamagedSeries(packed), CountFiles()));
}

TEST(DamagedFiles, SegmentationsAreReadOrRefused) {
  for (const bool implicit : {false, true}) {
    for (const bool fractional : {false, true}) {
      const Counts counts =
          ReadDamaged(DamagedSegmentations(test::DicomSegmentsFile(implicit, fractional)), CountFiles());
      Print(fractional ? "DICOM segmentation, fractional" : "DICOM segmentation, binary", counts);
      EXPECT_GT(counts.read, 0);
      EXPECT_GT(counts.refused, 0);
    }
  }
}

TEST(DamagedFiles, ALineBreakInASegmentationIsNotInTheMessage) {
  const test::Folder folder;
  std::string bytes = test::DicomSegmentsFile(false, false);
  test::WriteBytes(folder.file("a.dcm"), bytes.replace(bytes.find("BINARY"), 6, "BI\nARY"));
  EXPECT_EQ(test::MessageOf([&] { ReadDicomSegments(folder.file("a.dcm")); }),
            folder.file("a.dcm") + ": a segmentation of type 'BI?ARY', which kerf doesn't read");
}

std::string PackedSegments(const std::string& part, const std::string& by) {
  std::string packed =
      R"({"bits":1,"bytes":1,"fraction":0,"frames":[{"position":[0,0,0],"segment":1}],"orientation":[1,0,0,0,1,0],)"
      R"("segments":[{"category":[],"codes":[],"label":"jaw","modifiers":[],"number":1}],"size":[4,2],"spacing":[1,1]})";
  return packed.replace(packed.find(part), part.size(), by);
}

// What a library that was led astray in the child process may return.
TEST(DamagedFiles, WhatTheChildReturnsIsChecked) {
  const char pixels[1] = {'\x81'};
  const auto said = [&](const std::string& part, const std::string& by) {
    return test::MessageOf([&] { UnpackSegments(PackedSegments(part, by), pixels, kHalfFraction, "a.dcm"); }, "");
  };
  EXPECT_EQ(UnpackSegments(PackedSegments("jaw", "jaw"), pixels, kHalfFraction, "a.dcm").pixels,
            (std::vector<std::uint8_t>{1, 0, 0, 0, 0, 0, 0, 1}));
  EXPECT_THAT(said("\"bits\":1", "\"label_map\":true,\"bits\":8"), ::testing::HasSubstr("need 8 bytes, but it has 1"));
  EXPECT_THAT(said("\"bits\":1", "\"label_map\":true,\"bits\":1"),
              ::testing::HasSubstr("have 1 bits; kerf reads label maps with 8 or 16 bits"));
  const std::vector<std::pair<std::string, std::string>> lies = {{"{\"bits", std::string(1000000, '[')},
                                                                 {"\"bytes\":1", "\"bytes\":2"},
                                                                 {"\"size\":[4,2]", "\"size\":[-4,2]"},
                                                                 {"\"size\":[4,2]", "\"size\":[4]"},
                                                                 {"\"size\":[4,2]", "\"size\":[1e300,2]"},
                                                                 {"\"jaw\"", "7"},
                                                                 {"\"number\":1", "\"number\":18446744073709551615"},
                                                                 {"\"bits\":1,", ""}};
  for (const auto& [part, by] : lies) {
    EXPECT_EQ(said(part, by), "a.dcm: the file is damaged: the library that reads it returned no segmentation") << part;
  }
  EXPECT_THAT(said("\"size\":[4,2]", "\"size\":[30000,30000]"), testing::HasSubstr("the file is cut off or damaged"));
}

}  // namespace
}  // namespace kerf
