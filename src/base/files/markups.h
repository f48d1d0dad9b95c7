// Points, curves and planes in 3D Slicer files.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "kerf/geometry.h"

namespace kerf {

/// Reads the control points of all markups in a .mrk.json file, LPS mm. Respects its coordinateSystem (LPS or RAS) and
/// skips points that were not placed. Throws kerf::Error with one sentence if it is not such a file or contains no
/// point.
std::vector<Vec3> ReadMarkups(const std::string& path);

struct Markup {
  std::vector<Vec3> points;  // LPS mm
  bool joined = false;       // a polyline; the first point of a closed curve is repeated at the end
};

/// Reads each markup of a .mrk.json file that has placed points: Curve, ClosedCurve and Line are joined, Fiducial and
/// PointList are separate points. Throws kerf::Error as ReadMarkups() does, and for other types of markup (Plane, ROI,
/// Angle).
std::vector<Markup> ReadCurveMarkups(const std::string& path);

/// Reads the plane of a .mrk.json file, LPS mm. If the file contains a markup of type Plane, the result is its `center`
/// and `normal`; without these, the normal is the z axis of its `baseToNode` and the point is its first point; without
/// a matrix (files of Slicer 4.11), the plane goes through its three points. If the file contains only other markups,
/// the result is the plane through three points, or the least-squares plane of more, at their mean; seen from the side
/// to which the normal points, the first three are in counter-clockwise order. Throws kerf::Error with one sentence if
/// the file contains several Planes, fewer than three points, points on a line, or a Plane with contradictory entries.
CutPlane ReadPlaneMarkups(const std::string& path);

/// Returns the plane through three points, or the least-squares plane of more, at their mean; seen from the side to
/// which the normal points, the first three are in counter-clockwise order. Throws kerf::Error, beginning with `what`,
/// for fewer than three points and for points on a line.
CutPlane FitPlane(const std::vector<Vec3>& points, const std::string& what);

/// 3D Slicer plane with its name.
struct PlaneMarkup {
  std::string name;
  CutPlane plane;  // LPS mm
};

/// Reads each markup of type Plane in a .mrk.json file, by the rules of ReadPlaneMarkups(); if there is none, returns
/// the plane through the points of the file. A plane without a name is called "plane 1" and so on; a repeated name gets
/// a number. Throws kerf::Error as ReadPlaneMarkups() does, but accepts several planes.
std::vector<PlaneMarkup> ReadPlaneMarkupList(const std::string& path);

/// Parses only the markups of type Plane of a .mrk.json file; there may be none. A name may be empty: 3D Slicer itself
/// names a plane by the name of its file. Throws kerf::Error.
std::vector<PlaneMarkup> ParsePlanes(const std::string& text, const std::string& path);

/// Writes planes in the format of 3D Slicer 5: point and normal, `size_mm` wide in both directions, all in one file.
/// Reading them back gives the same values to within one rounding. Writes through a temporary file. Throws kerf::Error.
void WritePlaneMarkups(const std::string& path, const std::vector<PlaneMarkup>& planes, double size_mm = 40);
std::string FormatPlaneMarkups(const std::vector<PlaneMarkup>& planes, double size_mm = 40);

/// 3D Slicer curve with kerf's own keys `radius` and `kind`.
struct TubeMarkup {
  std::string name;
  std::vector<Vec3> points;         // control points, LPS mm
  std::optional<double> radius_mm;  // none: the file does not state it
  std::string kind;                 // empty: the file does not state it
};

/// Parses each markup of a .mrk.json file that has placed points. The types are Curve, ClosedCurve (its first point is
/// repeated at the end) and Line. A curve without a name is called "curve 1" and so on; a repeated name gets a number.
/// Throws kerf::Error with one sentence if the file is not such a file, contains a markup of another type or no placed
/// point, if `radius` is not a positive number, or if `kind` is not a string.
std::vector<TubeMarkup> ParseTubeMarkups(const std::string& text, const std::string& path);
/// Formats curves in the format of 3D Slicer 5, all in one file. Parsing gives the same values bit for bit.
std::string FormatTubeMarkups(const std::vector<TubeMarkup>& curves);

/// These do the same from a file's text; `path` is its name in messages.
std::vector<Vec3> ParseMarkups(const std::string& text, const std::string& path);
std::vector<Markup> ParseCurveMarkups(const std::string& text, const std::string& path);
CutPlane ParsePlaneMarkups(const std::string& text, const std::string& path);
std::vector<PlaneMarkup> ParsePlaneMarkupList(const std::string& text, const std::string& path);

}  // namespace kerf
