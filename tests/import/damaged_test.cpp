// Scans with a few bytes changed: whatever the libraries do that read them, kerf reads them or refuses with a sentence.
#include <gtest/gtest.h>

#include <cstdint>
#include <iostream>
#include <random>
#include <string>

#include "ct_files.h"
#include "import/dicom.h"
#include "import/image_file.h"
#include "kerf/error.h"
#include "support/folder.h"

namespace kerf {
namespace {

Volume SmallCt() {
  return test::MakeCt({6, 5, 4}, Vec3(0.5, 0.5, 1), Vec3(0), glm::dmat3(1), test::Ball(Vec3(1.5), 1));
}

/// 1 to 4 bytes changed, or the end cut off, or a part doubled.
std::string Damage(std::string bytes, std::mt19937_64& random) {
  const auto at = [&] { return random() % bytes.size(); };
  const auto kind = random() % 16;
  if (kind == 0) return bytes.substr(0, at());
  if (kind == 1) return bytes.insert(at(), bytes.substr(at(), random() % 64));
  for (auto n = random() % 4 + 1; n > 0; --n) bytes[at()] = static_cast<char>(random());
  return bytes;
}

struct Counts {
  int read = 0, refused = 0, failed = 0;  // failed: the library that reads it did not survive
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

/// KERF_DAMAGED_FILES: as many of each format, instead of the few of an ordinary test.
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

TEST(DamagedFiles, SlicesAreReadOrRefused) {
  const test::Folder folder;
  const Volume ct = SmallCt();
  std::vector<std::string> slices;
  for (int k = 0; k < ct.size[2]; ++k) slices.push_back(test::DicomSlice(ct, k, {}));
  const auto path = [&folder](std::size_t k) { return fmt::format("{}/{}.dcm", folder.path(), k); };
  for (std::size_t k = 0; k < slices.size(); ++k) test::WriteBytes(path(k), slices[k]);
  std::mt19937_64 random(20261122);
  Counts counts;
  for (int n = 0; n < CountFiles(); ++n) {
    test::WriteBytes(path(1), Damage(slices[1], random));
    Try([&] { ReadDicomSeries(ListDicomSeries(folder.path()).front(), {}); }, counts);
  }
  Print("dicom", counts);
  EXPECT_GT(counts.refused, 0);
}

}  // namespace
}  // namespace kerf
