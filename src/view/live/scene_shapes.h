// Surfaces and lines as VTK's actors.
#pragma once

#include <vtkActor.h>
#include <vtkPolyData.h>
#include <vtkSmartPointer.h>

#include <array>
#include <vector>

#include "bone/mesh/meshfile.h"
#include "kerf/geometry.h"
#include "kerf/tool.h"

namespace kerf {

enum class Finish { kMatt, kMetal, kFlat };  // flat: not lit

/// Smooth where the surface is smooth, with creases where it bends by more than 40 degrees. Drawn with the solid things
/// whatever its opacity, so in the order in which actors are added.
/// `point_colours`: one for each point, or null.
vtkSmartPointer<vtkActor> MakeMeshActor(const TriangleMesh& mesh, const Rgb8& colour, double opacity, Finish finish,
                                        const std::vector<Rgb8>* point_colours = nullptr);
/// The twelve edges of a box.
std::vector<std::vector<Vec3>> MakeBoxEdges(const Box3& box);
/// `width_px`: of the window.
vtkSmartPointer<vtkActor> MakeLineActor(const std::vector<std::vector<Vec3>>& lines, const Rgb8& colour,
                                        double width_px);
/// What whirling teeth look like: a ring between the gullets and the tips, thinner outward, in the tool's frame.
vtkSmartPointer<vtkActor> MakeBlurActor(const DiscSaw& saw);
/// A disc without teeth, as large as what is solid in every turn.
TriangleMesh MakeTurningMesh(const DiscSaw& saw);

/// A rectangle, its corners in order.
std::vector<Vec3> MakeRectangle(const Vec3& middle, const Vec3& normal, const Vec3& up, double width, double height);
/// Filled, convex.
TriangleMesh MakePolygon(const std::vector<Vec3>& corners);
std::vector<Vec3> MakeCircle(const Vec3& middle, const Vec3& normal, double radius, int corners);
TriangleMesh MakeArrowMesh(const Vec3& tail, const Vec3& tip, double shaft_radius);

void SetPose(vtkActor& actor, const Pose& X_WA);

}  // namespace kerf
