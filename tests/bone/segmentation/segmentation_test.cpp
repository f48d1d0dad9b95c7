// Reading of segmentations: names, codes, layers, and what is refused.
#include "bone/segmentation/segmentation.h"

#include <gmock/gmock.h>

#include <cstdlib>
#include <filesystem>

#include "bone/segmentation/label_table.h"
#include "label_files.h"
#include "support/message_of.h"

namespace kerf {
namespace {

using test::Folder;
using test::HeaderSegment;
using test::MessageOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

// A small oblique lattice whose axes are left-handed.
Volume SmallLattice() {
  Volume lattice;
  lattice.size = {4, 3, 5};
  lattice.spacing_mm = {0.5, 0.4, 0.75};
  lattice.origin_W = {-12, 31, 7};
  lattice.axes_W = glm::dmat3{{0.8, 0.6, 0}, {0, 0, 1}, {-0.6, 0.8, 0}};
  if (glm::determinant(lattice.axes_W) > 0) lattice.axes_W[0] *= -1.0;
  return lattice;
}

std::vector<std::int16_t> Cycle(std::size_t count, int different) {
  std::vector<std::int16_t> labels;
  for (std::size_t v = 0; v < count; ++v)
    labels.push_back(static_cast<std::int16_t>(v % static_cast<std::size_t>(different)));
  return labels;
}

TEST(Segmentation, ReadsNamesCodesAndVolumes) {
  const Folder folder;
  Volume map = SmallLattice();
  map.hu = Cycle(map.count(), 4);  // 15 voxels of each label
  const std::string path = folder.file("a.seg.nrrd");
  test::WriteSeg(map, {{"Jaw", "2", "0", test::TagsOf("91609006", "Mandible")}, {"Upper", "1", "0", ""}}, path);
  const Segmentation read = ReadSegmentation(path);
  EXPECT_TRUE(read.named);
  ASSERT_EQ(read.segments.size(), 2u);
  EXPECT_EQ(read.segments[0].name, "Jaw");
  EXPECT_EQ(read.segments[0].label, 2);
  EXPECT_EQ(read.segments[0].category, "123037004");
  EXPECT_THAT(read.segments[0].codes, ElementsAre("91609006"));
  EXPECT_EQ(read.segments[0].voxels, 15u);
  EXPECT_NEAR(read.segments[0].volume_mm3, 15 * 0.5 * 0.4 * 0.75, 1e-9);
  EXPECT_EQ(read.layers.front(), map.hu);
  for (const Vec3& p_V : {Vec3(0, 0, 0), Vec3(3, 0, 0), Vec3(0, 2, 0), Vec3(0, 0, 4)})
    EXPECT_LT(glm::length(read.lattice.WorldFromVoxel(p_V) - map.WorldFromVoxel(p_V)), 1e-9);
  EXPECT_THAT(read.warnings, ElementsAre(HasSubstr("1 label that no segment has, such as 3")));
}

// A file of a megabyte can unpack to that; this one is sparse.
TEST(Segmentation, RefusesMoreThanALabelMapHoldsBeforeItReadsTheVoxels) {
  const Folder folder;
  const std::string path = folder.file("a.nrrd");
  test::WriteBytes(path,
                   "NRRD0004\ntype: unsigned char\ndimension: 3\nspace: left-posterior-superior\n"
                   "sizes: 1024 1024 1025\nspace directions: (1,0,0) (0,1,0) (0,0,1)\nspace origin: (0,0,0)\n"
                   "encoding: raw\n\n");
  std::filesystem::resize_file(path, std::filesystem::file_size(path) + (std::uintmax_t{1024} << 20) + (1 << 20));
  EXPECT_THAT(MessageOf([&] { ReadSegmentation(path); }),
              HasSubstr("has 1074790400 values, which take 3.0 GiB of memory; kerf reads up to 3 GiB"));
}

TEST(Segmentation, ReadsOverlappingLayersWhoseAxisIsTheFirst) {
  const Folder folder;
  const Volume lattice = SmallLattice();
  const std::vector<std::vector<std::int16_t>> layers = {Cycle(lattice.count(), 2), Cycle(lattice.count(), 3)};
  const std::string path = folder.file("a.seg.nrrd");
  test::WriteBytes(path, test::SegHeader(lattice, {{"a", "1", "0", ""}, {"b", "1", "1", ""}, {"c", "2", "1", ""}}, 2) +
                             test::LayerBytes(layers));
  const Segmentation read = ReadSegmentation(path);
  EXPECT_EQ(read.layers, layers);
  EXPECT_EQ(read.lattice.size, lattice.size);
  EXPECT_EQ(read.segments[0].voxels, 30u);
  EXPECT_EQ(read.segments[1].voxels, 20u);
  EXPECT_EQ(read.segments[2].voxels, 20u);
  // Files of older versions of 3D Slicer have one layer for each segment and give neither label nor layer.
  test::WriteBytes(path, test::SegHeader(lattice, {{"a", "", "", ""}, {"b", "", "", ""}}, 2) +
                             test::LayerBytes({layers[0], layers[0]}));
  EXPECT_EQ(ReadSegmentation(path).segments[1].layer, 1);
  EXPECT_EQ(ReadSegmentation(path).segments[1].voxels, 30u);
}

TEST(Segmentation, ReadsBareLabelMaps) {
  const Folder folder;
  Volume map = SmallLattice();
  map.hu = Cycle(map.count(), 4);
  test::WriteNrrd(map, folder.file("a.nrrd"));
  test::WriteNifti(map, folder.file("a.nii"));
  test::WriteMeta(map, folder.file("a.mha"));
  for (const char* file : {"a.nrrd", "a.nii", "a.mha"}) {
    const Segmentation read = ReadSegmentation(folder.file(file));
    EXPECT_FALSE(read.named);
    ASSERT_EQ(read.segments.size(), 3u) << file;
    EXPECT_EQ(Describe(read.segments[2]), "label 3 (2.25 mm3)");
    EXPECT_LT(glm::length(read.lattice.WorldFromVoxel({3, 2, 4}) - map.WorldFromVoxel({3, 2, 4})), 1e-5) << file;
  }
}

TEST(Segmentation, LeavesOutTheEndOfLongNames) {
  const Folder folder;
  Volume map = SmallLattice();
  map.hu = Cycle(map.count(), 2);
  std::string name;
  for (int i = 0; i < 70; ++i) name += "\u00e4";
  test::WriteSeg(map, {{name, "1"}}, folder.file("a.seg.nrrd"));
  EXPECT_EQ(ReadSegmentation(folder.file("a.seg.nrrd")).segments[0].name, name.substr(0, 2 * kMaxSegmentName));
}

TEST(Segmentation, RefusesFaultsWithOneSentence) {
  const Folder folder;
  const Volume lattice = SmallLattice();
  const std::string path = folder.file("a.seg.nrrd");
  const auto message = [&](const std::vector<HeaderSegment>& segments, std::size_t layers) {
    const std::vector<std::vector<std::int16_t>> values(layers, Cycle(lattice.count(), 2));
    test::WriteBytes(path, test::SegHeader(lattice, segments, layers) + test::LayerBytes(values));
    std::string said = MessageOf([&] { ReadSegmentation(path); });
    EXPECT_EQ(said.find('\n'), std::string::npos) << said;
    return said;
  };
  EXPECT_THAT(message({{"a", "0", "0", ""}}, 1), HasSubstr("the label of the segment 'a' is '0'"));
  EXPECT_THAT(message({{"a", "70000", "0", ""}}, 1), HasSubstr("from 1 to 32767"));
  EXPECT_THAT(message({{"a", "one", "0", ""}}, 1), HasSubstr("the label of the segment 'a' is 'one'"));
  EXPECT_THAT(message({{"a", "1", "2", ""}}, 2),
              HasSubstr("the layer of the segment 'a' is '2', but the file has 2 layers"));
  EXPECT_THAT(message({{"a", "1", "0", ""}, {"b", "1", "1", ""}}, 1),
              HasSubstr("the label 1 in layer 0; the header names more layers, but the file has only this one"));
  EXPECT_THAT(message({{"a", "1", "0", ""}, {"b", "1", "0", ""}}, 1),
              HasSubstr("two segments have the label 1 in layer 0"));
  EXPECT_THAT(message({{"a", "", "", ""}, {"b", "", "", ""}}, 1),
              HasSubstr("does not give the label of the segment 'a'"));
  EXPECT_THAT(message(std::vector<HeaderSegment>(257, {"a", "1", "0", ""}), 1),
              HasSubstr("257 segments; kerf reads up to 256"));
  EXPECT_THAT(message({}, 2), HasSubstr("the file has 2 layers but does not name its segments"));
  EXPECT_THAT(message({{"a", "1", "0", ""}}, 257), HasSubstr("257 layers; kerf reads up to 256"));

  test::WriteBytes(path,
                   test::SegHeader(lattice, {{"a", "1", "0", ""}}, 2) + test::LayerBytes({Cycle(lattice.count(), 2)}));
  EXPECT_THAT(MessageOf([&] { ReadSegmentation(path); }), HasSubstr("the file contains 60 bytes"));

  Volume ct = lattice;
  ct.hu = Cycle(ct.count(), 60);
  ct.hu[5] = -1000;
  test::WriteNrrd(ct, folder.file("ct.nrrd"));
  EXPECT_THAT(MessageOf([&] { ReadSegmentation(folder.file("ct.nrrd")); }),
              HasSubstr("the file is not a segmentation: it has negative values, down to -1000"));
  ct.hu.assign(ct.count(), 0);
  test::WriteNrrd(ct, folder.file("ct.nrrd"));
  EXPECT_THAT(MessageOf([&] { ReadSegmentation(folder.file("ct.nrrd")); }), HasSubstr("the label map is empty"));
  EXPECT_THAT(MessageOf([] { ReadSegmentation("a.stl"); }), HasSubstr("a.stl: unknown file type"));
}

/// Writes an NRRD with values of single precision.
void WriteFloats(const Volume& lattice, const std::vector<float>& values, const std::string& path) {
  std::string text = test::SegHeader(lattice, {}, 1);
  text.replace(text.find("unsigned char"), 13, "float\nendian: little");
  text += std::string(reinterpret_cast<const char*>(values.data()), values.size() * sizeof(float));
  test::WriteBytes(path, text);
}

TEST(Segmentation, ReadsHeadersOfOtherWritersAndSaysWhatItTook) {
  const Folder folder;
  Volume map = SmallLattice();
  const std::string path = folder.file("a.seg.nrrd");
  const auto read = [&](int different, const std::vector<HeaderSegment>& segments) {
    map.hu = Cycle(map.count(), different);
    test::WriteSeg(map, segments, path);
    return ReadSegmentation(path);
  };
  // Two layers that were flattened to one.
  const Segmentation flat = read(3, {{"a", "1", "0"}, {"b", "2", "1"}});
  EXPECT_EQ(flat.segments[1].layer, 0);
  EXPECT_EQ(flat.segments[1].voxels, 20u);
  EXPECT_THAT(flat.warnings, ElementsAre(HasSubstr("names several layers, but the file has one")));
  // Labels that are missing, or not those of the voxels.
  const Segmentation unlabelled = read(3, {{"a", "", ""}, {"b", "", ""}});
  EXPECT_EQ(unlabelled.segments[1].label, 2);
  EXPECT_EQ(unlabelled.segments[1].voxels, 20u);
  EXPECT_THAT(unlabelled.warnings, ElementsAre(HasSubstr("taken in order: 1 for 'a', 2 for 'b'")));
  EXPECT_EQ(read(3, {{"a", "", "0"}, {"b", "1", "0"}}).segments[0].label, 2);
  const Segmentation other = read(2, {{"a", "7", "0"}});
  EXPECT_EQ(other.segments[0].voxels, 30u);
  EXPECT_THAT(other.warnings, ElementsAre(HasSubstr("the segment 'a' the label 7, but its voxels have only 1")));
  EXPECT_THAT(MessageOf([&] {
                read(4, {{"a", "", ""}, {"b", "", ""}});
              }),
              HasSubstr("the voxels have 3 labels for 2 segments without one"));
  // Names that are missing.
  EXPECT_EQ(read(2, {{"", "1", "0"}}).segments[0].name, "Segment_0");
}

TEST(Segmentation, ReadsLayersWhoseAxisIsTheLast) {
  const Folder folder;
  const Volume lattice = SmallLattice();
  const std::vector<std::vector<std::int16_t>> layers = {Cycle(lattice.count(), 2), Cycle(lattice.count(), 3)};
  std::string header = test::SegHeader(lattice, {{"a", "1", "0"}, {"b", "2", "1"}}, 2);
  const auto move_to_end = [&header](const std::string& line, const std::string& word) {
    const std::size_t at = header.find(line) + line.size();
    header.erase(at, word.size());
    header.insert(header.find('\n', at), word);
  };
  move_to_end("sizes:", " 2");
  move_to_end("space directions:", " none");
  move_to_end("kinds:", " list");
  const std::string path = folder.file("a.seg.nrrd");
  test::WriteBytes(path, header + test::LayerBytes({layers[0]}) + test::LayerBytes({layers[1]}));
  const Segmentation read = ReadSegmentation(path);
  EXPECT_EQ(read.layers, layers);
  EXPECT_EQ(read.lattice.size, lattice.size);
  EXPECT_EQ(read.segments[1].voxels, 20u);
}

TEST(Segmentation, TakesValuesNearWholeNumbersAndSoftMaps) {
  const Folder folder;
  const Volume lattice = SmallLattice();
  const std::string path = folder.file("a.nrrd");
  std::vector<float> values;
  for (std::size_t v = 0; v < lattice.count(); ++v)
    values.push_back(static_cast<float>(v % 3) + (v % 2 == 0 ? 9e-4F : -9e-4F));
  WriteFloats(lattice, values, path);
  EXPECT_EQ(ReadSegmentation(path).layers[0], Cycle(lattice.count(), 3));
  EXPECT_TRUE(ReadSegmentation(path).warnings.empty());
  values[7] = 1.5F;
  WriteFloats(lattice, values, path);
  EXPECT_THAT(MessageOf([&] { ReadSegmentation(path); }), HasSubstr("values that are not whole numbers"));
  // 60 voxels from 0 to 1, in steps of 1/59.
  for (std::size_t v = 0; v < values.size(); ++v) values[v] = static_cast<float>(v) / 59;
  WriteFloats(lattice, values, path);
  EXPECT_EQ(ReadSegmentation(path).segments[0].voxels, 30u);
  EXPECT_EQ(ReadSegmentation(path, "", 0.9).segments[0].voxels, 6u);
  EXPECT_EQ(ReadSegmentation(path, "", 0.2).segments[0].voxels, 48u);
  EXPECT_THAT(ReadSegmentation(path, "", 0.9).warnings,
              ElementsAre(HasSubstr("voxels from 0.9 on were taken as the label 1")));
  // The same in whole numbers up to 100 or 255; regions of a number are labels.
  Volume map = lattice;
  for (const int upper : {100, 255}) {
    map.hu.clear();
    for (std::size_t v = 0; v < values.size(); ++v)
      map.hu.push_back(static_cast<std::int16_t>(std::lround(values[v] * static_cast<float>(upper))));
    test::WriteNrrd(map, path);
    EXPECT_EQ(ReadSegmentation(path).segments[0].voxels, 30u);
    EXPECT_EQ(ReadSegmentation(path, "", 0.91).segments[0].voxels, 6u);
    EXPECT_THAT(ReadSegmentation(path, "", 0.9).warnings,
                ElementsAre(HasSubstr(fmt::format("but from 0 to {}: voxels from {:g} on", upper, 0.9 * upper))));
    for (std::size_t v = 0; v < values.size(); ++v) map.hu[v] = static_cast<std::int16_t>(v < 30 ? 7 : upper);
    test::WriteNrrd(map, path);
    EXPECT_EQ(ReadSegmentation(path).segments.size(), 2u);
  }
}

TEST(LabelTables, AreUnderstoodAsProgramsWriteThem) {
  using Table = std::map<int, std::string>;
  const Table expected{{1, "mandible"}, {5, "inferior alveolar canal"}};
  EXPECT_EQ(ParseLabelTable("<?xml version=\"1.0\"?> <CaretExtension><VolumeInformation Index=\"0\"><LabelTable>\n"
                            "<Label Key=\"1\" Red=\"1.0\" Alpha=\"1\"><![CDATA[mandible]]></Label>\n"
                            "<Label Key=\"5\" Red=\"0\">inferior alveolar canal </Label>\n</LabelTable>"),
            expected);
  EXPECT_EQ(ParseLabelTable(R"({"labels": {"1": "mandible", "5": "inferior alveolar canal"}})"), expected);
  EXPECT_EQ(ParseLabelTable(R"({"background": 0, "mandible": 1, "inferior alveolar canal": 5})"), expected);
  EXPECT_EQ(ParseLabelTable(R"([{"label": 1, "name": "mandible"}, {"label": 5, "name": "inferior alveolar canal"}])"),
            expected);
  for (const char* other : {"", "a comment", "{", "<Label ", "<Label Key=\"", "[1, 2]", "{\"99999\": \"a\"}"})
    EXPECT_TRUE(ParseLabelTable(other).empty()) << other;
  EXPECT_TRUE(ParseLabelTable(std::string(100000, '[') + "]").empty());
}

// Runs a Python program with nibabel, an independent reader and writer of NIfTI.
bool RunNibabel(const std::string& program, const Folder& folder) {
  test::WriteBytes(folder.file("p.py"), program);
  return std::system(fmt::format("cd '{}' && /usr/bin/python3 p.py >/dev/null 2>&1", folder.path()).c_str()) == 0;
}

TEST(Segmentation, AgreesWithNibabel) {
  if (std::system("/usr/bin/python3 -c 'import nibabel' >/dev/null 2>&1") != 0)
    GTEST_SKIP() << "python3-nibabel is not installed";
  const Folder folder;
  Volume map = SmallLattice();
  map.hu = Cycle(map.count(), 4);
  test::WriteNifti(map, folder.file("a.nii"));
  // It reads the labels, turns the axes to its canonical order, and writes them compressed, as a different type.
  ASSERT_TRUE(
      RunNibabel("import nibabel, numpy\n"
                 "image = nibabel.as_closest_canonical(nibabel.load('a.nii'))\n"
                 "labels = numpy.asarray(image.dataobj).astype(numpy.uint8)\n"
                 "nibabel.save(nibabel.Nifti1Image(labels, image.affine), 'b.nii.gz')\n",
                 folder));
  const Segmentation read = ReadSegmentation(folder.file("b.nii.gz"));
  ASSERT_EQ(read.segments.size(), 3u);
  for (int k = 0; k < map.size[2]; ++k) {
    for (int j = 0; j < map.size[1]; ++j) {
      for (int i = 0; i < map.size[0]; ++i) {
        const Vec3 p_V = read.lattice.VoxelFromWorld(map.WorldFromVoxel({i, j, k}));
        const Vec3 at = glm::round(p_V);
        EXPECT_LT(glm::length(p_V - at), 1e-4);  // NIfTI has single precision
        EXPECT_EQ(
            read.layers[0][read.lattice.Index(static_cast<int>(at.x), static_cast<int>(at.y), static_cast<int>(at.z))],
            map.hu[map.Index(i, j, k)]);
      }
    }
  }
}

TEST(Segmentation, TakesNamesOfANiftiExtension) {
  if (std::system("/usr/bin/python3 -c 'import nibabel' >/dev/null 2>&1") != 0)
    GTEST_SKIP() << "python3-nibabel is not installed";
  const Folder folder;
  ASSERT_TRUE(
      RunNibabel("import nibabel, numpy\n"
                 "labels = (numpy.arange(60) % 3).astype(numpy.uint8).reshape(3, 4, 5)\n"
                 "table = '<CaretExtension><LabelTable>' + ''.join(f'<Label Key=\"{k}\"><![CDATA[{n}]]></Label>'\n"
                 "    for k, n in ((1, 'skull'), (2, 'mandible'), (3, 'sinus'), (4, 'left canal'))) + '</LabelTable>'\n"
                 "for kind, name in ((nibabel.Nifti1Image, 'a.nii'), (nibabel.Nifti1Image, 'a.nii.gz')):\n"
                 "    image = kind(labels, numpy.eye(4))\n"
                 "    image.header.extensions.append(nibabel.nifti1.Nifti1Extension(0, table.encode()))\n"
                 "    nibabel.save(image, name)\n",
                 folder));
  for (const char* name : {"a.nii", "a.nii.gz"}) {
    const Segmentation read = ReadSegmentation(folder.file(name));
    EXPECT_TRUE(read.named);
    ASSERT_EQ(read.segments.size(), 3u) << "the labels of the voxels, and the canal";
    EXPECT_EQ(read.segments[1].name, "mandible");
    EXPECT_EQ(read.segments[1].voxels, 20u);
    EXPECT_EQ(read.segments[2].name, "left canal");
    EXPECT_EQ(read.segments[2].voxels, 0u);
  }
}

}  // namespace
}  // namespace kerf
