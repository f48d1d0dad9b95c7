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
#include "ct_files.h"
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

/// Folders "0", "1" and so on; each contains a series of three slices, of which the second is damaged.
class DamagedSeries {
 public:
  explicit DamagedSeries(const std::vector<std::string>& slices) : slices_(slices) {
    for (const std::size_t k : {0, 2}) test::WriteBytes(fmt::format("{}/{}.dcm", good_.path(), k), slices[k]);
  }
  void Make(int count, std::mt19937_64& random) {
    for (int n = 0; n < count; ++n) {
      const std::string folder = Folder(n);
      if (std::filesystem::create_directory(folder)) {
        for (const int k : {0, 2}) {
          std::filesystem::create_symlink(fmt::format("{}/{}.dcm", good_.path(), k),
                                          fmt::format("{}/{}.dcm", folder, k));
        }
      }
      test::WriteBytes(folder + "/1.dcm", Damage(slices_[1], random));
    }
  }
  std::string Folder(int n) const { return fmt::format("{}/{}", all_.path(), n); }
  /// Returns the index of the folder that a message names at its beginning, or -1 if it names none.
  int Find(const std::string& message) const {
    const std::string start = all_.path() + "/";
    return message.rfind(start, 0) == 0 ? std::atoi(message.c_str() + start.size()) : -1;
  }

 private:
  test::Folder good_, all_;
  std::vector<std::string> slices_;
};

bool IsRead(const std::string& folder) {
  Counts counts;
  try {
    Try([&] { ReadDicomSeries(ListDicomSeries(folder).front(), {}); }, counts);
  } catch (const std::bad_alloc&) {  // the program, which reads each series in a child process, refuses these too
  }
  return counts.read > 0;
}

/// Reads the folders from `first` to `last` in one child process, which a damaged file may crash. A child process for
/// each folder, as in the program, would take up to 60 ms. Returns the first folder that was not read, or `last`.
int ReadInOneChild(const DamagedSeries& all, int first, int last, Counts& counts) {
  try {
    const auto read_all = [&](ChildReport&) {
      std::string each;
      for (int n = first; n < last; ++n) each += IsRead(all.Folder(n)) ? 'r' : 'n';
      return each;
    };
    const std::string outcomes = RunInChild("damaged", {std::uint64_t{256} << 20, 120}, read_all, {});
    EXPECT_EQ(outcomes.size(), static_cast<std::size_t>(last - first));
    const auto read = static_cast<int>(std::count(outcomes.begin(), outcomes.end(), 'r'));
    counts.read += read;
    counts.refused += last - first - read;
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

// GDCM reads past the pixels, and one of its assertions ends the child process.
TEST(DamagedFiles, ASliceThatMakesGdcmAbortIsRefused) {
  const Volume ct = SmallCt();
  const test::Folder folder;
  for (int k = 0; k < 3; ++k) {
    const std::string behind = k == 1 ? std::string("\x5e\x04\0\x04", 4) : "";
    test::WriteBytes(fmt::format("{}/{}.dcm", folder.path(), k), test::DicomSlice(ct, k, {}) + behind);
  }
  const std::vector<DicomSeries> all = ListDicomSeries(folder.path());
  ASSERT_EQ(all.size(), 1u);
  EXPECT_EQ(test::MessageOf([&] { ReadDicomSeries(all.front(), {}); }),
            folder.path() + "/1.dcm: the file is damaged: the library that reads it failed (Aborted)");
}

Counts ReadDamagedSeries(const std::vector<std::string>& slices, int files) {
  DamagedSeries all(slices);
  std::mt19937_64 random(20261122);
  Counts counts;
  for (int done = 0; done < files; done += 500) {
    const int count = std::min(files - done, 500);
    all.Make(count, random);
    for (int first = 0; first < count;) {
      const int ended_at = ReadInOneChild(all, first, count, counts);
      if (ended_at < count) {
        EXPECT_EQ(ReadInOneChild(all, first, ended_at, counts), ended_at);
        ++counts.refused;
        ++counts.failed;
      }
      first = ended_at + 1;
    }
  }
  EXPECT_GE(counts.read + counts.refused, files);
  return counts;
}

TEST(DamagedFiles, SlicesAreReadOrRefused) {
  const Volume ct = SmallCt();
  std::vector<std::string> plain, packed;
  for (int k = 0; k < 3; ++k) {
    plain.push_back(test::DicomSlice(ct, k, {}));
    packed.push_back(test::DicomSlice(ct, k, test::RunLengthSpec(ct, k)));
  }
  Print("DICOM", ReadDamagedSeries(plain, CountFiles()));
  Print("DICOM, packed pixels", ReadDamagedSeries(packed, CountFiles()));
}

}  // namespace
}  // namespace kerf
