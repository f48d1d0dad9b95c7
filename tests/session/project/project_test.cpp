#include "session/project/project.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <zip.h>

#include <algorithm>
#include <filesystem>
#include <glm/geometric.hpp>

#include "bone/models/block.h"
#include "bone/vdb/bonefile.h"
#include "kerf/error.h"
#include "session/project/zip_file.h"
#include "support/folder.h"
#include "support/solids.h"

namespace kerf {
namespace {

using test::Folder;
using test::MessageOf;
using test::ReadBytes;
using test::WriteBytes;
using ::testing::HasSubstr;

const std::string kTable = "id,name,tissue,E_GPa,nu,estimate,source\n24,test,cortical,19.3,0.28,yes,test\n";

/// Returns the text of a scene with one stroke. `bone`: the lines of its bone.
std::string MakeSceneText(const std::string& bone) {
  return "[bone]\n" + bone + R"([[path.stroke]]
start_mm = [0, 0, 20]
end_mm = [0, 0, 19]
feed_mm_per_s = 3
disc_normal = [1, 0, 0]
[force]
law = "hertz_chip"
)";
}

/// A project with everything, in a folder.
struct Case {
  Case() {
    const Bone bone = test::MakeBox({}, {8, 6, 4}, 0.4);
    const Bone cut = test::MakeBox({}, {8, 6, 3}, 0.4);
    WriteBone(bone, folder.file("bone of mine.vdb"));
    WriteBone(cut, folder.file("now.vdb"));
    bone_hash = bone.CalcHash();
    cut_hash = cut.CalcHash();
    WriteBytes(folder.file("regions.csv"), kTable);
    std::string bytes(3'000'000, 'a');
    for (std::size_t i = 0; i < bytes.size(); ++i) bytes[i] = static_cast<char>((i * i) >> 7);
    WriteBytes(folder.file("session.kerf"), bytes);
    std::filesystem::create_directories(folder.file("older"));
    WriteBytes(folder.file("older/session.kerf"), "another recording");
    project.title = "A case \"with\" ä";
    project.scene =
        ParseScene(MakeSceneText("file = \"bone of mine.vdb\"\nmaterials = \"regions.csv\"\n"), folder.file("s.toml"));
    project.scene.plan.planes.push_back(
        {.name = "left", .plane = {{1, 2, 3}, {0, 0.6, 0.8}}, .state = PlaneState::kDone});
    project.bone_file = folder.file("bone of mine.vdb");
    project.cut_bone_file = folder.file("now.vdb");
    project.marks = {{.name = "nerve", .radius_mm = 1.5, .points_W = {{0, 0, 0}, {1, 2, 3}}}};
    project.recordings = {folder.file("session.kerf"), folder.file("older/session.kerf")};
    project.pieces_json = R"({"pieces": [{"name": "piece 1"}, {"name": "piece 2"}]})";
    // A third cannot be written with finitely many digits.
    project.measurements = {{{"piece 1", {1.0 / 3, -2, 0.1}}, {"piece 2", {4, 5, 6}}},
                            {{"piece 2", {0, 0, 0}}, {"piece 2", {1, 0, 0}}, {"piece 1", {0, 1, 0}}}};
    project.views = {{.name = "from the left", .target_W_mm = {1, 2, 3}, .toward_eye_W = {1, 0, 0}, .height_mm = 80}};
    project.settings = {{"theme", "dark"}, {"language", "de"}};
    project.sessions = {{.saw = "-"},
                        {.saw = "fine disc",
                         .duration_s = 61.5,
                         .removed_mm3 = 3,
                         .largest_force_N = 1.25,
                         .forces_sN = {{0, 0}, {0.5, 1.25}}}};
    file = folder.file("case.kerf-project");
  }
  Folder folder;
  Project project;
  std::string file;
  std::uint64_t bone_hash = 0;
  std::uint64_t cut_hash = 0;
};

TEST(Project, ReadsBackTheSame) {
  const Case c;
  WriteProject(c.file, c.project);
  // The originals are not needed any more.
  for (const char* name : {"bone of mine.vdb", "now.vdb", "regions.csv"}) std::filesystem::remove(c.folder.file(name));
  const Project read = ReadProject(c.file, c.folder.file("out"));
  EXPECT_EQ(read.title, c.project.title);
  EXPECT_EQ(read.scene.name, "s");
  EXPECT_EQ(ReadBone(read.bone_file).CalcHash(), c.bone_hash);
  EXPECT_EQ(ReadBone(read.cut_bone_file).CalcHash(), c.cut_hash);
  EXPECT_EQ(read.scene.bone.file, read.cut_bone_file);
  EXPECT_EQ(ReadBytes(read.scene.bone.materials), kTable);
  ASSERT_EQ(read.recordings.size(), 2u);
  EXPECT_EQ(CalcFileDigest(read.recordings[0]).digest, CalcFileDigest(c.project.recordings[0]).digest);
  EXPECT_EQ(ReadBytes(read.recordings[1]), "another recording");
  EXPECT_EQ(read.marks, c.project.marks);
  EXPECT_EQ(read.pieces_json, c.project.pieces_json);
  EXPECT_EQ(read.measurements, c.project.measurements);
  EXPECT_EQ(read.views, c.project.views);
  EXPECT_EQ(read.settings, c.project.settings);
  EXPECT_EQ(read.sessions, c.project.sessions);
  EXPECT_EQ(read.created.size(), std::string("2026-11-25T22:00:00Z").size());
  ASSERT_EQ(read.scene.plan.planes.size(), 1u);
  EXPECT_EQ(read.scene.plan.planes[0].state, PlaneState::kDone);
  // Everything that was unpacked lies in the folder, and the scene is the same but for the names of files.
  for (const std::string& file : {read.bone_file, read.cut_bone_file, read.recordings[0], read.scene.bone.materials}) {
    EXPECT_TRUE(file.starts_with(c.folder.file("out/"))) << file;
  }
  Scene expected = c.project.scene;
  expected.bone.file = read.scene.bone.file;
  expected.bone.materials = read.scene.bone.materials;
  EXPECT_EQ(ResolvedToml(read.scene), ResolvedToml(expected));
  // A project that was read can be written and read again.
  WriteProject(c.folder.file("again.kerf-project"), read);
  const Project again = ReadProject(c.folder.file("again.kerf-project"), c.folder.file("again"));
  EXPECT_EQ(ReadBone(again.bone_file).CalcHash(), c.bone_hash);
  EXPECT_EQ(again.marks, read.marks);
  EXPECT_EQ(again.measurements, read.measurements);
  EXPECT_TRUE(IsProjectPath(c.file));
  EXPECT_FALSE(IsProjectPath("case.kerf"));
}

TEST(Project, SessionsKeepWhereTheHolderWasInTheBone) {
  const std::vector<ProjectSession> sessions{
      {.saw = "disc", .hub_in_bone_W = Vec3{1, -2.5, 3}, .handpiece_in_bone_W = Vec3{4, 5, 6}}, {.saw = "burr"}};
  EXPECT_EQ(ParseSessions(FormatSessions(sessions), "p"), sessions);
}

TEST(Project, InvalidSessionsAreRefused) {
  const auto parse = [](const std::string& text) { return MessageOf([&] { ParseSessions(text, "p"); }); };
  EXPECT_EQ(parse("[]"), "");
  EXPECT_EQ(parse(R"([{"saw": "disc", "duration_s": 1}])"), "");
  EXPECT_THAT(parse("{}"), HasSubstr("p: the sessions are not a list"));
  EXPECT_THAT(parse(R"([{"duration_s": 1}])"), HasSubstr("a session does not name its saw"));
  EXPECT_THAT(parse(R"([{"saw": "disc", "duration_s": -1}])"), HasSubstr("'duration_s' of a session is not a valid"));
  EXPECT_THAT(parse(R"([{"saw": "disc", "largest_force_N": "much"}])"), HasSubstr("'largest_force_N'"));
  EXPECT_THAT(parse(R"([{"saw": "disc", "hub_in_bone_mm": [1, 2]}])"), HasSubstr("'hub_in_bone_mm'"));
  EXPECT_THAT(parse(R"([{"saw": "disc", "handpiece_in_bone_mm": 5}])"), HasSubstr("'handpiece_in_bone_mm'"));
  for (const char* forces : {"5", "[1]", "[[1]]", "[[1, 2, 3]]", "[[2, 1], [1, 1]]", "[[1, -1]]"}) {
    EXPECT_THAT(parse(fmt::format(R"([{{"saw": "disc", "forces_s_N": {}}}])", forces)), HasSubstr("'forces_s_N'"))
        << forces;
  }
  std::string many;
  for (int i = 0; i < 501; ++i) many += (many.empty() ? "" : ",") + std::string(R"({"saw": "disc"})");
  EXPECT_THAT(parse("[" + many + "]"), HasSubstr("at most 500 sessions"));
}

TEST(Project, CanBeAModelWithoutAnythingElse) {
  const Folder folder;
  Project project;
  project.scene = ParseScene(MakeSceneText("model = \"block\"\n"), folder.file("s.toml"));
  WriteProject(folder.file("p.kerf-project"), project);
  const Project read = ReadProject(folder.file("p.kerf-project"), folder.file("out"));
  EXPECT_EQ(ResolvedToml(read.scene), ResolvedToml(project.scene));
  EXPECT_TRUE(read.bone_file.empty() && read.recordings.empty() && read.marks.empty() && read.views.empty());
}

TEST(Project, AFailedWriteKeepsTheOldFile) {
  Case c;
  WriteProject(c.file, c.project);
  const std::string before = ReadBytes(c.file);
  c.project.recordings.push_back(c.folder.file("missing.kerf"));
  EXPECT_THAT(MessageOf([&] { WriteProject(c.file, c.project); }), HasSubstr("missing.kerf: there is no such file"));
  EXPECT_EQ(ReadBytes(c.file), before);
  c.project.recordings.clear();
  c.project.marks.push_back({.name = ""});
  EXPECT_THAT(MessageOf([&] { WriteProject(c.file, c.project); }), HasSubstr("a mark has no name"));
  c.project.marks.clear();
  c.project.measurements.push_back({{"piece 3", {}}, {"piece 1", {}}});
  EXPECT_THAT(MessageOf([&] { WriteProject(c.file, c.project); }), HasSubstr("names 'piece 3', which is not a piece"));
  c.project.measurements.clear();
  EXPECT_THAT(MessageOf([&] { WriteProject(c.folder.file("none/p.kerf-project"), c.project); }), HasSubstr("none"));
  EXPECT_EQ(ReadBytes(c.file), before);
}

TEST(Project, DamageIsFoundWhereverItIs) {
  const Case c;
  WriteProject(c.file, c.project);
  const std::string whole = ReadBytes(c.file);
  const std::string damaged_file = c.folder.file("damaged.kerf-project");
  const auto read = [&](const std::string& bytes) {
    WriteBytes(damaged_file, bytes);
    return MessageOf([&] { ReadProject(damaged_file, c.folder.file("out")); });
  };
  EXPECT_EQ(read(whole), "");
  // Truncated at any place: the directory at the end is missing.
  for (std::size_t size = 0; size < whole.size(); size += whole.size() / 40 + 1) {
    EXPECT_THAT(read(whole.substr(0, size)), HasSubstr("is not a complete ZIP file")) << size;
  }
  EXPECT_THAT(read("not a ZIP file at all"), HasSubstr("damaged.kerf-project: is not a complete ZIP file"));
  // A changed byte anywhere is found, except in fields that say nothing about the content, such as a member's date.
  int found = 0;
  constexpr int kChanges = 60;
  for (int i = 0; i < kChanges; ++i) {
    std::string bytes = whole;
    bytes[bytes.size() * static_cast<std::size_t>(i) / kChanges] ^= 0x10;
    const std::string message = read(bytes);
    if (message.empty()) continue;
    ++found;
    EXPECT_THAT(message, HasSubstr("damaged.kerf-project")) << i;
    EXPECT_EQ(std::count(message.begin(), message.end(), '\n'), 0) << message;
  }
  EXPECT_GE(found, kChanges - 2);
}

/// Returns the bytes of a ZIP file with these members.
std::string MakeZip(const Folder& folder, const std::vector<std::pair<std::string, std::string>>& members) {
  ZipWriter zip;
  for (const auto& [name, text] : members) zip.AddText(name, text);
  WriteBytes(folder.file("made.zip"), "");
  zip.Write(folder.file("made.zip"));
  return folder.file("made.zip");
}

std::string MakeEntry(const std::string& name, const std::string& text) {
  return fmt::format(R"({{"name": "{}", "bytes": {}, "blake2b": "{}"}})", name, text.size(), ToHex(CalcDigest(text)));
}

std::string MakeManifest(const std::string& members, const std::string& recordings = "",
                         const std::string& version = "1") {
  return fmt::format(R"({{"format": "kerf project", "version": {}, "kerf": "0.1.0", "created": "now", "title": "t",
                         "scene_name": "s", "recordings": [{}], "members": [{}]}})",
                     version, recordings, members);
}

TEST(Project, HostileArchivesAreRefused) {
  const Folder folder;
  const std::string scene = "[bone]\nmodel = \"block\"\n";
  const auto read = [&](const std::vector<std::pair<std::string, std::string>>& members) {
    return MessageOf([&] { ReadProject(MakeZip(folder, members), folder.file("out")); });
  };
  const std::string entry = MakeEntry("scene.toml", scene);
  EXPECT_THAT(read({{"scene.toml", scene}}), HasSubstr("it has no manifest"));
  EXPECT_THAT(read({{"manifest.json", "{}"}}), HasSubstr("is not a kerf project"));
  EXPECT_THAT(read({{"manifest.json", MakeManifest("", "", "99")}}),
              HasSubstr("written by a newer kerf (project format 99"));
  EXPECT_THAT(read({{"manifest.json", MakeManifest("", "", "1.5")}}), HasSubstr("no version"));
  EXPECT_THAT(read({{"manifest.json", MakeManifest("")}}), HasSubstr("it has no scene"));
  EXPECT_THAT(read({{"manifest.json", MakeManifest(entry)}}), HasSubstr("is incomplete"));
  EXPECT_THAT(read({{"manifest.json", MakeManifest("")}, {"scene.toml", scene}}),
              HasSubstr("does not list 'scene.toml'"));
  EXPECT_THAT(read({{"manifest.json", MakeManifest(entry + "," + entry)}, {"scene.toml", scene}}), HasSubstr("twice"));
  // Names that lead out of the folder, or that kerf does not use.
  for (const std::string name : {"../evil.toml", "/etc/evil", "recordings/../../evil.kerf", "recordings/.hidden.kerf",
                                 "inputs/a/b", "recordings/a.exe", "evil.txt"}) {
    const std::string message =
        read({{"manifest.json", MakeManifest(entry + "," + MakeEntry(name, "x"))}, {"scene.toml", scene}, {name, "x"}});
    EXPECT_THAT(message, HasSubstr("does not belong into a project")) << name;
  }
  for (const std::string name : {"a b", "back\\slash", "new\nline"}) {
    EXPECT_THAT(read({{"manifest.json", MakeManifest("")}, {name, "x"}}), HasSubstr("has no valid name")) << name;
  }
  // Another content than the manifest states, of the same length.
  EXPECT_THAT(read({{"manifest.json", MakeManifest(entry)}, {"scene.toml", "[bone]\nmodel = \"plate\"\n"}}),
              HasSubstr("'scene.toml' is not as it was written"));
  EXPECT_THAT(read({{"manifest.json", MakeManifest(entry)}, {"scene.toml", scene + " "}}),
              HasSubstr("bytes instead of"));
  EXPECT_THAT(read({{"manifest.json", MakeManifest(entry, "\"recordings/a.kerf\"")}, {"scene.toml", scene}}),
              HasSubstr("the recording 'recordings/a.kerf' is missing"));
  // A bomb: 50 MB of zeros.
  std::string zeros;
  zeros.resize(50'000'000);
  EXPECT_THAT(read({{"manifest.json", MakeManifest(entry + "," + MakeEntry("bone.vdb", zeros))},
                    {"scene.toml", scene},
                    {"bone.vdb", zeros}}),
              HasSubstr("'bone.vdb' would be more than 200 times as large when unpacked"));
  // Many members.
  std::vector<std::pair<std::string, std::string>> many{{"manifest.json", MakeManifest("")}};
  for (int i = 0; i < 2000; ++i) many.emplace_back(fmt::format("inputs/{}", i), "");
  EXPECT_THAT(read(many), HasSubstr("contains 2001 members"));
  // Nothing was written outside.
  EXPECT_FALSE(std::filesystem::exists(folder.file("evil.toml")));
  EXPECT_FALSE(std::filesystem::exists(folder.file("evil.kerf")));
}

TEST(Project, ASceneOutsideTheProjectIsRefused) {
  const Folder folder;
  WriteBytes(folder.file("regions.csv"), kTable);
  const std::string scene =
      MakeSceneText(fmt::format("model = \"block\"\nmaterials = '{}'\n", folder.file("regions.csv")));
  const std::string file =
      MakeZip(folder, {{"manifest.json", MakeManifest(MakeEntry("scene.toml", scene))}, {"scene.toml", scene}});
  EXPECT_THAT(MessageOf([&] { ReadProject(file, folder.file("out")); }), HasSubstr("names a file outside the project"));
}

TEST(Project, AForgedMeasurementIsRefused) {
  const Folder folder;
  const std::string scene = MakeSceneText("model = \"block\"\n");
  const auto read = [&](const std::string& pieces, const std::string& measurements) {
    std::vector<std::pair<std::string, std::string>> members{{"scene.toml", scene},
                                                             {"measurements.json", measurements}};
    if (!pieces.empty()) members.emplace_back("pieces.json", pieces);
    std::string entries;
    for (const auto& [name, text] : members) entries += (entries.empty() ? "" : ",") + MakeEntry(name, text);
    members.emplace_back("manifest.json", MakeManifest(entries, "", "2"));
    return MessageOf([&] { ReadProject(MakeZip(folder, members), folder.file("out")); });
  };
  const std::string one = FormatMeasuredPoints({{{"piece 1", {0, 0, 0}}, {"piece 1", {1, 0, 0}}}});
  EXPECT_EQ(read(R"({"pieces": [{"name": "piece 1"}]})", one), "");
  for (const char* pieces :
       {"", "[]", R"({"pieces": 1})", R"({"pieces": [1, {}, {"name": 1}]})", R"({"pieces": [{"name": "piece 2"}]})"}) {
    EXPECT_THAT(read(pieces, one), HasSubstr("made.zip: a measurement names 'piece 1', which is not a piece"))
        << pieces;
  }
  EXPECT_THAT(read(R"({"pieces": )", one), HasSubstr("made.zip: pieces.json"));
  EXPECT_THAT(read("", "{}"), HasSubstr("made.zip: measurements.json: the measurements are not a list"));
}

TEST(ProjectMeasurements, RefuseFaults) {
  const auto parse = [](const std::string& text) { return MessageOf([&] { ParseMeasuredPoints(text, "p"); }); };
  EXPECT_EQ(parse("[]"), "");
  EXPECT_THAT(parse("{}"), HasSubstr("p: the measurements are not a list"));
  for (const char* entry : {"1", "{}", R"({"points": {}})"}) {
    EXPECT_THAT(parse(fmt::format("[{}]", entry)), HasSubstr("p: a measurement has no list 'points'")) << entry;
  }
  const auto parse_point = [&](const std::string& point) { return parse(R"([{"points": [)" + point + "]}]"); };
  EXPECT_EQ(parse_point(R"({"piece": "a", "position_mm": [1, -2.5, 1e3]})"), "");
  for (const char* point : {"1", "{}", R"({"piece": 1, "position_mm": [1, 2, 3]})"}) {
    EXPECT_THAT(parse_point(point), HasSubstr("p: a point of a measurement does not name its piece")) << point;
  }
  for (const char* position : {"null", "1", "[1, 2]", "[1, 2, 3, 4]", "[1, 2, \"3\"]", "[1, 2, 1e9]"}) {
    EXPECT_THAT(parse_point(fmt::format(R"({{"piece": "a", "position_mm": {}}})", position)),
                HasSubstr("p: 'position_mm' of a measurement is not a list of three valid numbers"))
        << position;
  }
}

TEST(ProjectMeasurements, AreDistancesAndAngles) {
  const auto check = [](const std::vector<MeasuredPoints>& measurements) {
    return MessageOf([&] { CheckMeasuredPoints(measurements, R"({"pieces": [{"name": "a"}]})", "p"); });
  };
  for (const std::size_t points : {0, 1, 2, 3, 4}) {
    const std::string message = check({MeasuredPoints(points, {"a", {1, 2, 3}})});
    const bool valid = points == 2 || points == 3;
    EXPECT_EQ(message, valid ? "" : "p: a measurement has neither 2 points (a distance) nor 3 (an angle)") << points;
  }
  const MeasuredPoints distance(2, {"a", {}});
  EXPECT_EQ(check(std::vector<MeasuredPoints>(1000, distance)), "");
  EXPECT_EQ(check(std::vector<MeasuredPoints>(1001, distance)), "p: a project has at most 1000 measurements");
}

TEST(ProjectViews, RefuseFaults) {
  const std::string valid = FormatViews({{.name = "a"}});
  EXPECT_EQ(ParseViews(valid, "v").size(), 1u);
  const auto with = [&](const std::string& from, const std::string& to) {
    std::string text = valid;
    text.replace(text.find(from), from.size(), to);
    return MessageOf([&] { ParseViews(text, "v"); });
  };
  EXPECT_THAT(with("150.0", "-1"), HasSubstr("height_mm"));
  EXPECT_THAT(with("\"toward_eye\"", "\"other\""), HasSubstr("'toward_eye' of a view"));
  EXPECT_THAT(with("false", "3"), HasSubstr("parallel"));
  EXPECT_THAT(MessageOf([] { ParseViews("{}", "v"); }), HasSubstr("not a list"));
  EXPECT_THAT(MessageOf([] {
                ParseViews(FormatViews({{.name = "a", .up_W = {0, 1, 0}}}), "v");
              }),
              HasSubstr("parallel or zero"));
}

}  // namespace
}  // namespace kerf
