#include <fmt/format.h>

#include <cctype>
#include <nlohmann/json.hpp>
#include <set>

#include "base/files/files.h"
#include "base/files/markups.h"
#include "bone/mesh/decimate.h"
#include "bone/mesh/meshfile.h"
#include "kerf/error.h"
#include "session/export/contacts.h"

namespace kerf {
namespace {

using Json = nlohmann::ordered_json;

/// Returns an unused file name: letters, digits, "_" and "-".
std::string MakeFileName(const std::string& name, std::set<std::string>& taken) {
  std::string out;
  for (const char c : name.substr(0, 60)) {
    const bool plain = std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '-' || c == '_';
    out += plain ? static_cast<char>(std::tolower(static_cast<unsigned char>(c))) : '_';
  }
  if (out.empty()) out = "piece";
  std::string unique = out;
  for (int i = 2; !taken.insert(unique).second; ++i) unique = fmt::format("{}_{}", out, i);
  return unique;
}

TriangleMesh Moved(TriangleMesh mesh, const Pose& X) {
  for (Vec3& p : mesh.points) p = X.Point(p);
  return mesh;
}

class Folder {
 public:
  Folder(std::string path, std::function<void(double)> progress, std::size_t steps)
      : path_(std::move(path)), progress_(std::move(progress)), steps_(steps) {}

  void Text(const std::string& name, const std::string& content) {
    WriteTextFile(Place(name), content);
    files_.push_back(name);
    Step();
  }
  void Mesh(const std::string& name, const TriangleMesh& mesh) {
    WriteMesh(mesh, Place(name));
    files_.push_back(name);
    Step();
  }
  std::string Place(const std::string& name) const { return fmt::format("{}/{}", path_, name); }
  void Step() {
    ++done_;
    if (progress_) progress_(std::min(1.0, static_cast<double>(done_) / static_cast<double>(steps_)));
  }
  std::vector<std::string> files() const { return files_; }

 private:
  std::string path_;
  std::function<void(double)> progress_;
  std::size_t steps_;
  std::size_t done_ = 0;
  std::vector<std::string> files_;
};

void WritePieces(const PieceSet& set, const export_detail::Prepared& prepared, const ExportOptions& options,
                 std::set<std::string>& names, Folder& folder) {
  const char* extension = options.obj ? "obj" : "stl";
  Json list = Json::array();
  for (const int i : prepared.pieces) {
    const Piece& piece = set.piece(i);
    const PieceState& state = set.state(i);
    if (piece.mesh.triangles.empty()) continue;
    const std::string name = MakeFileName(piece.name, names);
    const std::string file = fmt::format("{}.{}", name, extension);
    const TriangleMesh mesh = options.triangles > 0 ? Decimate(piece.mesh, options.triangles) : piece.mesh;
    folder.Mesh(file, Moved(mesh, state.X_WP));
    const Vec3 centre = set.CalcCentroid(i);
    Json entry{{"name", piece.name},
               {"file", file},
               {"hidden", state.hidden},
               {"volume_mm3", piece.volume_mm3},
               {"centre_mm", {centre.x, centre.y, centre.z}},
               {"transform", MakeMatrix(state.X_WP)}};
    if (!(state.X_WP.p_AB == Vec3(0) && std::abs(state.X_WP.R_AB.w) == 1)) {
      entry["origin_file"] = fmt::format("{}_origin.{}", name, extension);
      entry["transform_file"] = name + ".tfm";
      folder.Mesh(fmt::format("{}_origin.{}", name, extension), mesh);
      folder.Text(name + ".tfm", FormatTransformFile(state.X_WP));
    }
    list.push_back(entry);
  }
  const Json json{{"frame", "LPS"},
                  {"units", "mm"},
                  {"transform", "4 x 4, row-major: from the piece's original position to the current one"},
                  {"pieces", list}};
  folder.Text("transforms.json", json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n");
  folder.Text("pieces.json", set.FormatJson());
}

}  // namespace

std::string FormatReportHtml(const ExportInput& input, const ExportOptions& options) {
  return export_detail::FormatReportHtml(input, export_detail::Prepare(input, options));
}

std::string FormatMeasuresCsv(const ExportInput& input, const ExportOptions& options) {
  return export_detail::FormatMeasuresCsv(input, export_detail::Prepare(input, options));
}

std::string FormatTransformFile(const Pose& X_WP) {
  const Pose X_PW{glm::conjugate(X_WP.R_AB), X_WP.InversePoint(Vec3(0))};
  const std::array<double, 16> m = MakeMatrix(X_PW);
  std::string parameters;
  for (const std::size_t row : {0u, 1u, 2u}) {
    for (const std::size_t column : {0u, 1u, 2u}) parameters += fmt::format(" {}", m[4 * row + column]);
  }
  for (const std::size_t row : {0u, 1u, 2u}) parameters += fmt::format(" {}", m[4 * row + 3]);
  return fmt::format(
      "#Insight Transform File V1.0\n#Transform 0\nTransform: AffineTransform_double_3_3\nParameters:{}\n"
      "FixedParameters: 0 0 0\n",
      parameters);
}

std::vector<std::string> WriteExport(const ExportInput& input, const std::string& folder_path,
                                     const ExportOptions& options, const std::function<void(double)>& progress) {
  MakeFolder(folder_path);
  FileBatch results(folder_path, "report.html");
  const export_detail::Prepared prepared = export_detail::Prepare(input, options);
  Folder folder(folder_path, progress, 7 + 3 * prepared.pieces.size() + input.pictures.size());
  // Reserved names for pieces and pictures.
  std::set<std::string> names{"report", "measures", "assessment", "planned", "achieved", "transforms", "pieces"};
  if (input.plan != nullptr && !input.plan->planes.empty()) {
    folder.Text("planned.mrk.json", FormatPlaneMarkups(MakeMarkups(*input.plan)));
  }
  if (input.assessment != nullptr) {
    const std::vector<PlaneMarkup> achieved = MakeCutMarkups(*input.assessment);
    if (!achieved.empty()) folder.Text("achieved.mrk.json", FormatPlaneMarkups(achieved));
    folder.Text("assessment.json", FormatAssessmentJson(input));
  }
  if (input.pieces != nullptr) WritePieces(*input.pieces, prepared, options, names, folder);
  for (const ExportPicture& picture : input.pictures) {
    folder.Text(MakeFileName(picture.name, names) + ".png", picture.png);
  }
  folder.Text("measures.csv", export_detail::FormatMeasuresCsv(input, prepared));
  folder.Text("report.html", export_detail::FormatReportHtml(input, prepared));
  results.Commit();
  if (progress) progress(1);
  return folder.files();
}

}  // namespace kerf
