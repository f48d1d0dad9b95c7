// Images in other forms: NIfTI-2, pairs, Analyze, bzip2, several data files, values that are not numbers.
#include <bzlib.h>
#include <gmock/gmock.h>
#include <zlib.h>

#include <cmath>
#include <functional>
#include <limits>

#include "bone/import/image_file.h"
#include "bone/import/image_header.h"
#include "ct_files.h"

namespace kerf {
namespace {

using test::Folder;
using test::MessageOf;
using test::Put;
using test::WriteBytes;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

Volume VariantCt() {
  Volume ct = test::MakeCt({7, 6, 5}, {0.5, 0.75, 1.25}, {3, -4, 5}, glm::dmat3(1), test::Ball({4, -2, 7}, 1.5));
  for (std::size_t v = 0; v < ct.hu.size(); ++v) ct.hu[v] = static_cast<std::int16_t>(ct.hu[v] + v);
  return ct;
}

void ExpectSameScan(const Volume& read, const Volume& ct) {
  EXPECT_EQ(read.hu, ct.hu);
  EXPECT_EQ(read.size, ct.size);
  // NIfTI-1 has single precision.
  EXPECT_LT(glm::length(read.origin_W - ct.origin_W), 1e-6);
  EXPECT_LT(glm::length(read.spacing_mm - ct.spacing_mm), 1e-6);
  for (int a = 0; a < 3; ++a) EXPECT_LT(glm::length(read.axes_W[a] - ct.axes_W[a]), 1e-6);
}

// Returns a NIfTI-2 header with an sform and the offset 544.
std::string Nifti2Header(const Volume& ct, const char* magic = "n+2") {
  std::string h(544, '\0');
  Put(h, 0, std::int32_t{540});
  h.replace(4, 8, std::string(magic) + std::string("\0\r\n\032\n", 5));
  Put(h, 12, std::int16_t{4});
  Put(h, 14, std::int16_t{16});
  Put(h, 16, std::int64_t{3});
  Put(h, 104, 1.0);
  for (std::size_t a = 0; a < 3; ++a) {
    Put(h, 24 + 8 * a, std::int64_t{ct.size[a]});
    Put(h, 112 + 8 * a, ct.spacing_mm[static_cast<int>(a)]);
  }
  Put(h, 168, std::int64_t{544});
  Put(h, 348, std::int32_t{1});
  Put(h, 500, std::int32_t{2});
  for (int row = 0; row < 3; ++row) {
    const double sign = row < 2 ? -1 : 1;
    const std::size_t at = 400 + 32 * static_cast<std::size_t>(row);
    for (int a = 0; a < 3; ++a)
      Put(h, at + 8 * static_cast<std::size_t>(a), sign * ct.axes_W[a][row] * ct.spacing_mm[a]);
    Put(h, at + 24, sign * ct.origin_W[row]);
  }
  return h;
}

TEST(Nifti2, IsReadInOneFileAndAsAPair) {
  const Volume ct = VariantCt();
  const Folder folder;
  WriteBytes(folder.file("a.nii"), Nifti2Header(ct) + test::Bytes(ct.hu));
  ExpectSameScan(ReadImageFile(folder.file("a.nii")), ct);
  std::string header = Nifti2Header(ct, "ni2").substr(0, 540);
  Put(header, 168, std::int64_t{0});
  WriteBytes(folder.file("b.hdr"), header);
  WriteBytes(folder.file("b.img"), test::Bytes(ct.hu));
  ExpectSameScan(ReadImageFile(folder.file("b.hdr")), ct);
  std::string early = Nifti2Header(ct);
  Put(early, 168, std::int64_t{540});
  WriteBytes(folder.file("c.nii"), early + test::Bytes(ct.hu));
  EXPECT_THAT(MessageOf([&] { ReadImageFile(folder.file("c.nii")); }), HasSubstr("vox_offset"));
}

TEST(NiftiPair, IsReadFromEitherFile) {
  const Volume ct = VariantCt();
  const Folder folder;
  std::string header = test::NiftiHeader(ct).substr(0, 348);
  header.replace(344, 4, std::string("ni1\0", 4));
  Put(header, 108, 0.0f);
  WriteBytes(folder.file("a.hdr"), header);
  EXPECT_THAT(MessageOf([&] { ReadImageFile(folder.file("a.hdr")); }), HasSubstr("a.img is missing beside it"));
  WriteBytes(folder.file("a.img"), test::Bytes(ct.hu));
  for (const char* name : {"a.hdr", "a.img"}) {
    const Volume read = ReadImageFile(folder.file(name));
    ExpectSameScan(read, ct);
    EXPECT_THAT(read.warnings, IsEmpty());
  }
  WriteBytes(folder.file("a.img"), test::Bytes(ct.hu).substr(2));
  EXPECT_THAT(MessageOf([&] { ReadImageFile(folder.file("a.hdr")); }), HasSubstr("it is cut off"));
}

TEST(Analyze, IsReadWithAWarningThatItHasNoSides) {
  const Volume ct = VariantCt();
  const Folder folder;
  std::string header = test::NiftiHeader(ct).substr(0, 348);
  header.replace(252, 96, std::string(96, '\0'));
  Put(header, 108, 0.0f);
  WriteBytes(folder.file("a.hdr"), header);
  WriteBytes(folder.file("a.img"), test::Bytes(ct.hu));
  const Volume read = ReadImageFile(folder.file("a.img"));
  EXPECT_EQ(read.hu, ct.hu);
  EXPECT_EQ(read.frame, "LAS");
  EXPECT_EQ(read.axes_W[1], Vec3(0, -1, 0));
  EXPECT_THAT(read.warnings, ElementsAre(HasSubstr("does not say which side of the patient is left")));
  const Volume stated = ReadImageFile(folder.file("a.img"), "RAS");
  EXPECT_EQ(stated.axes_W[0], Vec3(-1, 0, 0));
  EXPECT_THAT(stated.warnings, IsEmpty());
}

TEST(NiftiOffset, BelowTheFirstPossibleByteIsRefused) {
  const Volume ct = VariantCt();
  const Folder folder;
  for (const float offset : {0.0f, 348.0f, 351.0f, 352.5f}) {
    std::string header = test::NiftiHeader(ct);
    Put(header, 108, offset);
    WriteBytes(folder.file("a.nii"), header + test::Bytes(ct.hu));
    EXPECT_THAT(MessageOf([&] { ReadImageFile(folder.file("a.nii")); }),
                HasSubstr("vox_offset, the byte at which the voxels begin"));
  }
}

TEST(NotNumbers, AreAirInACtAndBackgroundInALabelMap) {
  const Volume ct = VariantCt();
  const Folder folder;
  std::vector<float> values(ct.count(), 1);
  values[3] = std::numeric_limits<float>::quiet_NaN();
  values[9] = std::numeric_limits<float>::infinity();
  WriteBytes(folder.file("a.nrrd"), test::NrrdHeader(ct, "float") + "\n" +
                                        std::string(reinterpret_cast<const char*>(values.data()), 4 * values.size()));
  const Volume read = ReadImageFile(folder.file("a.nrrd"));
  EXPECT_EQ(read.hu[3], -1024);
  EXPECT_EQ(read.hu[9], -1024);
  EXPECT_EQ(read.hu[4], 1);
  EXPECT_THAT(read.warnings,
              ElementsAre("2 of 210 voxels are not finite numbers (NaN or infinite); they were taken as air"));
  const LayeredImage labels = ReadLayeredImage(folder.file("a.nrrd"));
  EXPECT_EQ(labels.layers[0][3], 0);
}

std::string Bzip2(std::string bytes) {
  std::string packed(bytes.size() + 1000, '\0');
  auto size = static_cast<unsigned>(packed.size());
  BZ2_bzBuffToBuffCompress(packed.data(), &size, bytes.data(), static_cast<unsigned>(bytes.size()), 9, 0, 0);
  packed.resize(size);
  return packed;
}

std::string Replaced(std::string text, const std::string& from, const std::string& to) {
  return text.replace(text.find(from), from.size(), to);
}

TEST(Bzip2Nrrd, IsReadAndItsDamageIsNoticed) {
  const Volume ct = VariantCt();
  const Folder folder;
  const std::string header = Replaced(test::NrrdHeader(ct), "encoding: raw", "encoding: bzip2") + "\n";
  const std::string values = test::Bytes(ct.hu), packed = Bzip2(values);
  WriteBytes(folder.file("a.nrrd"), header + packed);
  ExpectSameScan(ReadImageFile(folder.file("a.nrrd")), ct);
  WriteBytes(folder.file("a.nrrd"), header + Bzip2(values.substr(0, 100)) + Bzip2(values.substr(100)));
  ExpectSameScan(ReadImageFile(folder.file("a.nrrd")), ct);
  std::string damaged = packed;
  damaged[packed.size() / 2] = static_cast<char>(damaged[packed.size() / 2] ^ 0x40);
  for (const std::string& bad : {damaged, packed.substr(0, packed.size() / 2), std::string("no stream")}) {
    WriteBytes(folder.file("a.nrrd"), header + bad);
    EXPECT_THAT(MessageOf([&] { ReadImageFile(folder.file("a.nrrd")); }),
                ::testing::AnyOf(HasSubstr("the compressed voxels are damaged"), HasSubstr("it is cut off")));
  }
}

class SeveralFiles : public ::testing::Test {
 protected:
  SeveralFiles() {
    const std::string values = test::Bytes(ct_.hu);
    const std::size_t slice = values.size() / 5;
    for (std::size_t k = 0; k < 5; ++k)
      WriteBytes(folder_.file(fmt::format("s {:02}.raw", k + 1)), values.substr(k * slice, slice));
  }
  std::string Read(const std::string& header) {
    WriteBytes(folder_.file("a.nhdr"), test::NrrdHeader(ct_) + header);
    return MessageOf([&] { ExpectSameScan(ReadImageFile(folder_.file("a.nhdr")), ct_); });
  }
  const Volume ct_ = VariantCt();
  const Folder folder_;
  const std::string list_ = "s 01.raw\ns 02.raw\ns 03.raw\ns 04.raw\ns 05.raw";
};

TEST_F(SeveralFiles, NrrdListAndPattern) {
  for (const std::string& data : {"LIST\n" + list_, "LIST 2\n" + list_ + "\n", std::string("s %02d.raw 1 5 1\n"),
                                  std::string("s %02d.raw 1 5 1 2\n")}) {
    EXPECT_EQ(Read("data file: " + data), "") << data;
  }
}

TEST_F(SeveralFiles, WrongNumberOrSizeOfFilesIsRefused) {
  EXPECT_THAT(Read("data file: LIST\ns 01.raw\ns 02.raw\n"), HasSubstr("names 2 data files for 5 slices"));
  EXPECT_THAT(Read("data file: LIST\ns 01.raw\ns 01.raw\n" + list_), HasSubstr("data files"));
  EXPECT_THAT(Read("data file: s %s.raw 1 5 1\n"), HasSubstr("are not a pattern with one number"));
  EXPECT_THAT(Read("data file: s %02d.raw 1 1e9 1\n"), HasSubstr("data files"));
  EXPECT_THAT(Read("data file: s %02d.raw 2 6 1\n"), HasSubstr("s 06.raw, which can't be opened"));
  WriteBytes(folder_.file("s 04.raw"), "short");
  EXPECT_THAT(Read("data file: LIST\n" + list_), HasSubstr("s 04.raw, but the file contains 5 bytes"));
}

TEST_F(SeveralFiles, MetaImageListAndPattern) {
  test::WriteMeta(ct_, folder_.file("whole.mha"));
  const std::string meta = test::ReadBytes(folder_.file("whole.mha"));
  const std::string header = meta.substr(0, meta.find("LOCAL"));
  for (const std::string& data : {"LIST\n" + list_ + "\n", std::string("s %02d.raw 1 5 1\n")}) {
    WriteBytes(folder_.file("a.mhd"), header + data);
    ExpectSameScan(ReadImageFile(folder_.file("a.mhd")), ct_);
  }
}

// Returns bytes in base64.
std::string Base64(const std::string& bytes) {
  const std::string letters = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  for (std::size_t at = 0; at < bytes.size(); at += 3) {
    unsigned bits = 0;
    for (std::size_t n = 0; n < 3; ++n)
      bits = bits << 8 | (at + n < bytes.size() ? static_cast<unsigned char>(bytes[at + n]) : 0u);
    for (std::size_t n = 0; n < 4; ++n) text += at + n > bytes.size() ? '=' : letters[bits >> (18 - 6 * n) & 63];
  }
  return text;
}

std::string Count(std::uint64_t n) {
  return {reinterpret_cast<const char*>(&n), 8};
}

// Returns a .vti whose array has a format and content, and what follows the image.
std::string Vti(const Volume& ct, const std::string& file, const std::string& array, const std::string& appended = "") {
  return fmt::format(
             "<?xml version=\"1.0\"?>\n<VTKFile type=\"ImageData\" byte_order=\"LittleEndian\" header_type=\"UInt64\" "
             "{}>\n<ImageData WholeExtent=\"2 {} 0 {} 0 {}\" Origin=\"{} {} {}\" Spacing=\"{} {} {}\">\n<Piece "
             "Extent=\"2 {} 0 {} 0 {}\">\n<PointData Scalars=\"CT\">\n<DataArray type=\"Int16\" Name=\"CT\" ",
             file, ct.size[0] + 1, ct.size[1] - 1, ct.size[2] - 1, ct.origin_W.x - 2 * ct.spacing_mm.x, ct.origin_W.y,
             ct.origin_W.z, ct.spacing_mm.x, ct.spacing_mm.y, ct.spacing_mm.z, ct.size[0] + 1, ct.size[1] - 1,
             ct.size[2] - 1) +
         array + "\n</PointData><CellData/></Piece></ImageData>" + appended + "</VTKFile>\n";
}

TEST(VtkImage, IsReadInEveryEncoding) {
  const Volume ct = VariantCt();
  const Folder folder;
  const std::string values = test::Bytes(ct.hu), length = Count(values.size());
  std::string text;
  for (const std::int16_t hu : ct.hu) text += fmt::format("{} ", hu);
  std::string blocks = Count(2) + Count(300) + Count(values.size() - 300), packed;
  for (const std::string& part : {values.substr(0, 300), values.substr(300)}) {
    std::string block(1000, '\0');
    uLongf size = block.size();
    compress(reinterpret_cast<Bytef*>(block.data()), &size, reinterpret_cast<const Bytef*>(part.data()), part.size());
    blocks += Count(size);
    packed += block.substr(0, size);
  }
  const std::string zlib = "compressor=\"vtkZLibDataCompressor\"", at = "format=\"appended\" offset=\"0\"/>";
  const auto appended = [](const std::string& encoding, const std::string& bytes) {
    return "<AppendedData encoding=\"" + encoding + "\">\n_" + bytes + "</AppendedData>";
  };
  for (const std::string& file :
       {Vti(ct, "", "format=\"ascii\">" + text + "</DataArray>"),
        Vti(ct, "", "format=\"binary\">\n" + Base64(length + values) + "\n</DataArray>"),
        Vti(ct, "", "format=\"binary\">\n" + Base64(length) + Base64(values) + "\n</DataArray>"),
        Vti(ct, zlib, "format=\"binary\">" + Base64(blocks) + Base64(packed) + "</DataArray>"),
        Vti(ct, "", at, appended("raw", length + values)), Vti(ct, "", at, appended("base64", Base64(length + values))),
        Vti(ct, zlib, at, appended("raw", blocks + packed)),
        Vti(ct, zlib, at, appended("base64", Base64(blocks) + Base64(packed)))}) {
    WriteBytes(folder.file("a.vti"), file);
    const Volume read = ReadImageFile(folder.file("a.vti"));
    ExpectSameScan(read, ct);
    EXPECT_THAT(read.warnings, ElementsAre(HasSubstr("does not say how the scan lies in the patient")));
    EXPECT_THAT(ReadImageFile(folder.file("a.vti"), "RAS").warnings, IsEmpty());
    WriteBytes(folder.file("a.vti"), file.substr(0, file.size() / 2 + 150));
    EXPECT_THAT(MessageOf([&] { ReadImageFile(folder.file("a.vti")); }), HasSubstr("a.vti: "));
  }
}

TEST(NiftiWithTwoForms, ThatDisagreeAreNamed) {
  const Volume ct = VariantCt();
  const Folder folder;
  std::string header = test::NiftiHeader(ct);
  Put(header, 252, std::int16_t{1});
  Put(header, 268, static_cast<float>(-ct.origin_W.x + 2));
  Put(header, 264, 1.0f);  // half a turn about z, as RAS is to LPS
  Put(header, 272, static_cast<float>(-ct.origin_W.y));
  Put(header, 276, static_cast<float>(ct.origin_W.z));
  WriteBytes(folder.file("a.nii"), header + test::Bytes(ct.hu));
  const Volume read = ReadImageFile(folder.file("a.nii"));
  ExpectSameScan(read, ct);
  EXPECT_THAT(read.warnings,
              ElementsAre(HasSubstr("two positions of the scan, up to 2.0 mm apart; its sform was used")));
}

}  // namespace
}  // namespace kerf
