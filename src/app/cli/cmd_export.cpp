// kerf export: writes a bone's surface as a triangle mesh with the wanted number of triangles, or a segmentation.
#include <fmt/format.h>

#include <cmath>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "app/cli/commands.h"
#include "app/cli/ct_options.h"
#include "app/cli/message.h"
#include "app/cli/numbers.h"
#include "app/cli/progress.h"
#include "base/core/number_text.h"
#include "base/files/files.h"
#include "bone/import/dicom_input.h"
#include "bone/import/dicom_study.h"
#include "bone/import/import.h"
#include "bone/import/patient_frame.h"
#include "bone/mesh/decimate.h"
#include "bone/mesh/meshfile.h"
#include "bone/vdb/bonefile.h"
#include "kerf/error.h"
#include "kerf/surface.h"
#include "session/export/segments.h"
#include "view/picture/colours.h"

namespace kerf::cli {
namespace {

struct ExportArguments {
  std::string file;
  std::string output;
  std::size_t triangles = 0;  // 0: all
  std::string colour;
  bool pieces = false;
  std::string segmentation;
  std::string before;
  std::string ct;
  ImportOptions import;         // of the CT
  double segment_voxel_mm = 0;  // 0: that of the bone's regions
  double min_piece_mm3 = 1;
  bool json = false;
};

struct Exported {
  std::string file;
  std::size_t triangles = 0;
  std::size_t full_triangles = 0;
  double volume_mm3 = 0;
  double full_volume_mm3 = 0;
  std::size_t open_edges = 0;
  double deviation_mm = 0;        // largest distance of a triangle's corner or centre from the bone's surface
  double deviation_limit_mm = 0;  // larger distances are not measured
};

Exported ExportSurface(const Bone& bone, const ExportArguments& options, const std::string& path) {
  const TriangleMesh full = ExtractSurface(bone);
  if (full.triangles.empty()) throw Error(fmt::format("{}: contains no bone, so it has no surface", options.file));
  const TriangleMesh mesh = options.triangles > 0 ? Decimate(full, options.triangles) : full;
  Exported exported{path,
                    mesh.triangles.size(),
                    full.triangles.size(),
                    CalcEnclosedVolume(mesh),
                    CalcEnclosedVolume(full),
                    CountOpenEdges(mesh),
                    0,
                    bone.band_mm()};
  for (const auto& t : mesh.triangles) {
    const Vec3 middle = (mesh.points[t[0]] + mesh.points[t[1]] + mesh.points[t[2]]) / 3.0;
    exported.deviation_mm = std::max({exported.deviation_mm, std::abs(bone.SignedDistance(middle)),
                                      std::abs(bone.SignedDistance(mesh.points[t[0]]))});
  }
  if (options.colour.empty()) {
    WriteMesh(mesh, path);
  } else {
    const ColourBy by = options.colour == "region" ? ColourBy::kRegion : ColourBy::kTissue;
    WriteColouredMesh(mesh, CalcSurfaceColours(bone, mesh, by).points, path);
  }
  return exported;
}

// Returns x-1.stl, x-2.stl, ... for x.stl.
std::string NumberedPath(const std::string& path, std::size_t number) {
  const std::filesystem::path whole(path);
  return (whole.parent_path() / fmt::format("{}-{}{}", whole.stem().string(), number, whole.extension().string()))
      .string();
}

double CalcVolumeChangePercent(const Exported& exported) {
  return 100 * (exported.volume_mm3 / exported.full_volume_mm3 - 1);
}

/// Returns the frame of the CT that the user states, or has stated when the bone was imported; empty: neither.
std::string FindFrame(const Bone& bone, const ExportArguments& options) {
  const auto note = bone.notes().find("import_frame");
  if (!options.import.frame.empty() || note == bone.notes().end()) return options.import.frame;
  std::string frame = note->second.substr(0, 3);
  Say("{}: its frame was taken as {}, as when {} was imported", options.ct, frame, options.file);
  return frame;
}

/// Reads the study of the CT, which must contain the bone, and says what was left out and assumed.
DicomStudy ReadStudy(const Bone& bone, const ExportArguments& options) {
  const DicomInput input(options.ct);
  for (const DicomSeries& any : input.series()) {
    for (const DicomSlice& slice : any.slices) CheckInputsNotOverwritten({slice.path}, {options.segmentation});
  }
  const DicomSeries series = TakeAsCt(input.Choose(options.import.series), options.import.as_ct);
  DicomSeries placed = CheckSeries(series, options.import.spacing_z_mm);
  glm::dmat3 file_from_lps(1);
  if (const std::string frame = FindFrame(bone, options); !frame.empty()) {
    DropFrameWarnings(placed.warnings);
    file_from_lps = glm::transpose(LpsFromFrame(frame));
  }
  for (const std::string& warning : placed.warnings) Say("{}", warning);
  const Box3 box_W = bone.CalcBounds();
  Box3 box_in_file;
  for (const Vec3& corner_W : {box_W.lower, box_W.upper}) box_in_file.Include(file_from_lps * corner_W);
  CheckContains(placed, box_in_file, options.ct);
  DicomStudy study = ReadDicomStudy(placed);
  study.file_from_lps = file_from_lps;
  return study;
}

SegmentationWriting ExportSegmentation(const Bone& bone, const ExportArguments& options) {
  const double voxel_mm = options.segment_voxel_mm > 0 ? options.segment_voxel_mm : bone.region_voxel_mm();
  std::optional<DicomStudy> study;
  if (!options.ct.empty()) study = ReadStudy(bone, options);
  const Bone before = options.before.empty() ? Bone() : ReadBone(options.before);
  SegmentationWriting written;
  {
    ProgressBar bar("writing segments");
    written = WriteSegments(bone, options.before.empty() ? nullptr : &before, voxel_mm, options.segmentation,
                            study ? &*study : nullptr, [&bar](double fraction) { bar.Show(fraction); });
  }
  for (const std::string& name : written.without_voxels) {
    SayWarning("{}: '{}' has no voxel of {:g} mm and is left out", options.segmentation, name, voxel_mm);
  }
  return written;
}

double CalcVolume(const SegmentationWriting& written, const WrittenSegment& segment) {
  return static_cast<double>(segment.voxels) * std::pow(written.voxel_mm, 3);
}

nlohmann::ordered_json MakeJson(const std::string& path, const SegmentationWriting& written) {
  nlohmann::ordered_json json{{"file", path}, {"voxel_mm", written.voxel_mm}};
  json["segments"] = nlohmann::ordered_json::array();
  for (const WrittenSegment& s : written.segments) {
    json["segments"].push_back(
        {{"name", s.name}, {"label", s.label}, {"layer", s.layer}, {"volume_mm3", CalcVolume(written, s)}});
  }
  return json;
}

void PrintJson(const ExportArguments& options, const std::vector<Exported>& all, const Pieces& pieces,
               const std::optional<SegmentationWriting>& segmentation) {
  nlohmann::ordered_json json;
  json["bone"] = options.file;
  json["surfaces"] = nlohmann::ordered_json::array();
  for (const Exported& one : all) {
    json["surfaces"].push_back(
        {{"file", one.file},
         {"triangles", one.triangles},
         {"triangles_before_reduction", one.full_triangles},
         {"volume_mm3", one.volume_mm3},
         {"volume_change_percent", CalcVolumeChangePercent(one)},
         {"closed", one.open_edges == 0},
         {"open_edges", one.open_edges},
         {"largest_deviation_mm", one.deviation_mm},
         {"largest_deviation_is_lower_bound", one.deviation_mm >= one.deviation_limit_mm * 0.999}});
  }
  if (segmentation) json["segmentation"] = MakeJson(options.segmentation, *segmentation);
  if (options.pieces) json["left_out"] = {{"pieces", pieces.dust_count}, {"volume_mm3", pieces.dust_mm3}};
  fmt::print("{}\n", json.dump(2, ' ', false, nlohmann::ordered_json::error_handler_t::replace));
}

void Print(const ExportArguments& options, const std::vector<Exported>& all, const Pieces& pieces,
           const std::optional<SegmentationWriting>& segmentation) {
  for (const Exported& one : all) {
    fmt::print("{}: {} triangles, {:.2f} cm3, {}\n", one.file, one.triangles, one.volume_mm3 / 1000,
               one.open_edges == 0 ? std::string("closed") : fmt::format("not closed ({} open edges)", one.open_edges));
    if (one.triangles < one.full_triangles) {
      fmt::print("  reduced from {} triangles: volume {:+.3f} %, at most {}{:.3f} mm from the bone's surface\n",
                 one.full_triangles, CalcVolumeChangePercent(one),
                 one.deviation_mm >= one.deviation_limit_mm * 0.999 ? "more than " : "", one.deviation_mm);
    }
  }
  if (options.pieces && pieces.dust_count > 0) {
    fmt::print("{} smaller than {} mm3 omitted, {:.3f} mm3 in total\n",
               pieces.dust_count == 1 ? "1 piece" : fmt::format("{} pieces", pieces.dust_count), options.min_piece_mm3,
               pieces.dust_mm3);
  }
  if (!segmentation) return;
  fmt::print("{}: {}, voxels of {:.4g} mm\n", options.segmentation,
             FormatCount(segmentation->segments.size(), "segment", "segments"), segmentation->voxel_mm);
  for (const WrittenSegment& s : segmentation->segments) {
    fmt::print("  {}: {}\n", s.name, FormatVolume(CalcVolume(*segmentation, s)));
  }
}

/// Throws CLI::ParseError for options that do not fit together.
void Check(const CLI::App& command, const ExportArguments& options) {
  if (options.output.empty() && options.segmentation.empty()) throw CLI::RequiredError("--output or --seg");
  const bool is_dicom = options.segmentation.ends_with(".dcm");
  if (!options.segmentation.empty() && !is_dicom && !options.segmentation.ends_with(".seg.nrrd")) {
    throw CLI::ValidationError("--seg", fmt::format("'{}' must end in .seg.nrrd or .dcm", options.segmentation));
  }
  if (is_dicom && options.ct.empty()) {
    throw CLI::ValidationError("--seg", "a DICOM segmentation refers to the CT; name its folder with --ct");
  }
  if (!is_dicom && !options.ct.empty()) throw CLI::ValidationError("--ct needs --seg FILE.dcm");
  if (options.ct.empty()) RejectCtOptions(command, "needs --ct");
  if (options.segmentation.empty() && (!options.before.empty() || options.segment_voxel_mm > 0)) {
    throw CLI::ValidationError("--before and --seg-voxel need --seg");
  }
  const bool surface_options = options.pieces || options.triangles > 0 || !options.colour.empty();
  if (options.output.empty() && surface_options) {
    throw CLI::ValidationError("--pieces, --triangles and --colour need --output");
  }
  CheckInputsNotOverwritten({options.file, options.before}, {options.output, options.segmentation});
}

void Run(const CLI::App& command, const ExportArguments& options) {
  Check(command, options);
  const Bone bone = ReadBone(options.file);
  std::vector<Exported> all;
  Pieces pieces;
  if (options.pieces) {
    pieces = SplitPieces(bone, options.min_piece_mm3);
    if (pieces.pieces.empty()) {
      throw Error(
          fmt::format("{}: has no piece of at least {} mm3; lower --min-piece", options.file, options.min_piece_mm3));
    }
    for (std::size_t i = 0; i < pieces.pieces.size(); ++i) {
      CheckInputsNotOverwritten({options.file}, {NumberedPath(options.output, i + 1)});
    }
    for (std::size_t i = 0; i < pieces.pieces.size(); ++i) {
      all.push_back(ExportSurface(pieces.pieces[i], options, NumberedPath(options.output, i + 1)));
    }
  } else if (!options.output.empty()) {
    all.push_back(ExportSurface(bone, options, options.output));
  }
  std::optional<SegmentationWriting> segmentation;
  if (!options.segmentation.empty()) segmentation = ExportSegmentation(bone, options);
  if (options.json)
    PrintJson(options, all, pieces, segmentation);
  else
    Print(options, all, pieces, segmentation);
}

}  // namespace

void AddExportCommand(CLI::App& app) {
  const auto options = std::make_shared<ExportArguments>();
  CLI::App* command =
      app.add_subcommand("export", "Write a bone's surface as a triangle mesh (STL, OBJ or PLY), or a segmentation");
  command->add_option("BONE", options->file, "Bone file (.vdb)")->required();
  command->add_option("-o,--output", options->output,
                      "Mesh file to write; its extension (.stl, .obj, .ply) selects the format");
  AddNumberOption(*command, "--triangles", options->triangles, "triangles", kTrianglesRange,
                  "approximate maximum number of triangles; the shape and the volume are kept; default: no reduction");
  command
      ->add_option("--colour", options->colour,
                   "Colours of the points of a .ply: \"tissue\" or \"region\"; default: none")
      ->check(CLI::IsMember({"tissue", "region"}).description(""));
  command->add_flag("--pieces", options->pieces,
                    "Write each piece to a separate file: x-1.stl (the largest), x-2.stl, ...");
  command
      ->add_option("--min-piece", options->min_piece_mm3,
                   "With --pieces: volume below which pieces are omitted, mm3, 0 or more")
      ->check(CLI::NonNegativeNumber.description(""));
  command->add_option("--seg", options->segmentation,
                      "Segmentation to write for 3D Slicer (.seg.nrrd) or as DICOM (.dcm, with --ct): the bone, its "
                      "pieces, and its canals, teeth, lesions and metal");
  command->add_option("--before", options->before,
                      "With --seg: the bone before the cut (.vdb); what was removed becomes a segment");
  command->add_option(
      "--ct", options->ct,
      "With --seg FILE.dcm: the CT (DICOM folder, slice or .zip) that the bone was made from; patient and study "
      "are copied from it; --series, --as-ct, --frame and --spacing-z apply to it");
  AddCtOptions(*command, options->import, "The CT, with --ct");
  AddNumberOption(*command, "--seg-voxel", options->segment_voxel_mm, "seg_voxel_mm", kSegmentVoxelRange_mm,
                  "With --seg: voxel size; default: that of the bone's regions");
  command->add_flag("--json", options->json, "Print as JSON");
  command->callback([options, command] { Run(*command, *options); });
}

}  // namespace kerf::cli
