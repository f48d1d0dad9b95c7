// kerf slab: cuts a bone into the paper's three parts.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <memory>
#include <string>
#include <vector>

#include "app/cli/commands.h"
#include "app/cli/message.h"
#include "app/cli/numbers.h"
#include "app/cli/progress.h"
#include "base/files/markups.h"
#include "bone/mesh/decimate.h"
#include "bone/vdb/bonefile.h"
#include "kerf/error.h"
#include "session/run/write_parts.h"
#include "view/picture/picture.h"

namespace kerf::cli {
namespace {

/// Larger values than these cause a warning (docs/slab.md lists typical values).
constexpr double kLargestDifference_percent = 0.1;
constexpr double kLargestThicknessError_mm = 0.01;

struct SlabArguments {
  std::string plane;
  std::string plane_markups;
  std::string near_point;
  std::vector<std::string> formats{"obj", "stl", "vdb"};
  bool no_picture = false;
  bool json = false;
  SlabCut cut;
  PartsOptions parts;
};

CutPlane ParsePlane(const std::string& text) {
  const auto v = ParseNumbers(text, ',', 6, "--plane",
                              "a point and a normal, x,y,z,nx,ny,nz with the point in mm, such as 24,30,0,0,1,0");
  const auto normal = CalcDirection({v[3], v[4], v[5]});
  if (!normal) throw CLI::ValidationError("--plane", fmt::format("'{}' has a zero normal", text));
  return {{v[0], v[1], v[2]}, *normal};
}

void Print(const PartsReport& r, const std::string& folder) {
  const Vec3& p = r.plane.p_W;
  const Vec3& n = r.plane.normal_W;
  fmt::print(
      "plane      through ({:.2f}, {:.2f}, {:.2f}), normal ({:.4f}, {:.4f}, {:.4f}); {:.1f} mm from its point to "
      "the cut\n",
      p.x, p.y, p.z, n.x, n.y, n.z, r.distance_mm);
  fmt::print("slice      {:g} mm thick; {:.4f} mm between the faces of its surface; section {:.1f} mm2\n",
             r.thickness_mm, r.measured_thickness_mm, r.section_mm2);
  fmt::print("{:<8}{:>14}{:>10}{:>8}{:>12}  {}\n", "part", "volume, mm3", "share, %", "pieces", "triangles", "surface");
  for (const PartFile& part : r.parts) {
    fmt::print("{:<8}{:>14.3f}{:>10.3f}{:>8}{:>12}  {}\n", part.name, part.volume_mm3,
               100 * part.volume_mm3 / r.whole_mm3, part.pieces, part.triangles,
               part.open_edges == 0 ? std::string("closed") : fmt::format("{} open edges", part.open_edges));
  }
  fmt::print("{:<8}{:>14.3f}{:>10.3f}  of {:.3f} mm3 ({:+.4f} %)\n", "sum", r.sum_mm3, 100 * r.sum_mm3 / r.whole_mm3,
             r.whole_mm3, r.CalcDifferencePercent());
  for (const PartFile& part : r.parts) {
    if (part.crumbs == 0) continue;
    fmt::print("{:<8}  and {} of {:.2g} mm3 in total, each below {:g} % of the part\n", part.name,
               part.crumbs == 1 ? "a crumb" : fmt::format("{} crumbs", part.crumbs), part.crumbs_mm3,
               100 * kCrumbFraction);
  }
  fmt::print("written    {}/:", folder);
  for (const PartFile& part : r.parts) {
    for (const std::string& file : part.files) fmt::print(" {}", file);
  }
  for (const std::string& file : r.files) fmt::print(" {}", file);
  fmt::print("\n");
}

void Warn(const PartsReport& r, bool everywhere, bool reduced) {
  if (std::abs(r.CalcDifferencePercent()) > kLargestDifference_percent) {
    Say("the parts' volumes differ by {:+.2f} % from the bone's: voxels of {:g} mm are coarse for this bone and cut; "
        "make the bone again with smaller voxels",
        r.CalcDifferencePercent(), r.parts.front().voxel_mm);
  }
  if (const double off_mm = r.measured_thickness_mm - r.thickness_mm;
      !(std::abs(off_mm) <= kLargestThicknessError_mm)) {
    Say("the slice's surface is {:.3f} mm thick instead of {:g} mm; {}", r.measured_thickness_mm, r.thickness_mm,
        reduced ? "allow more --triangles" : "make the bone again with smaller voxels, or make the slice thicker");
  }
  if (!everywhere && r.cut_places > 1) {
    Say("the bone is cut in {} places, because fewer cuts leave it in one piece", r.cut_places);
  }
  if (!everywhere && r.places > r.cut_places) {
    Say("the plane passes through the bone in {} places; {} of them {} not cut (--near chooses another, --everywhere "
        "cuts all)",
        r.places, r.places - r.cut_places, r.places - r.cut_places == 1 ? "is" : "are");
  }
}

void Run(SlabArguments& options) {
  if (options.plane.empty() == options.plane_markups.empty()) {
    throw CLI::ValidationError("--plane", "give the plane by either --plane or --plane-markups");
  }
  if (options.cut.everywhere && !options.near_point.empty()) {
    throw CLI::ValidationError("--near", "can't be combined with --everywhere");
  }
  if (!options.plane.empty()) options.cut.plane = ParsePlane(options.plane);
  if (!options.near_point.empty()) {
    options.cut.near_W = ParsePoint(options.near_point, "--near");
  }
  const auto wanted = [&options](const char* format) {
    return std::find(options.formats.begin(), options.formats.end(), format) != options.formats.end();
  };
  options.parts.obj = wanted("obj");
  options.parts.stl = wanted("stl");
  options.parts.vdb = wanted("vdb");
  const std::string lack = options.no_picture ? "" : FindLackOfPictures();
  if (!lack.empty()) SayWarning("{}", lack);
  options.parts.picture = !options.no_picture && lack.empty();
  options.parts.plane_file = options.plane_markups;
  if (!options.plane_markups.empty()) options.cut.plane = ReadPlaneMarkups(options.plane_markups);
  PartsReport report;
  {
    ProgressBar bar("cutting");
    const Bone bone = ReadBone(options.parts.bone_file);
    options.parts.progress = [&bar](double fraction) { bar.Show(fraction); };
    report = CutAndWriteParts(bone, options.cut, options.parts);
  }
  Warn(report, options.cut.everywhere, options.parts.triangles > 0);
  if (options.json) {
    fmt::print("{}", FormatPartsJson(report));
  } else {
    Print(report, options.parts.folder);
  }
}

}  // namespace

void AddSlabCommand(CLI::App& app) {
  const auto o = std::make_shared<SlabArguments>();
  CLI::App* c = app.add_subcommand(
      "slab", "Cut a bone into the paper's three parts: left segment, thin slice and right segment (docs/slab.md)");
  c->add_option("BONE", o->parts.bone_file, "Bone file (.vdb)")->required();
  c->add_option("-o,--output", o->parts.folder, "Folder for the results; created if missing")->required();
  c->add_option("--plane", o->plane,
                "Middle plane of the slice, x,y,z,nx,ny,nz: a point, mm, -10^6 to 10^6, and a normal of any length "
                "that points to the right segment, in patient coordinates LPS");
  c->add_option(
      "--plane-markups", o->plane_markups,
      "File of 3D Slicer (.mrk.json) with the plane, or with three or more points to which a plane is fitted");
  AddNumber(*c, "--thickness", o->cut, "thickness_mm");
  c->add_option("--near", o->near_point,
                "Point x,y,z, mm: if the plane passes through the bone in several places, the nearest one is cut; "
                "default: the plane's point");
  c->add_flag("--everywhere", o->cut.everywhere, "Cut in all places where the plane passes through the bone");
  c->add_option("--formats", o->formats, "Formats in which to write each part, separated by commas: obj, stl, vdb")
      ->delimiter(',')
      ->check(CLI::IsMember({"obj", "stl", "vdb"}).description(""));
  AddNumberOption(*c, "--triangles", o->parts.triangles, "triangles", kTrianglesRange,
                  "approximate maximum number of triangles of each part; default: no reduction");
  c->add_flag("--no-picture", o->no_picture, "Draw no picture (parts.png)");
  c->add_flag("--json", o->json, "Print as JSON (parts.json)");
  c->callback([o] { Run(*o); });
}

}  // namespace kerf::cli
