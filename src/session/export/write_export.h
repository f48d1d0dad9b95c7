// Exports the results of a session into a folder: pieces, planes, measures and a report.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "base/table/table.h"
#include "bone/pieces/piece_set.h"
#include "session/marks/structures.h"
#include "session/plan/assess.h"
#include "session/plan/cut_state.h"
#include "session/plan/plan.h"

namespace kerf {

/// A row of a table: a name and its value.
struct ExportFact {
  std::string name;
  std::string value;
  std::string technical{};  // its name for programs, shown small beside it; optional
};
/// A value of the session, such as the mean force or the time.
struct ExportFigure {
  std::string name;
  std::string unit;
  double value = 0;
};
/// A distance or an angle that the user measured.
struct ExportMeasure {
  std::string name;
  std::string unit;  // "mm" or "deg"
  double value = 0;
  std::vector<Vec3> points_W_mm;      // two for a distance, three for an angle (the vertex is the second); optional
  std::vector<std::string> pieces{};  // names of the pieces on which the points lie, in order; optional
};
/// A picture: the bytes of a PNG file.
struct ExportPicture {
  std::string name;  // of its file, without ".png": letters, digits, "_" and "-"
  std::string caption;
  std::string png;
};
/// A curve in a plot.
struct ExportCurve {
  std::string title;
  std::string x_label;  // with its unit
  std::string y_label;
  std::vector<std::pair<double, double>> points;  // x increasing
};

/// A session of the case; what is not known is left out.
struct ExportSession {
  std::string saw;
  std::optional<double> duration_s{};
  std::optional<double> in_bone_s{};        // time with the saw in bone
  std::optional<double> turning_force_N{};  // largest force on the hand while the spindle turned
  std::optional<double> stopped_force_N{};  // and while it did not
};

/// The recording of the session.
struct ExportRecording {
  std::string state;                    // "whole", "cut short", "damaged"; empty: there is no recording
  std::vector<std::string> warnings{};  // one sentence per fault

  bool is_whole() const { return state.empty() || state == "whole"; }
};

/// Language of the report. Without a translation it is English. The other files are the same in all languages.
struct ReportLanguage {
  std::string code = "en";
  /// Translates a text, also one that was made with values in it. Called by the thread that writes the report.
  std::function<std::string(const std::string&)> translate{};
  std::string point = ".";  // decimal separator

  /// Returns the translation of a text. tools/translations finds the literals in its calls.
  std::string Tr(const std::string& text) const { return translate && !text.empty() ? translate(text) : text; }
  /// Translates the description of a saw: its name, if it has one, and its sizes.
  std::string ShowSaw(const std::string& saw) const;
  /// Translates a name that the program has made, such as "plane 2". Other names stay as they are.
  std::string ShowName(const std::string& name) const;
  /// Returns "-" if `value` is not finite, otherwise the value with `decimals` decimals. Never returns "-0.00".
  std::string Show(double value, int decimals) const;
  /// Returns a volume with its unit, as the window shows it.
  std::string ShowVolume(double mm3) const;
  /// Returns the message in this language. Its texts may be names, as for ShowName().
  std::string Show(const Message& message) const;
};

/// Data to export; missing items are left out. The pointers must remain valid during the call.
struct ExportInput {
  std::string title;
  const Plan* plan = nullptr;
  const Assessment* assessment = nullptr;
  std::vector<CutState> cut_states{};  // of the assessment's planes, in its order; empty: unknown
  const PieceSet* pieces = nullptr;
  std::vector<std::string> piece_colours{};  // in the pictures, in words, of each piece; empty: unknown
  const StructureAssessment* structures = nullptr;
  std::optional<Vec3> hub_in_bone_W{};        // where the blade's hub was in the bone during a cut; none: not known of
  std::optional<Vec3> handpiece_in_bone_W{};  // the same for the handpiece
  std::vector<ExportFact> circumstances{};    // date, case, saw, force law: below the title of the report
  std::vector<ExportSession> sessions{};      // in order; listed if there are several
  std::vector<ExportFigure> figures;          // listed unless the circumstances have a value of the same name
  std::vector<ExportMeasure> measures;
  std::vector<ExportPicture> pictures;
  std::vector<ExportCurve> curves;
  std::vector<ExportFact> provenance;  // scene, recording, hashes, version
  ExportRecording recording{};
  ReportLanguage language{};
};

struct ExportOptions {
  bool obj = false;           // pieces as OBJ, otherwise as STL
  double gap_limit_mm = 50;   // larger gaps are not searched for
  std::size_t triangles = 0;  // maximum per piece (4 or more; see Decimate()); 0: unlimited
};

/// Writes the following files into the folder, which is created if missing, each through a temporary file. Existing
/// files with these names are replaced:
///   report.html      everything, in one self-contained file
///   measures.csv     subject, measure, unit, value
///   assessment.json  comparison of plan and cut
///   planned.mrk.json, achieved.mrk.json   planes for 3D Slicer
///   NAME.stl         each piece that is not deleted, at its current place (or .obj)
///   NAME_origin.stl  for a moved piece: at the place where it was cut off,
///   NAME.tfm         and its motion from there in the format of 3D Slicer
///   transforms.json  the same motions as 4 x 4 matrices, LPS mm, with volume and centre of each piece
///   pieces.json      input of PieceSet::Restore()
///   PICTURE.png
/// Returns the names of the files. Throws kerf::Error. `progress` is called with values from 0 to 1.
std::vector<std::string> WriteExport(const ExportInput& input, const std::string& folder,
                                     const ExportOptions& options = {},
                                     const std::function<void(double)>& progress = {});

/// These return the text of individual files.
std::string FormatReportHtml(const ExportInput& input, const ExportOptions& options = {});
/// A line of measures.csv.
struct ExportLine {
  std::string subject;
  std::string measure;
  std::string unit;
  double value = 0;
};
const Columns<ExportLine>& ExportColumns();
std::string FormatMeasuresCsv(const ExportInput& input, const ExportOptions& options = {});
/// Returns the assessment, which must be given, as JSON with stable keys that include the units; ends with a newline.
/// Includes the structures, the pieces, and the state and the faults of the recording, if they are given.
std::string FormatAssessmentJson(const ExportInput& input);
/// Returns a motion X_WP as ITK text: in LPS, and from the current to the original position, as resampling requires and
/// as 3D Slicer expects.
std::string FormatTransformFile(const Pose& X_WP);

}  // namespace kerf
