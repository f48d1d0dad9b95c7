// What a surgeon takes away from a session: pieces, planes, measures and a report, in a folder.
#pragma once

#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "bone/pieces/piece_set.h"
#include "session/plan/assess.h"
#include "session/plan/plan.h"

namespace kerf {

/// A line of a table: a name and what it is.
struct TakenFact {
  std::string name;
  std::string value;
};
/// A figure of the session: mean force, time.
struct TakenFigure {
  std::string name;
  std::string unit;
  double value = 0;
};
/// A distance or an angle that somebody measured.
struct TakenMeasure {
  std::string name;
  std::string unit;  // "mm" or "deg"
  double value = 0;
  std::vector<Vec3> points_W_mm;  // two of a distance, three of an angle (the corner in the middle); may be empty
};
/// Of a picture: the bytes of a PNG file.
struct TakenPicture {
  std::string name;  // of its file, without ".png": letters, digits, "_" and "-"
  std::string caption;
  std::string png;
};
/// A line in a plot.
struct TakenCurve {
  std::string title;
  std::string x_label;  // with its unit
  std::string y_label;
  std::vector<std::pair<double, double>> points;  // x rising
};

/// The recording that a session was taken from.
struct TakenRecording {
  std::string state;                    // "whole", "cut short", "damaged"; empty: there is no recording
  std::vector<std::string> warnings{};  // a sentence each: what is wrong with it

  bool is_whole() const { return state.empty() || state == "whole"; }
};

/// Whatever there is; the rest is left out. What is pointed to must outlive the call.
struct TakeAway {
  std::string title;
  const Plan* plan = nullptr;
  const Assessment* assessment = nullptr;
  const PieceSet* pieces = nullptr;
  std::vector<TakenFigure> figures;
  std::vector<TakenMeasure> measures;
  std::vector<TakenPicture> pictures;
  std::vector<TakenCurve> curves;
  std::vector<TakenFact> provenance;  // scene, recording, hashes, version
  TakenRecording recording{};
};

struct TakeAwayOptions {
  bool obj = false;           // pieces as OBJ, else as STL
  double gap_limit_mm = 50;   // gaps beyond are not looked for
  std::size_t triangles = 0;  // of a piece's file, at most (4 or more; Decimate()); 0: all
};

/// Writes into the folder, made when missing, each file through a temporary; files of the same names are replaced:
///   report.html      everything, in one file that needs no other
///   measures.csv     subject, measure, unit, value
///   assessment.json  planned against achieved
///   planned.mrk.json, achieved.mrk.json   planes for 3D Slicer
///   NAME.stl         each piece that is not deleted, where it is now (or .obj)
///   NAME_origin.stl  and, of one that was moved, where it was cut off,
///   NAME.tfm         with the motion from there as 3D Slicer reads it
///   transforms.json  the same motions as 4 x 4 matrices, LPS mm, with volume and centre of each piece
///   pieces.json      what PieceSet::Restore() reads
///   PICTURE.png
/// Returns their names. Throws Error. `progress` gets 0..1.
std::vector<std::string> WriteTakeAway(const TakeAway& taken, const std::string& folder,
                                       const TakeAwayOptions& options = {},
                                       const std::function<void(double)>& progress = {});

/// The parts by themselves.
std::string FormatReportHtml(const TakeAway& taken, const TakeAwayOptions& options = {});
std::string FormatMeasuresCsv(const TakeAway& taken, const TakeAwayOptions& options = {});
/// Stable keys with units; ends with a newline. Of a recording also its state and what is wrong with it.
std::string FormatAssessmentJson(const Assessment& assessment, const TakenRecording& recording = {});
/// A motion X_WP as ITK's text: LPS, from where it is now to where it was, as resampling has it and 3D Slicer reads it.
std::string FormatTransformFile(const Pose& X_WP);

}  // namespace kerf
