// Compares the triangles of the STL file written by kerf with those of VTK's writer.
#include <gtest/gtest.h>
#include <vtkNew.h>
#include <vtkPolyData.h>
#include <vtkSTLWriter.h>
#include <vtkSmartPointer.h>

#include <filesystem>
#include <random>

#include "bone/mesh/meshfile.h"
#include "support/folder.h"
#include "view/picture/vtk_mesh.h"

namespace kerf {
namespace {

TEST(Stl, HasTheBytesOfVtksWriterBehindItsHeader) {
  const test::Folder folder;
  std::mt19937 random(7);
  std::uniform_real_distribution<double> coordinate(-80, 80);
  TriangleMesh mesh;
  for (int i = 0; i < 300; ++i) mesh.points.emplace_back(coordinate(random), coordinate(random), coordinate(random));
  for (std::uint32_t i = 0; i + 2 < 300; ++i) mesh.triangles.push_back({i, i + 1, i + 2});
  const std::string ours = folder.file("ours.stl");
  const std::string theirs = folder.file("theirs.stl");
  TriangleMesh with_degenerate = mesh;
  with_degenerate.triangles.push_back({3, 3, 4});  // is left out
  WriteMesh(with_degenerate, ours);
  const vtkNew<vtkSTLWriter> writer;
  writer->SetFileTypeToBinary();
  writer->SetInputData(MakePolyData(mesh));
  writer->SetFileName(theirs.c_str());
  ASSERT_EQ(writer->Write(), 1);
  EXPECT_EQ(std::filesystem::file_size(ours), 84 + 50 * mesh.triangles.size());
  EXPECT_EQ(test::ReadBytes(ours).substr(80), test::ReadBytes(theirs).substr(80));
}

}  // namespace
}  // namespace kerf
