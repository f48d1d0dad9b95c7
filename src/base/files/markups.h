// Points and planes of 3D Slicer.
#pragma once

#include <string>
#include <vector>

#include "kerf/geometry.h"

namespace kerf {

/// The control points of all markups in a .mrk.json file, LPS mm. Its coordinateSystem (LPS or RAS) is honoured; points
/// that were not placed are left out. Throws Error with one sentence when it is no such file, or holds no point.
std::vector<Vec3> ReadMarkups(const std::string& path);

struct Markup {
  std::vector<Vec3> points;  // LPS mm
  bool joined = false;  // by straight lines, from each to the next; of a closed curve the first stands at the end too
};

/// Each markup of a .mrk.json file that has placed points: Curve, ClosedCurve and Line are joined, Fiducial and
/// PointList are points. Throws Error as ReadMarkups(), and for a markup of another type (Plane, ROI, Angle).
std::vector<Markup> ReadCurveMarkups(const std::string& path);

/// The plane of a .mrk.json file, LPS mm. If it holds a markup of type Plane: that one's `center` and `normal`, else
/// the third column of its `baseToNode` and its first point, else (files of Slicer 4.11) its three points. If it holds
/// other markups: the plane through three points, or nearest to more in the sense of least squares, at their mean; seen
/// from the side to which the normal points, the first three go round counter-clockwise. Throws Error with one sentence
/// when it holds several Planes, fewer than three points, points on a line, or a Plane whose entries contradict each
/// other.
CutPlane ReadPlaneMarkups(const std::string& path);

/// A plane of 3D Slicer with its name there.
struct PlaneMarkup {
  std::string name;
  CutPlane plane;  // LPS mm
};

/// Each markup of type Plane of a .mrk.json file, by the rules of ReadPlaneMarkups(); of a file without any the plane
/// of its points. Who has no name is called "plane 1" and so on; a name that comes again gets a number. Throws Error as
/// ReadPlaneMarkups(), but for several planes.
std::vector<PlaneMarkup> ReadPlaneMarkupList(const std::string& path);

/// As 3D Slicer 5 writes planes: point and normal, `size_mm` wide each way, all in one file. Read back they are the
/// same to the last digit but for a rounding. Through a temporary. Throws Error.
void WritePlaneMarkups(const std::string& path, const std::vector<PlaneMarkup>& planes, double size_mm = 40);
std::string FormatPlaneMarkups(const std::vector<PlaneMarkup>& planes, double size_mm = 40);

/// The same from a file's text; `path` names it in messages.
std::vector<Vec3> ParseMarkups(const std::string& text, const std::string& path);
std::vector<Markup> ParseCurveMarkups(const std::string& text, const std::string& path);
CutPlane ParsePlaneMarkups(const std::string& text, const std::string& path);
std::vector<PlaneMarkup> ParsePlaneMarkupList(const std::string& text, const std::string& path);

}  // namespace kerf
