#include "app/window/export_order.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "support/folder.h"
#include "support/solids.h"
#include "view/ui/translate.h"

namespace kerf {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

constexpr double kVoxel_mm = 0.25;

/// Makes a bar of 12 x 4 x 4 mm with a gap of 1 mm beside its middle, or without it.
Bone MakeBar(bool cut) {
  SolidField field;
  field.value = [cut](const Vec3& p) {
    const double bar = test::BoxDistance(p, {6, 2, 2});
    return cut ? std::max(bar, 0.5 - std::abs(p.x - 2)) : bar;
  };
  field.classify = ClassifyByDistance(field.value);
  field.region = [](const Vec3&) { return 24; };
  const Box3 box{{-6, -2, -2}, {6, 2, 2}};
  return MakeBone(field, box.Grown(6 * kVoxel_mm), {kVoxel_mm, kVoxel_mm, {}}, test::OneRegionTable());
}

/// Exports a bar whose smaller piece was moved by 3 mm while it was cut, and returns the written files' texts.
struct Exported {
  explicit Exported(bool cut,
                    const std::vector<ProjectSession>& sessions = {{"fine disc", 61, 3, 1.5, {{0, 0}, {9, 1.5}}}},
                    const std::string& language = "", const std::string& notes = "the first. the second") {
    PieceSet arranged(MakeBar(true), 1);
    arranged.Move(1, {3, 0, 0});
    ExportOrder order;
    order.folder = folder.path();
    order.scene.tool.shape = DiscSaw{.thickness_mm = 0.5};
    Bone before = MakeBar(false);
    before.set_note("import_input", "DICOM");
    before.set_note("import_ct_voxels", "250 250 160");
    before.set_note("import_ct_spacing_mm", "1 1 0.5");
    before.set_note("import_series_uid", "1.2.840");
    before.set_note("import_warnings", notes);
    before.set_note("import_surface_error_mm", "0.31 expected (rms): offset +0.05, scatter 0.20; half height 640 HU");
    order.before = std::make_shared<const Bone>(std::move(before));
    order.title = "Left jaw";
    order.scene.title = "scan of May";
    order.sessions = sessions;
    order.progress = [this](double fraction) {
      EXPECT_GE(fraction, progress);
      progress = fraction;
    };
    std::promise<Bone> after;
    after.set_value(MakeBar(cut));
    order.input = "/scans/may";
    order.after = after.get_future();
    order.pieces_json = arranged.FormatJson();
    // 8 mm apart where they were cut off; the second one was moved by 3 mm.
    order.measurements = {{{"piece 1", {-3, 0, 0}}, {"piece 2", {5, 0, 0}}},
                          {{"piece 2", {5, 0, 0}}, {"piece 2", {5, 1, 0}}, {"piece 2", {6, 1, 0}}}};
    if (!language.empty()) {
      order.language = {.code = language,
                        .translate = [language](const std::string& text) { return TranslateInto(language, text); },
                        .point = DecimalPointOf(language)};
    }
    RunExport(order);
    measures = test::ReadBytes(folder.file("measures.csv"));
    report = test::ReadBytes(folder.file("report.html"));
    transforms = nlohmann::json::parse(test::ReadBytes(folder.file("transforms.json")));
  }
  test::Folder folder;
  std::string measures;
  std::string report;
  double progress = 0;
  nlohmann::json transforms;
};

/// Returns the row of a table in a report with two columns.
std::string MakeRow(const std::string& name, const std::string& value) {
  return "<th scope=\"row\">" + name + "</th><td>" + value + "</td>";
}

TEST(ExportOrder, ReportNamesTheCaseAndItsCt) {
  const Exported exported(true);
  EXPECT_THAT(exported.report, HasSubstr("<h1>Left jaw</h1>"));
  EXPECT_THAT(exported.report, HasSubstr(MakeRow("CT", "/scans/may; 250 x 250 x 160 voxels of 1 x 1 x 0.5 mm")));
  EXPECT_THAT(exported.report, HasSubstr(MakeRow("DICOM series", "1.2.840")));
  EXPECT_THAT(exported.report, HasSubstr(MakeRow("notes of the import", "The first. The second.")));
  EXPECT_EQ(exported.progress, 1);
}

// Also what other parts of kerf have written into the bone's file and the project is in the language of the window.
TEST(ExportOrder, GermanReportIsGerman) {
  const ProjectSession session{"fine disc 16 mm: disc 16 x 0.2 mm, 40 teeth", 61, 3, 1.5, {{0, 0}, {9, 1.5}}};
  const Exported exported(
      true, {session}, "de",
      "the segmentation gives 2 separate pieces of bone. 12.5 % of the wanted bone of the mask lies "
      "outside the scan");
  const std::string& report = exported.report;
  EXPECT_THAT(report, HasSubstr(MakeRow("CT", "/scans/may; 250 x 250 x 160 Voxel von 1 x 1 x 0,5 mm")));
  EXPECT_THAT(report, HasSubstr(MakeRow("Hinweise zum Import",
                                        "Die Segmentierung ergibt 2 getrennte Knochenteile. 12,5 % des gewünschten "
                                        "Knochens der Maske liegen außerhalb der Aufnahme.")));
  EXPECT_THAT(report, HasSubstr("etwa 0,31 mm: Sie liegt im Mittel 0,05 mm zu weit außen und schwankt um 0,20 mm"));
  EXPECT_THAT(report, HasSubstr("feine Scheibe 16 mm: Scheibe 16 x 0,2 mm, 40 Zähne"));
  EXPECT_THAT(report, HasSubstr("Abstand 1"));
  EXPECT_THAT(report, HasSubstr("jede mit einem Anteil der Schneide"));
  EXPECT_THAT(exported.measures, HasSubstr("distance 1")) << "files for programs are the same in all languages";
}

TEST(ExportOrder, ReportCoversAllSessionsOfTheCase) {
  const ProjectSession now{"fine disc", 61, 3, 1.5, {{0, 0}, {9, 1.5}}, true, 1.5, 0.5, 9};
  const Exported exported(true, {{"ball burr", 30, 2, 2.25, {{1, 2.25}}, true, 0.75, 2.25, 4}, now});
  EXPECT_THAT(exported.report, HasSubstr(MakeRow("saw", "ball burr; fine disc")));
  EXPECT_THAT(exported.report, HasSubstr(MakeRow("time with the saw in bone", "13 s")));
  EXPECT_THAT(exported.report, HasSubstr(MakeRow("time of the session", "91 s")));
  // A stopped saw that is pulled out of its kerf can need more force than the cut.
  EXPECT_THAT(exported.report, HasSubstr(MakeRow("largest force on the hand in bone, spindle turning", "1.50 N")));
  EXPECT_THAT(exported.report, HasSubstr(MakeRow("largest force on the hand in bone, spindle stopped", "2.25 N")));
  // A session in which nothing was done is left out.
  const Exported exchanged(true, {{"saw that was exchanged", 0.2, 0, 0.25}, now});
  EXPECT_THAT(exchanged.report, Not(HasSubstr("saw that was exchanged")));
  // Files of earlier versions say nothing about their sessions, and nothing was cut since: this is not 0 N.
  const Exported unknown(true, {{"-", {}, {}, {}, {}}, {"fine disc", 5, 0, 0, {{0, 0}, {5, 0}}}});
  EXPECT_THAT(unknown.report, HasSubstr(MakeRow("largest force on the hand in bone, spindle turning",
                                                "- (not known for the sessions before)")));
  EXPECT_THAT(unknown.measures, Not(HasSubstr("largest force")));
}

TEST(ExportOrder, WritesPiecesWhereTheyWereArranged) {
  const Exported exported(true);
  ASSERT_EQ(exported.transforms["pieces"].size(), 2u);
  EXPECT_EQ(exported.transforms["pieces"][0]["transform"][3], 0);
  EXPECT_EQ(exported.transforms["pieces"][1]["transform"][3], 3);
  EXPECT_THAT(exported.measures, HasSubstr("distance 1"));
  const auto row = [&](const std::string& name) {
    const std::size_t at = exported.measures.find(name);
    return at == std::string::npos ? "" : exported.measures.substr(at, exported.measures.find('\n', at) - at);
  };
  EXPECT_THAT(row("distance 1"), HasSubstr("11")) << exported.measures;
  EXPECT_THAT(row("angle 2"), HasSubstr("90")) << exported.measures;
}

TEST(ExportOrder, OmitsMeasurementsOfPiecesThatAreOneAgain) {
  const Exported exported(false);  // the cut was undone
  ASSERT_EQ(exported.transforms["pieces"].size(), 1u);
  EXPECT_EQ(exported.transforms["pieces"][0]["transform"][3], 0);
  EXPECT_THAT(exported.measures, Not(HasSubstr("distance 1")));
}

}  // namespace
}  // namespace kerf
