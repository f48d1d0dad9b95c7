// Surfaces and lines as VTK actors.
#pragma once

#include <vtkActor.h>
#include <vtkPolyData.h>
#include <vtkSmartPointer.h>

#include <array>
#include <vector>

#include "bone/mesh/meshfile.h"
#include "cut/tool/looks.h"
#include "kerf/geometry.h"

namespace kerf {

enum class Finish { kMatt, kMetal, kFlat };  // flat: unlit

/// Makes an actor with smooth shading, but with creases where the surface bends by more than 40 degrees. With opacity 1
/// it is drawn in VTK's opaque pass, otherwise in the translucent pass after it. `point_colours`: one for each point,
/// or null.
vtkSmartPointer<vtkActor> MakeMeshActor(const TriangleMesh& mesh, const Rgb8& colour, double opacity, Finish finish,
                                        const std::vector<Rgb8>* point_colours = nullptr);
/// Returns the twelve edges of a box.
std::vector<std::vector<Vec3>> MakeBoxEdges(const Box3& box);
/// Makes an actor for lines of `width_px` pixels of the window.
vtkSmartPointer<vtkActor> MakeLineActor(const std::vector<std::vector<Vec3>>& lines, const Rgb8& colour,
                                        double width_px);
/// Makes the motion blur of turning teeth: a ring between the gullets and the tips, which becomes less opaque outwards;
/// in the tool's frame.
vtkSmartPointer<vtkActor> MakeBlurActor(const ToolBlur& blur);

/// Returns the corners of a rectangle in order.
std::vector<Vec3> MakeRectangle(const Vec3& middle, const Vec3& normal, const Vec3& up, double width, double height);
/// Returns the corners with the first one again at the end, for the line around them.
std::vector<Vec3> Closed(std::vector<Vec3> corners);
/// Makes a filled convex polygon.
TriangleMesh MakePolygon(const std::vector<Vec3>& corners);
std::vector<Vec3> MakeCircle(const Vec3& middle, const Vec3& normal, double radius, int corners);
/// Makes a closed round tube along a polyline. Empty for fewer than two different points.
TriangleMesh MakeTubeMesh(const std::vector<Vec3>& points, double radius);
TriangleMesh MakeArrowMesh(const Vec3& tail, const Vec3& tip, double shaft_radius);

void SetPose(vtkActor& actor, const Pose& X_WA);

/// Round window in an actor through which one sees what lies behind a spot: the actor's parts that lie in front of the
/// spot become translucent around it on the screen.
struct SightHole {
  double x_px = 0;  // on the screen, from the lower left
  double y_px = 0;
  double depth = 0;      // of the spot, 0 to 1
  double radius_px = 0;  // at which the actor is opaque again
  double strength = 0;   // 0: no window; 1: full
  double alpha = 0.2;    // of the actor in the middle, at full strength
};
/// Gives an actor a window, initially without effect.
void AddSightHole(vtkActor& actor);
/// Changes the window of an actor that has one.
void SetSightHole(vtkActor& actor, const SightHole& hole);

}  // namespace kerf
