#include "session/export/write_export.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <glm/geometric.hpp>
#include <nlohmann/json.hpp>
#include <sstream>

#include "base/files/html_text.h"
#include "bone/mesh/meshfile.h"
#include "session/export/curve_svg.h"
#include "session/export/html.h"
#include "support/folder.h"
#include "support/solids.h"

namespace kerf {
namespace {

using test::Folder;
using test::ReadBytes;
using ::testing::HasSubstr;
using ::testing::Not;
using ::testing::UnorderedElementsAre;

const std::string kNasty = "<script>alert('x')</script> & \"quotes\" ä";

/// A session with two pieces, the second moved and rotated; a plan with one plane that was cut and one that was not;
/// and a stop.
struct Session {
  Session() {
    pieces.Add(test::MakeBox({}, {4, 3, 2}, 0.25), "Left " + kNasty);
    pieces.Add(test::MakeSphere({6, 0, 0}, 2, 0.25), "right");
    pieces.Add(test::MakeSphere({16, 0, 0}, 1, 0.25), "dropped");
    pieces.MoveAlong(1, {1, 0, 0}, 2);
    pieces.RotateAbout(1, {6, 0, 0}, {0, 0, 1}, 30);
    pieces.Delete(2);
    plan.planes.push_back({.name = kNasty, .plane = {{1, 2, 3}, {0, 0, 1}}, .margin_mm = 1});
    plan.planes.push_back({.name = "other", .plane = {{9, 2, 3}, {0, 1, 0}}, .margin_mm = 1});
    plan.stops.push_back({.name = "stop", .p_W_mm = {0, 0, 0}, .direction_W = {0, 0, -1}, .depth_mm = 4});
    PlaneResult result;
    result.planned = plan.planes[0];
    result.cut = FittedPlane{.p_W_mm = {1, 2, 3.25}, .normal_W = glm::normalize(Vec3(0, 0.01, 1)), .width_mm = 0.4};
    result.offset_mm = 0.25;
    result.furthest_mm = -1.5;
    result.angles = {.angle_deg = 0.57, .pitch_deg = 0.57, .roll_deg = -0.001};
    PlaneResult none;
    none.planned = plan.planes[1];
    assessment.planes = {result, none};
    assessment.stops = {{.planned = plan.stops[0], .depth_mm = 4.5, .over_mm = 0.5}};
    assessment.before_mm3 = 1000;
    assessment.after_mm3 = 950;
    assessment.removed_mm3 = 50;
    assessment.outside_mm3 = 1.5;
    assessment.too_deep_mm3 = 0.25;
    taken.title = kNasty;
    taken.plan = &plan;
    taken.assessment = &assessment;
    taken.cut_states = {{.before_mm2 = 200, .left_mm2 = 66, .bridges = {Bridge{}}},
                        {.before_mm2 = 100, .left_mm2 = 100, .bridges = {Bridge{}}}};
    taken.pieces = &pieces;
    taken.figures = {{"duration", "s", 12.5}};
    taken.measures = {{.name = "ramus, height \"x\"", .unit = "mm", .value = 41.25, .points_W_mm = {}},
                      {.name = "angle", .unit = "deg", .value = 121.5, .points_W_mm = {}}};
    taken.pictures = {{.name = "after", .caption = kNasty, .png = "\x89PNG\r\n\x1a\n not really"}};
    ExportCurve curve{.title = "Force", .x_label = "time, s", .y_label = "force, N", .points = {}};
    for (int i = 0; i < 20000; ++i) curve.points.emplace_back(1e-3 * i, i == 7777 ? 42.0 : 1.0);
    taken.curves = {curve};
    taken.provenance = {{"scene", "s.toml"}, {"hash", "0123"}};
  }
  PieceSet pieces;
  Plan plan;
  Assessment assessment;
  ExportInput taken;
};

TEST(ExportInput, WritesAllFiles) {
  const Session session;
  const Folder folder;
  double last = 0;
  const std::vector<std::string> files = WriteExport(session.taken, folder.file("out"), {}, [&](double fraction) {
    EXPECT_GE(fraction, last);
    last = fraction;
  });
  EXPECT_EQ(last, 1);
  const std::string left = "left__script_alert__x____script_____quotes____";
  EXPECT_THAT(files, UnorderedElementsAre("planned.mrk.json", "achieved.mrk.json", "assessment.json", left + ".stl",
                                          "right.stl", "right_origin.stl", "right.tfm", "transforms.json",
                                          "pieces.json", "after.png", "measures.csv", "report.html"));
  for (const std::string& file : files) EXPECT_TRUE(std::filesystem::exists(folder.file("out/" + file))) << file;
  EXPECT_EQ(static_cast<std::size_t>(std::distance(std::filesystem::directory_iterator(folder.file("out")), {})),
            files.size());
  // The moved surface is the original's, moved, with the precision of a float at 10 mm.
  const TriangleMesh origin = ReadMesh(folder.file("out/right_origin.stl"));
  const TriangleMesh moved = ReadMesh(folder.file("out/right.stl"));
  ASSERT_EQ(origin.points.size(), moved.points.size());
  for (std::size_t i = 0; i < origin.points.size(); i += 17) {
    EXPECT_LT(glm::length(session.pieces.state(1).X_WP.Point(origin.points[i]) - moved.points[i]), 1e-5);
  }
  const auto transforms = nlohmann::json::parse(ReadBytes(folder.file("out/transforms.json")));
  ASSERT_EQ(transforms["pieces"].size(), 2u);
  EXPECT_EQ(transforms["pieces"][1]["origin_file"], "right_origin.stl");
  EXPECT_EQ(transforms["pieces"][1]["transform"].size(), 16u);
  EXPECT_FALSE(transforms["pieces"][0].contains("transform_file"));
  // The planes written for Slicer are read back.
  const auto planned = ReadPlaneMarkupList(folder.file("out/planned.mrk.json"));
  ASSERT_EQ(planned.size(), 2u);
  EXPECT_EQ(planned[0].name, kNasty);
  const auto achieved = ReadPlaneMarkupList(folder.file("out/achieved.mrk.json"));
  ASSERT_EQ(achieved.size(), 1u);
  EXPECT_NEAR(achieved[0].plane.p_W.z, 3.25, 1e-12);
  PieceSet again;
  again.Add(test::MakeBox({}, {4, 3, 2}, 0.25), "Left " + kNasty);
  again.Add(test::MakeSphere({6, 0, 0}, 2, 0.25), "right");
  again.Add(test::MakeSphere({16, 0, 0}, 1, 0.25), "dropped");
  again.Restore(ReadBytes(folder.file("out/pieces.json")), "pieces.json");
  EXPECT_TRUE(again.state(2).deleted);
}

TEST(ExportInput, ReportListsTheSessionsOfACase) {
  ExportInput input;
  input.sessions = {{.saw = "-"}, {.saw = "fine disc", .duration_s = 61, .in_bone_s = 12, .turning_force_N = 1.5}};
  const std::string html = FormatReportHtml(input);
  EXPECT_THAT(html, HasSubstr("<h2>Sessions</h2>"));
  EXPECT_THAT(html, HasSubstr("<td>fine disc</td><td>12</td><td>61</td><td>1.50</td><td>-</td></tr>"));
  EXPECT_THAT(html, HasSubstr("<td>-</td><td>-</td><td>-</td><td>-</td><td>-</td></tr>"));
  input.sessions.pop_back();
  EXPECT_THAT(FormatReportHtml(input), Not(HasSubstr("<h2>Sessions</h2>")));
}

TEST(ExportInput, ReportSaysThatTheHolderWasInTheBone) {
  ExportInput input;
  EXPECT_THAT(FormatReportHtml(input), Not(HasSubstr("To check")));
  input.hub_in_bone_W = Vec3{12.5, -30, 4};
  const std::string html = FormatReportHtml(input);
  EXPECT_THAT(html,
              HasSubstr("the hub of the blade was inside the bone (first at 12.5 mm left, 30.0 mm front, 4.0 mm"));
  EXPECT_THAT(html, Not(HasSubstr("handpiece")));
  input.handpiece_in_bone_W = Vec3{-2, 3, -4};
  EXPECT_THAT(FormatReportHtml(input), HasSubstr("the handpiece was inside the bone (first at 2.0 mm right"));
}

TEST(ExportInput, ReportStatesAValueOnce) {
  ExportInput input;
  input.figures = {{"duration", "s", 12.5}, {"work", "J", 3}};
  input.circumstances = {{"duration", "12 s"}};
  std::string html = FormatReportHtml(input);
  EXPECT_THAT(html, Not(HasSubstr("12.5")));
  EXPECT_THAT(html, HasSubstr("<th scope=\"row\">work</th><td>3</td>"));
  input.figures.pop_back();
  EXPECT_THAT(FormatReportHtml(input), Not(HasSubstr("<h2>Session</h2>")));
}

TEST(ExportInput, ReportSaysBetweenWhatADistanceIs) {
  ExportInput input;
  input.measures = {
      {.name = "distance 1", .unit = "mm", .value = 12, .points_W_mm = {}, .pieces = {"piece 1", "piece 2"}}};
  EXPECT_THAT(FormatReportHtml(input), HasSubstr("<td>piece 1 \u2013 piece 2</td><td>12.00</td><td>mm</td>"));
}

TEST(ExportInput, ReportNamesStructuresAndCircumstances) {
  StructureAssessment structures;
  structures.canal_known = true;
  structures.structures = {{.kind = MarkKind::kTooth,
                            .side = BodySide::kRight,
                            .number = 3,
                            .is_cut = true,
                            .removed_mm3 = 4.25,
                            .distance_mm = 0,
                            .p_W = {-20, 3, 4},
                            .part = ToothPart::kRoot},
                           {.kind = MarkKind::kCanal, .side = BodySide::kLeft, .distance_mm = 1.75, .p_W = {25, 0, -9}},
                           {.name = kNasty, .kind = MarkKind::kNerve, .is_mark = true}};
  ExportInput input;
  input.title = "case";
  input.structures = &structures;
  input.circumstances = {{"saw", "disc 22 x 0.25 mm"}};
  const std::string page = FormatReportHtml(input);
  EXPECT_THAT(page, HasSubstr("1 structure was cut."));
  EXPECT_THAT(page, HasSubstr("<th scope=\"row\">tooth 3 from the middle, patient's right</th><td>cut</td><td>0.0</td>"
                              "<td>4.2</td><td>root: 20.0 mm right, 3.0 mm back, 4.0 mm up</td>"));
  EXPECT_THAT(page, HasSubstr("patient's left</th><td>spared</td><td>1.8</td>"));
  EXPECT_THAT(page, HasSubstr(EscapeHtml(kNasty) + " (marked nerve)</th><td>spared</td><td>no cut</td>"));
  // The bone has no teeth, and none are marked: that is said, instead of leaving them out.
  EXPECT_THAT(page, HasSubstr("teeth and roots</th><td>not marked</td>"));
  EXPECT_THAT(page, Not(HasSubstr("nerve and its canal</th>")));
  EXPECT_THAT(page, HasSubstr("disc 22 x 0.25 mm"));
  EXPECT_THAT(page, Not(HasSubstr("<script>")));
  const std::string csv = FormatMeasuresCsv(input);
  EXPECT_THAT(csv, HasSubstr("least distance from the cut,mm,1.75"));
}

TEST(ExportInput, WritesObjAndOmitsMissingItems) {
  const Session session;
  const Folder folder;
  ExportInput taken;
  taken.pieces = &session.pieces;
  const auto files = WriteExport(taken, folder.file("out"), {.obj = true});
  EXPECT_THAT(files, testing::Contains("right.obj"));
  EXPECT_THAT(files, Not(testing::Contains("assessment.json")));
  const ExportInput nothing;
  EXPECT_THAT(WriteExport(nothing, folder.file("none")), UnorderedElementsAre("measures.csv", "report.html"));
}

TEST(ExportInput, WritesFewerTriangles) {
  const Session session;
  const Folder folder;
  ExportInput taken;
  taken.pieces = &session.pieces;
  WriteExport(taken, folder.file("out"), {.triangles = 200});
  const TriangleMesh ball = ReadMesh(folder.file("out/right_origin.stl"));
  EXPECT_LE(ball.triangles.size(), 200u);
  EXPECT_NEAR(CalcEnclosedVolume(ball), session.pieces.piece(1).volume_mm3, 0.05 * 33);
}

TEST(ExportInput, TransformFileIsTheInverseInLps) {
  const Pose X{glm::angleAxis(0.7, glm::normalize(Vec3(1, 2, 3))), {4, 5, 6}};
  std::istringstream text(FormatTransformFile(X));
  std::string line;
  std::getline(text, line);
  EXPECT_EQ(line, "#Insight Transform File V1.0");
  std::getline(text, line);
  std::getline(text, line);
  EXPECT_EQ(line, "Transform: AffineTransform_double_3_3");
  std::string word;
  text >> word;
  EXPECT_EQ(word, "Parameters:");
  double m[12];
  for (double& value : m) text >> value;
  // ITK's affine transform maps p to M p + t, from the piece's present position to the original one.
  const Vec3 p(1, -2, 3);
  const Vec3 q = X.Point(p);
  Vec3 back(0);
  for (int i = 0; i < 3; ++i) back[i] = m[3 * i] * q.x + m[3 * i + 1] * q.y + m[3 * i + 2] * q.z + m[9 + i];
  EXPECT_LT(glm::length(back - p), 1e-12);
}

TEST(ExportInput, CsvHasOneValuePerLine) {
  const Session session;
  const std::string csv = FormatMeasuresCsv(session.taken);
  EXPECT_THAT(csv, HasSubstr("subject,measure,unit,value\n"));
  EXPECT_THAT(csv, HasSubstr(",offset,mm,0.25\n"));
  EXPECT_THAT(csv, HasSubstr("stop,depth,mm,4.5\n"));
  EXPECT_THAT(csv, HasSubstr("bone,removed outside the margins,mm3,1.5\n"));
  EXPECT_THAT(csv, HasSubstr("\"ramus, height \"\"x\"\"\",distance,mm,41.25\n"));
  EXPECT_THAT(csv, HasSubstr("right,turned,deg,30\n"));
  EXPECT_THAT(csv, HasSubstr("session,duration,s,12.5\n"));
  // This is a name that a spreadsheet would execute.
  Session other;
  other.taken.measures[0].name = "=HYPERLINK(1)";
  EXPECT_THAT(FormatMeasuresCsv(other.taken), HasSubstr("\n'=HYPERLINK(1),distance,mm,41.25\n"));
  // The ball's centre was moved 2 mm along x and then rotated about (6, 0, 0), so it is at x = 6 + 2 cos 30. The gap is
  // this minus the ball's radius and half the box, 2 mm each.
  const std::string before_gap = "and right\",least gap,mm,";
  const std::size_t at = csv.find(before_gap);
  ASSERT_NE(at, std::string::npos);
  EXPECT_NEAR(std::stod(csv.substr(at + before_gap.size())), 2 + 2 * std::cos(0.5235987756), 0.02);
}

TEST(ExportInput, AssessmentJsonHasStableKeys) {
  Session session;
  session.assessment.planes[1].reach_mm = 5;
  StructureAssessment structures;
  structures.structures = {{.kind = MarkKind::kTooth,
                            .side = BodySide::kLeft,
                            .is_row = true,
                            .is_cut = true,
                            .removed_mm3 = 4.25,
                            .distance_mm = 0,
                            .p_W = {-20, 3, 4}},
                           {.kind = MarkKind::kCanal, .side = BodySide::kLeft, .distance_mm = 1.75, .p_W = {25, 0, -9}},
                           {.name = "N", .kind = MarkKind::kNerve, .is_mark = true}};
  session.taken.structures = &structures;
  const auto json = nlohmann::json::parse(FormatAssessmentJson(session.taken));
  EXPECT_EQ(json["planes"][0]["offset_mm"], 0.25);
  EXPECT_EQ(json["planes"][0]["within_margin"], false);
  EXPECT_FALSE(json["planes"][0].contains("reason"));
  EXPECT_TRUE(json["planes"][1]["cut"].is_null());
  EXPECT_EQ(json["planes"][1]["reason"], "no bone was removed within 5 mm of it");
  ASSERT_EQ(json["structures"].size(), 3U);
  EXPECT_EQ(json["structures"][0]["name"], "row of touching teeth, patient's left");
  EXPECT_EQ(json["structures"][0]["removed_mm3"], 4.25);
  EXPECT_EQ(json["structures"][1]["kind"], "canal");
  EXPECT_EQ(json["structures"][1]["nearest_mm"][2], -9);
  EXPECT_TRUE(json["structures"][2]["distance_mm"].is_null());
  EXPECT_EQ(json["nerve_distance_mm"], 1.75);
  ASSERT_EQ(json["pieces"].size(), 2U);  // the third is deleted
  EXPECT_EQ(json["pieces"][1]["name"], "right");
  EXPECT_NEAR(json["pieces"][1]["turned_deg"].get<double>(), 30, 1e-9);
  EXPECT_EQ(json["stops"][0]["too_deep_by_mm"], 0.5);
  EXPECT_EQ(json["removed_mm3"], 50);
  ExportInput alone;
  alone.assessment = &session.assessment;
  const auto without = nlohmann::json::parse(FormatAssessmentJson(alone));
  for (const char* key : {"structures", "nerve_distance_mm", "pieces"}) EXPECT_FALSE(without.contains(key)) << key;
}

/// Python's own parser accepts the report, every element is closed, and the report loads no external resource.
TEST(Report, IsSelfContainedValidHtml) {
  const Session session;
  const Folder folder;
  const std::string html = FormatReportHtml(session.taken);
  test::WriteBytes(folder.file("report.html"), html);
  test::WriteBytes(folder.file("check.py"), R"(
import sys
from html.parser import HTMLParser
class Check(HTMLParser):
    def __init__(self):
        super().__init__()
        self.open, self.bad, self.seen, self.words = [], [], set(), ""
    def handle_starttag(self, tag, attrs):
        self.seen.add(tag)
        for name, value in attrs:
            if name in ("src", "href") and not value.startswith("data:"): self.bad.append(f"{tag} {name}={value[:40]}")
            if name.startswith("on"): self.bad.append(name)
        if tag not in ("meta", "img", "br"): self.open.append(tag)
    def handle_startendtag(self, tag, attrs): self.seen.add(tag)
    def handle_endtag(self, tag):
        if not self.open or self.open.pop() != tag: self.bad.append("end of " + tag)
    def handle_data(self, data): self.words += data
check = Check()
check.feed(open(sys.argv[1], encoding="utf-8").read())
check.close()
if check.open: check.bad.append("open: " + " ".join(check.open))
if "script" in check.seen: check.bad.append("a script")
if "<script>alert('x')</script> & \"quotes\" ä" not in check.words: check.bad.append("the title is not shown as it is")
for tag in ("table", "svg", "polyline", "img", "h1", "style"):
    if tag not in check.seen: check.bad.append("no " + tag)
print("; ".join(check.bad))
sys.exit(1 if check.bad else 0)
)");
  const std::string command = fmt::format("python3 '{}' '{}' >'{}' 2>&1", folder.file("check.py"),
                                          folder.file("report.html"), folder.file("said"));
  const int code = std::system(command.c_str());
  if (code == 127 << 8) GTEST_SKIP() << "no python3";
  EXPECT_EQ(code, 0) << ReadBytes(folder.file("said"));
  EXPECT_THAT(html, Not(HasSubstr("http:")));
  EXPECT_THAT(html, Not(HasSubstr("https:")));
  EXPECT_THAT(html, Not(HasSubstr("url(")));
  EXPECT_THAT(html, HasSubstr("+0.25"));
  EXPECT_THAT(html, HasSubstr("no kerf found near it"));
  EXPECT_THAT(html, Not(HasSubstr("-0.00")));
  EXPECT_THAT(html, HasSubstr("1 of 2 planned planes cut, 0 within the margin."));
  EXPECT_THAT(html, HasSubstr(" is cut by 67 % of its area and still holds by 66.0 mm\u00b2."));
}

// Texts, names that the program has made, and numbers are those of the language; what the user has typed and the other
// files are the same in all languages.
TEST(Report, IsInTheLanguageOfTheWindow) {
  Session session;
  ExportInput& input = session.taken;
  const std::string csv = FormatMeasuresCsv(input);
  const std::string english = FormatReportHtml(input);
  input.language.code = "xx";
  input.language.point = ",";
  int texts = 0;
  input.language.translate = [&texts](const std::string& text) {
    ++texts;
    EXPECT_NE(text, "");
    return "<" + text + ">";
  };
  input.circumstances = {{"saw", "fine disc"}};
  const std::string page = FormatReportHtml(input);
  EXPECT_GT(texts, 40);
  EXPECT_THAT(page, HasSubstr("<html lang=\"xx\">"));
  EXPECT_THAT(page, HasSubstr("<h2>&lt;Bone&gt;</h2>"));
  EXPECT_THAT(page, HasSubstr("&lt;saw&gt;</th><td>fine disc</td>"));
  EXPECT_THAT(page, HasSubstr("+0,25"));
  EXPECT_THAT(page, Not(HasSubstr("+0.25")));
  EXPECT_THAT(page, HasSubstr("66,0 mm²"));
  EXPECT_THAT(page, HasSubstr(EscapeHtml("Left " + kNasty))) << "a name that the user has chosen";
  EXPECT_EQ(FormatMeasuresCsv(input), csv);
  input.language = {};
  input.circumstances.clear();
  EXPECT_EQ(FormatReportHtml(input), english);
  EXPECT_EQ(input.language.ShowName("plane 2"), "plane 2");
  input.language.translate = [](const std::string& text) { return text == "plane" ? "Ebene" : text; };
  EXPECT_EQ(input.language.ShowName("plane 2"), "Ebene 2");
  EXPECT_EQ(input.language.ShowName("plane"), "Ebene");
  EXPECT_EQ(input.language.ShowName("plane two"), "plane two");
  EXPECT_EQ(input.language.ShowName("airplane 2"), "airplane 2");
  // A saw has a name of its own or none.
  input.language.translate = [](const std::string& text) { return "<" + text + ">"; };
  EXPECT_EQ(input.language.ShowSaw("fine disc: disc 16 x 0.2 mm"), "<fine disc>: <disc 16 x 0.2 mm>");
  EXPECT_EQ(input.language.ShowSaw("disc 16 x 0.2 mm"), "<disc 16 x 0.2 mm>");
}

// Terms are those of the window, planes are described in the patient, and names for programs are shown small.
TEST(Report, UsesPlainWords) {
  Session session;
  ExportInput& input = session.taken;
  PlannedPlane& tilted = session.assessment.planes[0].planned;
  tilted.plane.normal_W = glm::normalize(Vec3{1, 0, 1});
  tilted.plane.p_W = {12.5, -3, 4};
  StructureAssessment structures;
  StructureResult nerve;
  nerve.kind = MarkKind::kCanal;
  nerve.is_cut = nerve.is_severed = true;
  structures.structures = {nerve};
  input.structures = &structures;
  input.circumstances = {{"force law", "grows with the bite", "hertz_chip"}};
  const std::string html = FormatReportHtml(input);
  EXPECT_THAT(html, HasSubstr("<td>severed</td>"));
  EXPECT_THAT(html, Not(HasSubstr("CUT")));
  EXPECT_THAT(html, HasSubstr("<td>45.0</td><td>90.0</td><td>45.0</td><td>12.5 mm left, 3.0 mm front, 4.0 mm up</td>"));
  EXPECT_THAT(html, HasSubstr("<td>grows with the bite<span class=\"technical\">hertz_chip</span></td>"));
}

TEST(Report, EmptyReportIsAValidPage) {
  const std::string html = FormatReportHtml(ExportInput{});
  EXPECT_THAT(html, HasSubstr("<h1>Report of a session</h1>"));
  EXPECT_THAT(html, HasSubstr("</html>\n"));
}

TEST(CurveSvg, PreservesThePeakAndStaysInItsFrame) {
  const Session session;
  const std::string svg = export_detail::FormatCurveSvg(session.taken.curves[0]);
  EXPECT_THAT(svg, HasSubstr(">50</text>"));
  EXPECT_LT(svg.size(), 60000u);
  const std::size_t begin = svg.find("points=\"") + 8;
  std::istringstream points(svg.substr(begin, svg.find('"', begin) - begin));
  double x = 0;
  double y = 0;
  char comma = 0;
  double top = 1e9;
  double last_x = 0;
  while (points >> x >> comma >> y) {
    EXPECT_GE(x, last_x);
    last_x = x;
    top = std::min(top, y);
    EXPECT_TRUE(x >= 64 && x <= 744.05 && y >= 16 && y <= 232.05) << x << " " << y;
  }
  // The value is 42 of 50 up the axis, which goes from 232 to 16.
  EXPECT_NEAR(top, 232 - 42.0 / 50 * 216, 0.06);
  for (const auto& odd :
       {std::vector<std::pair<double, double>>{}, {{1, 1}}, {{0, 0}, {1, 0}}, {{0, std::nan("")}, {2, 1e-9}}}) {
    const ExportCurve curve{.title = "<x>", .x_label = "t", .y_label = "f", .points = odd};
    EXPECT_THAT(export_detail::FormatCurveSvg(curve), Not(HasSubstr("nan")));
  }
}

TEST(Html, EncodesBase64AsInRfc4648) {
  // The cases are those of RFC 4648, section 10.
  const std::pair<const char*, const char*> cases[] = {{"", ""},
                                                       {"f", "Zg=="},
                                                       {"fo", "Zm8="},
                                                       {"foo", "Zm9v"},
                                                       {"foob", "Zm9vYg=="},
                                                       {"fooba", "Zm9vYmE="},
                                                       {"foobar", "Zm9vYmFy"}};
  for (const auto& [plain, coded] : cases) EXPECT_EQ(export_detail::Base64(plain), coded);
  EXPECT_EQ(export_detail::Base64(std::string("\xff\x00\xfe", 3)), "/wD+");
  EXPECT_EQ(EscapeHtml("<a b=\"c\">&'\x01"), "&lt;a b=&quot;c&quot;&gt;&amp;' ");
  EXPECT_EQ(export_detail::Show(-0.004, 2), "0.00");
  EXPECT_EQ(export_detail::Show(-0.006, 2), "-0.01");
  EXPECT_EQ(export_detail::Show(std::nan(""), 2), "-");
}

}  // namespace
}  // namespace kerf
