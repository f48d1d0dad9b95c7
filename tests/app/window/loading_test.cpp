// Loading, cancelling and saving behind the window.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <filesystem>
#include <fstream>
#include <memory>
#include <thread>
#include <utility>

#include "app/window/bone_saver.h"
#include "app/window/input_loader.h"
#include "app/window/live_session.h"
#include "app/window/open_input.h"
#include "app/window/progress_meter.h"
#include "base/core/cancelled.h"
#include "bone/grid/ct_modulus.h"
#include "bone/import/ct_files.h"
#include "bone/import/import.h"
#include "bone/models/block.h"
#include "bone/vdb/bonefile.h"
#include "kerf/error.h"
#include "support/folder.h"
#include "support/message_of.h"
#include "support/solids.h"
#include "view/live/slice_view.h"
#include "view/ui/translate.h"

namespace kerf {
namespace {

namespace fs = std::filesystem;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

// The window has no options of the command line.
TEST(ExplainRefusal, LeavesOutWhatNamesAnOption) {
  EXPECT_EQ(ExplainRefusal("a: the folder is empty"), "a: the folder is empty");
  const std::string hint = ". In a terminal, 'kerf import' has options for this.";
  EXPECT_EQ(ExplainRefusal("a: left-handed; specify where x, y and z point with --frame, such as --frame LAS"),
            "a: left-handed" + hint);
  EXPECT_EQ(ExplainRefusal("a: with voxels of 1 mm: check its unit (--units) or use --voxel 2 or more"),
            "a: with voxels of 1 mm" + hint);
  EXPECT_EQ(ExplainRefusal("/a --old/b: no bone; lower --iso"), "/a --old/b: no bone" + hint);
  EXPECT_EQ(ExplainRefusal("/a --old/b: no bone"), "/a --old/b: no bone");
  EXPECT_EQ(ExplainRefusal("a: unequal slices\nwarning: 2 CT series; choose another with --series UID: 1.2"),
            "a: unequal slices\n2 CT series" + hint);
}

// The catalogue has the sentences as the import says them.
TEST(ExplainRefusal, FrequentOnesAreTranslated) {
  const test::Folder folder;
  for (const char* name : {"empty", "notes", "mr", "two"}) fs::create_directory(folder.file(name));
  std::ofstream(folder.file("notes/notes.txt")) << "no scan";
  const auto ball = [](int slices) {
    return test::MakeCt({20, 20, slices}, {2, 2, 2}, {-19, -19, -19}, glm::dmat3(1), test::Ball({0, 0, 0}, 5), 900);
  };
  test::WriteNrrd(ball(20), folder.file("small.nrrd"));
  test::SliceSpec mr;
  mr.modality = "MR";
  test::WriteDicom(ball(20), folder.file("mr"), mr);
  test::WriteDicom(ball(2), folder.file("two"));
  SetLanguage("de");
  for (const auto& [name, begin] :
       {std::pair("empty", "Der Ordner ist leer"), std::pair("notes", "Keine der 1 Dateien des Ordners"),
        std::pair("mr", "Die Modalität ist MR, nicht CT"), std::pair("two", "2 Schichten sind kein Volumen"),
        std::pair("small.nrrd", "Die Aufnahme enthält keinen Knochen: Nichts über 300 HU")}) {
    const std::string path = folder.file(name);
    const std::string refusal = test::MessageOf([&] { Import(path, {}); });
    EXPECT_THAT(ExplainRefusal(refusal), HasSubstr(begin)) << refusal;
  }
  EXPECT_THAT(
      ExplainRefusal("series 1.2.3: 3 slices are missing between a and b (at 1.00 and 9.00 mm; slices elsewhere "
                     "are 2.00 mm apart); what is missing belongs to the bone, so export the series again with "
                     "all its slices"),
      HasSubstr("Serie 1.2.3: 3 Schichten fehlen zwischen a und b (bei 1,00 und 9,00 mm; Abstand sonst 2,00 mm)"));
  SetLanguage("en");
}

TEST(ProgressMeter, EstimatesTheTimeThatIsLeft) {
  ProgressMeter meter;
  meter.Set("making", 0, 10);
  EXPECT_FALSE(meter.Get(15).seconds_left);
  meter.Set("making", 0.25, 12);
  EXPECT_EQ(meter.Get(12).stage, "making");
  EXPECT_EQ(meter.Get(12).fraction, 0.25);
  EXPECT_EQ(meter.Get(12).seconds_left, 6);  // 2 s for a quarter
  // Between reports it counts down, at first by the time that passes: exp(-x) = 1 - x, but for x^2 / 2.
  EXPECT_NEAR(*meter.Get(12.06).seconds_left, 5.94, 6 * 0.01 * 0.01 / 2);
  EXPECT_NEAR(meter.Get(12.06).fraction, 0.25 + 0.06 / 8, 0.75 * 0.01 * 0.01 / 2);
  EXPECT_NEAR(*meter.Get(18).seconds_left, 6 * std::exp(-1), 1e-12);
  // The end is not claimed before it is reported.
  EXPECT_GT(*meter.Get(50).seconds_left, 0);
  EXPECT_LT(meter.Get(50).fraction, 1);
  meter.Set("making", 0.1, 13);  // never goes back
  EXPECT_EQ(meter.Get(12).fraction, 0.25);
  // A report of less than what is shown does not move it back either. The time left, of which 2 s were expected,
  // follows the rate since the report before, by which it would be 8 s: a quarter in 4 s.
  const double shown = meter.Get(16).fraction;
  EXPECT_GT(shown, 0.5);
  meter.Set("making", 0.5, 16);
  EXPECT_EQ(meter.Get(16).fraction, shown);
  EXPECT_NEAR(*meter.Get(16).seconds_left, 2 + (8 - 2) * (1 - std::exp(-4.0 / 5)), 1e-12);
  meter.Set("making", 1.5, 18);
  EXPECT_EQ(meter.Get(18).fraction, 1);
  EXPECT_EQ(meter.Get(18).seconds_left, 0);
  // A new stage begins at its own fraction, and nothing is estimated from its first second or from too small a part.
  meter.Set("saving", 0.2, 20);
  EXPECT_EQ(meter.Get(20).fraction, 0.2);
  meter.Set("saving", 0.5, 20.9);
  EXPECT_FALSE(meter.Get(20.9).seconds_left);
  meter.Set("reading", 0, 30);
  meter.Set("reading", 0.01, 40);
  EXPECT_FALSE(meter.Get(40).seconds_left);
}

// A first part that is much faster than the rest makes the estimate too small. It must not stay so.
TEST(ProgressMeter, CorrectsAnEstimateThatWasTooSmall) {
  ProgressMeter meter;
  meter.Set("importing", 0, 0);
  meter.Set("importing", 0.25, 1);  // a quarter in 1 s, and the rest in 75 s
  EXPECT_EQ(meter.Get(1).seconds_left, 3);
  for (int s = 2; s <= 76; ++s) {
    meter.Set("importing", 0.25 + 0.01 * (s - 1), s);
    const double left_s = *meter.Get(s).seconds_left;
    const double truly_s = 76 - s;
    EXPECT_LE(left_s, truly_s + 0.5) << s;
    if (s < 20) continue;
    EXPECT_GE(left_s, 0.95 * truly_s) << s;
  }
  EXPECT_EQ(meter.Get(76).seconds_left, 0);
}

TEST(BoneSaver, WritesWholeFilesInTheBackground) {
  const test::Folder folder;
  const auto a = std::make_shared<const Bone>(test::MakeSphere({0, 0, 0}, 4, 0.4));
  const auto b = std::make_shared<const Bone>(test::MakeSphere({0, 0, 0}, 3, 0.4));
  {
    BoneSaver saver;
    saver.Save(a, folder.file("a.vdb"));
    saver.Save(b, folder.file("b.vdb"));
    EXPECT_THAT(saver.Finish(), IsEmpty());
    EXPECT_EQ(ReadBone(folder.file("a.vdb")).CalcHash(), a->CalcHash());
    EXPECT_EQ(ReadBone(folder.file("b.vdb")).CalcHash(), b->CalcHash());
    EXPECT_EQ(a.use_count(), 1) << "a written bone is no longer kept";
    saver.Save(b, folder.file("c.vdb"));
  }
  // The destructor completes what is left.
  EXPECT_EQ(ReadBone(folder.file("c.vdb")).CalcHash(), b->CalcHash());
}

TEST(BoneSaver, KeepsABoneThatCannotBeWrittenAndTriesAgain) {
  const test::Folder folder;
  const auto bone = std::make_shared<const Bone>(test::MakeSphere({0, 0, 0}, 4, 0.4));
  BoneSaver saver;
  saver.Save(bone, folder.file("later/a.vdb"));
  saver.Save(bone, folder.file("never/a.vdb"));
  std::vector<std::string> failures;
  while (failures.size() < 2) {
    for (std::string& sentence : saver.TakeFailures()) failures.push_back(std::move(sentence));
    std::this_thread::yield();
  }
  EXPECT_THAT(failures, ElementsAre(HasSubstr("later/a.vdb: "), HasSubstr("never/a.vdb: ")));
  EXPECT_GT(bone.use_count(), 1);
  fs::create_directory(folder.file("later"));
  EXPECT_THAT(saver.Finish(), ElementsAre(HasSubstr("never/a.vdb: ")));
  EXPECT_EQ(ReadBone(folder.file("later/a.vdb")).CalcHash(), bone->CalcHash());
}

OpenWatcher Quiet() {
  OpenWatcher watcher;
  watcher.progress = [](const std::string&, double) {};
  return watcher;
}

TEST(OpenInput, ShowsABoneAndKeepsIt) {
  const test::Folder folder;
  const Bone bone = test::MakeSphere({10, 20, 30}, 8, 0.4);
  WriteBone(bone, folder.file("a.vdb"));
  int shown = 0;
  OpenWatcher watcher = Quiet();
  watcher.bone = [&](const std::shared_ptr<const Bone>& seen, bool final) {
    ++shown;
    EXPECT_TRUE(final);
    EXPECT_EQ(seen->CalcHash(), bone.CalcHash());
  };
  const OpenedInput opened = OpenInput(folder.file("a.vdb"), {}, watcher);
  EXPECT_EQ(shown, 1);
  EXPECT_TRUE(opened.bone_was_shown);
  EXPECT_TRUE(opened.bone_is_saved);
  EXPECT_EQ(opened.bone->CalcHash(), bone.CalcHash());
  EXPECT_EQ(opened.scene.bone.file, folder.file("a.vdb"));
}

TEST(OpenInput, NamesACaseByThePatientsFolder) {
  EXPECT_EQ(NameCaseOf("/cts/miller/dicom"), "miller");
  EXPECT_EQ(NameCaseOf("/cts/miller/DICOM/"), "miller");
  EXPECT_EQ(NameCaseOf("/cts/miller"), "miller");
  EXPECT_EQ(NameCaseOf("/cts/miller.nrrd"), "miller.nrrd");
  EXPECT_EQ(NameCaseOf("/dicom"), "dicom");
}

TEST(OpenInput, TheCaseOfAnExtensionDoesNotMatter) {
  const test::Folder folder;
  const Bone bone = test::MakeSphere({10, 20, 30}, 8, 0.4);
  WriteBone(bone, folder.file("a.vdb"));
  Project project;
  project.scene = MakeSceneAround(folder.file("a.vdb"), bone);
  project.bone_file = folder.file("a.vdb");
  WriteProject(folder.file("a.kerf-project"), project);
  test::WriteBytes(folder.file("a.toml"), ResolvedToml(project.scene));
  for (const std::string name : {"a.vdb", "a.toml", "a.kerf-project"}) {
    std::string upper = "A";
    for (const char c : name.substr(1)) upper += static_cast<char>(std::toupper(c));
    std::filesystem::copy_file(folder.file(name), folder.file(upper));
    EXPECT_NO_THROW(CheckInput(folder.file(upper))) << upper;
    const OpenedInput opened =
        OpenInput(folder.file(upper), {.bone_file = "", .project_folder = folder.file(upper + "_out")}, Quiet());
    EXPECT_EQ(opened.bone->CalcHash(), bone.CalcHash()) << upper;
  }
}

TEST(CheckInput, TakesFilesOfDicomWithAnyName) {
  const test::Folder folder;
  const std::string dicom = std::string(128, '\0') + "DICM";
  for (const char* name : {"scan.dcm", "SCAN.DCM", "IM0001", "DICOMDIR", "1.2.840.113619"}) {
    test::WriteBytes(folder.file(name), dicom);
    EXPECT_NO_THROW(CheckInput(folder.file(name))) << name;
  }
  test::WriteBytes(folder.file("scan.zip"), "PK");
  EXPECT_NO_THROW(CheckInput(folder.file("scan.zip")));
  test::WriteBytes(folder.file("notes"), "text");
  EXPECT_THAT(test::MessageOf([&] { CheckInput(folder.file("notes")); }), testing::HasSubstr("unknown file type"));
}

/// Returns the CT numbers of a test: different at each point.
double TestHu(const Vec3& p_W) {
  return 500 + 40 * p_W.x - 25 * p_W.y + 10 * p_W.z;
}

TEST(OpenInput, AProjectShowsItsCtAsBefore) {
  const test::Folder folder;
  Bone before = test::MakeSphere({10, 20, 30}, 8, 0.4);
  SetHu(before, TestHu, 0.5);
  before.set_note("import_input", "DICOM");
  // The bone of a session has no CT numbers: the loop does not need them.
  const Bone cut = test::MakeSphere({10, 20, 30}, 7.5, 0.4);
  WriteBone(before, folder.file("before.vdb"));
  WriteBone(cut, folder.file("cut.vdb"));
  Project project;
  project.scene = MakeSceneAround(folder.file("cut.vdb"), cut);
  project.bone_file = folder.file("before.vdb");
  project.cut_bone_file = folder.file("cut.vdb");
  const std::string file = folder.file("a.kerf-project");
  WriteProject(file, project);
  const OpenedInput opened = OpenInput(file, {.bone_file = "", .project_folder = folder.file("out")}, Quiet());
  EXPECT_EQ(opened.bone->CalcHash(), cut.CalcHash());
  ASSERT_TRUE(opened.bone->has_hu());
  EXPECT_EQ(opened.bone->hu_voxel_mm(), 0.5);
  for (const SliceKind kind : {SliceKind::kAxial, SliceKind::kCoronal, SliceKind::kSagittal}) {
    const SliceSpec spec{.kind = kind, .centre_W = {11, 20, 29}, .width_mm = 24};
    const SliceImage then = CalcSlice(before, spec);
    const SliceImage now = CalcSlice(*opened.bone, spec);
    EXPECT_TRUE(now.has_ct);
    EXPECT_EQ(now.image.pixels, then.image.pixels) << ToString(kind);
  }
  // A changed byte of the bone with the CT, which is stored as it is, is found.
  std::string bytes = test::ReadBytes(file);
  const std::string bone = test::ReadBytes(folder.file("before.vdb"));
  const std::size_t at = bytes.find(bone);
  ASSERT_NE(at, std::string::npos);
  bytes[at + bone.size() - 20] ^= 0x10;
  test::WriteBytes(file, bytes);
  const std::string message =
      test::MessageOf([&] { OpenInput(file, {.bone_file = "", .project_folder = folder.file("damaged")}, Quiet()); });
  EXPECT_THAT(message, HasSubstr("a.kerf-project: is damaged: 'bone.vdb'"));
  EXPECT_EQ(message.find('\n'), std::string::npos);
}

TEST(OpenInput, CanBeCancelledAtEachStage) {
  const test::Folder folder;
  WriteBone(test::MakeSphere({10, 20, 30}, 8, 0.4), folder.file("a.vdb"));
  for (const std::string last : {"reading the bone", "placing the saw"}) {
    OpenWatcher watcher;
    watcher.progress = [&](const std::string& stage, double) {
      if (stage == last) throw Cancelled();
    };
    EXPECT_THROW(OpenInput(folder.file("a.vdb"), {}, watcher), Cancelled) << last;
  }
}

Scene MandibleScene(double voxel_mm) {
  const OpenedInput opened = OpenInput("", {}, Quiet());
  Scene scene = opened.scene;
  scene.bone.mandible.voxel_mm = voxel_mm;
  return scene;
}

// A bone of 0.1 mm voxels takes minutes to make.
TEST(LiveSession, ThatIsStoppedWhileItMakesTheBoneIsCancelled) {
  const test::Folder folder;
  LiveOptions options;
  options.record = folder.file("session.kerf");
  bool began = false;
  options.begin = [&](const Bone&, const EffectPlan&) { began = true; };
  LiveSession session(MandibleScene(0.1), options);
  while (session.progress().fraction == 0) std::this_thread::sleep_for(std::chrono::milliseconds(5));
  EXPECT_EQ(session.stage(), LiveStage::kLoading);
  session.Stop();
  while (session.stage() != LiveStage::kEnded) std::this_thread::sleep_for(std::chrono::milliseconds(5));
  EXPECT_TRUE(session.cancelled());
  EXPECT_EQ(session.failure(), "");
  EXPECT_FALSE(began) << "the bone was not completed";
  EXPECT_LT(session.progress().fraction, 1);
  EXPECT_FALSE(fs::exists(options.record));
}

TEST(LiveSession, BeginsWithTheBoneInMemory) {
  const test::Folder folder;
  BlockParams block;
  block.size_mm = {20, 10, 10};
  block.voxel_mm = 0.5;
  block.layers = {{10, 24}};
  auto bone = std::make_shared<const Bone>(MakeBlock(block, test::OneRegionTable()));
  const std::weak_ptr<const Bone> kept = bone;
  const std::uint64_t hash = bone->CalcHash();
  LiveOptions options;
  options.bone = std::move(bone);
  options.seconds = 60;
  std::uint64_t began_with = 0;
  options.begin = [&](const Bone& made, const EffectPlan&) { began_with = made.CalcHash(); };
  Scene scene = MakeSceneAround(folder.file("missing.vdb"), *options.bone);
  LiveSession session(scene, std::move(options));
  while (session.stage() == LiveStage::kLoading) std::this_thread::sleep_for(std::chrono::milliseconds(5));
  EXPECT_EQ(session.failure(), "");
  EXPECT_EQ(began_with, hash);
  EXPECT_TRUE(kept.expired()) << "the session keeps only its own copies";
  session.Stop();
  while (session.stage() != LiveStage::kEnded) std::this_thread::sleep_for(std::chrono::milliseconds(5));
  EXPECT_FALSE(session.cancelled());
  EXPECT_EQ(session.TakeSummary().after.CalcHash(), hash);
}

}  // namespace
}  // namespace kerf
