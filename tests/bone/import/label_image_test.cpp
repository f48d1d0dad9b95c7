// Label maps, and images that are not label maps.
#include "bone/import/label_image.h"

#include <gmock/gmock.h>

#include "ct_files.h"

namespace kerf {
namespace {

using test::Folder;
using test::MessageOf;
using ::testing::HasSubstr;

/// A map with `different` labels from 0, whose axes are oblique and left-handed.
Volume MakeLabels(int different) {
  Volume map;
  map.size = {6, 5, 4};
  map.spacing_mm = {0.5, 0.4, 0.75};
  map.origin_W = {-12, 31, 7};
  map.axes_W = glm::dmat3{{0.8, 0.6, 0}, {0, 0, -1}, {0.6, -0.8, 0}};
  if (glm::determinant(map.axes_W) > 0) map.axes_W[0] *= -1.0;
  for (std::size_t v = 0; v < map.count(); ++v) {
    map.hu.push_back(static_cast<std::int16_t>(v % static_cast<std::size_t>(different)));
  }
  return map;
}

template <typename T>
void WriteNrrdAs(const Volume& map, const std::string& type, const std::vector<T>& values, const std::string& path) {
  test::WriteBytes(path, test::NrrdHeader(map, type) + "\n" +
                             std::string(reinterpret_cast<const char*>(values.data()), values.size() * sizeof(T)));
}

TEST(LabelImage, KeepsLabelsAndFrame) {
  const Folder folder;
  const Volume map = MakeLabels(64);
  test::WriteNrrd(map, folder.file("a.nrrd"));
  test::WriteNifti(map, folder.file("a.nii"));
  const std::vector<double> reals(map.hu.begin(), map.hu.end());
  WriteNrrdAs(map, "double", reals, folder.file("double.nrrd"));
  for (const char* file : {"a.nrrd", "a.nii", "double.nrrd"}) {
    const Volume read = ReadLabelImage(folder.file(file));
    EXPECT_EQ(read.hu, map.hu) << file;
    for (const Vec3& p_V : {Vec3(0, 0, 0), Vec3(5, 0, 0), Vec3(0, 4, 0), Vec3(0, 0, 3)}) {
      // NIfTI has single precision.
      EXPECT_LT(glm::length(read.WorldFromVoxel(p_V) - map.WorldFromVoxel(p_V)), 1e-5) << file;
    }
  }
}

TEST(LabelImage, RefusesOtherImages) {
  const Folder folder;
  const std::string path = folder.file("a.nrrd");
  const auto message = [&] { return MessageOf([&] { ReadLabelImage(path); }); };
  test::WriteNrrd(MakeLabels(65), path);
  EXPECT_THAT(message(), HasSubstr("a.nrrd: this image looks like a CT"));
  EXPECT_THAT(message(), HasSubstr("65 different values"));

  Volume map = MakeLabels(3);
  map.hu[7] = -1000;
  test::WriteNrrd(map, path);
  EXPECT_THAT(message(), HasSubstr("negative values, down to -1000"));

  std::vector<float> reals(map.count(), 1);
  reals[5] = 0.5f;
  WriteNrrdAs(map, "float", reals, path);
  EXPECT_THAT(message(), HasSubstr("not whole numbers"));

  std::vector<std::int32_t> large(map.count(), 1);
  large[5] = 70000;
  WriteNrrdAs(map, "int", large, path);
  EXPECT_THAT(message(), HasSubstr("not whole numbers from 0 to 32767"));
}

}  // namespace
}  // namespace kerf
