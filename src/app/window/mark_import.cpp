#include "app/window/mark_import.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <memory>
#include <utility>

#include "app/window/is_ready.h"
#include "bone/import/image_fields.h"
#include "bone/import/image_header.h"
#include "bone/import/label_image.h"
#include "kerf/error.h"
#include "session/marks/label_marks.h"
#include "session/marks/mark_file.h"
#include "view/ui/translate.h"

namespace kerf {

bool IsCurvesPath(const std::string& path) {
  return EndsWith(Lower(path), ".mrk.json");
}

void MarkImport::AskFile() {
  std::vector<std::string> types{".mrk.json"};
  types.insert(types.end(), kOtherImageExtensions.begin(), kOtherImageExtensions.end());
  types.insert(types.end(), kNiftiExtensions.begin(), kNiftiExtensions.end());
  viewer_.dialogs().ChooseFile(viewer_.ui(), Tr("Marks: curves of 3D Slicer (.mrk.json) or a label map"), ".", types,
                               false, "", [this](const std::string& file) { Read(file); });
}

void MarkImport::Read(const std::string& path) {
  if (is_reading()) return;
  file_ = std::filesystem::path(path).filename().string();
  try {
    if (IsCurvesPath(path)) return Add(ReadMarks(path));
    if (!HasImageExtension(path)) {
      throw Error(fmt::format("{}: unknown file type; marks are read from .mrk.json {}", path, ListImageExtensions()));
    }
  } catch (const Error& e) {
    return Refuse(e.what());
  }
  const std::size_t room = kMaxMarks - std::min(kMaxMarks, document_.marks().size());
  reading_ = std::async(std::launch::async, [path, room] { return ReadLabels(path, room); });
}

MarkImport::Labels MarkImport::ReadLabels(const std::string& path, std::size_t max_marks) {
  const Volume image = ReadLabelImage(path);
  LabelLattice lattice;
  lattice.size = image.size;
  lattice.origin_W = image.origin_W;
  for (int a = 0; a < 3; ++a) lattice.steps_W[static_cast<std::size_t>(a)] = image.spacing_mm[a] * image.axes_W[a];
  lattice.labels = image.hu;
  Labels labels;
  labels.warnings = image.warnings;
  try {
    labels.marks = MakeMarksFromLabels(lattice, MarkKind::kOther, max_marks, &labels.left_out);
  } catch (const Error& e) {
    throw Error(fmt::format("{}: {}", path, e.what()));
  }
  return labels;
}

void MarkImport::Reset() {
  if (is_reading()) discarded_.push_back(std::move(reading_));
}

void MarkImport::Update() {
  std::erase_if(discarded_, [](const std::future<Labels>& work) { return IsReady(work); });
  if (!IsReady(reading_)) return;
  try {
    AskKind(reading_.get());
  } catch (const std::exception& e) {  // also if memory is insufficient
    Refuse(e.what());
  }
}

void MarkImport::AskKind(Labels labels) {
  CheckPlace(labels.marks);
  if (labels.marks.empty()) throw Error(fmt::format("there can be at most {} marks", kMaxMarks));
  const auto nerves = static_cast<std::size_t>(std::count_if(labels.marks.begin(), labels.marks.end(), LooksLikeNerve));
  const std::size_t count = labels.marks.size();
  std::string question = count == 1
                             ? fmt::format(fmt::runtime(Tr("{} contains one structure. What is it?")), file_)
                             : fmt::format(fmt::runtime(Tr("{} contains {} structures. What are they?")), file_, count);
  if (labels.left_out > 0) {
    question += "\n\n";
    question +=
        fmt::format(fmt::runtime(Tr("It contains {} smaller ones too, for which there is no room.")), labels.left_out);
  }
  for (const std::string& warning : labels.warnings) question += fmt::format("\n\n{}", warning);
  const auto marks = std::make_shared<const std::vector<Mark>>(std::move(labels.marks));
  const auto answer = [&](const char* text, MarkKind kind) {
    return Dialogs::Answer{text, [this, marks, kind] {
                             std::vector<Mark> named = *marks;
                             for (std::size_t i = 0; i < named.size(); ++i) {
                               named[i].kind = kind;
                               named[i].name = fmt::format("{} {}", ToString(kind), i + 1);
                             }
                             Add(std::move(named));
                           }};
  };
  std::vector<Dialogs::Answer> answers{answer(Tr("Nerve or canal"), MarkKind::kNerve),
                                       answer(Tr("Tooth or root"), MarkKind::kTooth),
                                       answer(Tr("Another structure"), MarkKind::kOther)};
  // Enter gives the first answer.
  if (count > 1 && nerves < count) std::swap(answers[0], answers[1]);
  answers.push_back({Tr("Cancel"), nullptr});
  viewer_.controls().Release();
  viewer_.dialogs().Ask(question, std::move(answers));
}

void MarkImport::CheckPlace(const std::vector<Mark>& marks) const {
  try {
    CheckMarksNear(marks, bone_W_);
  } catch (const Error& e) {
    throw Error(fmt::format("{}: {}", file_, e.what()));
  }
}

void MarkImport::Add(std::vector<Mark> marks) {
  try {
    CheckPlace(marks);
    const std::size_t count = marks.size();
    PlanContent next = document_.now();
    AppendMarks(next.marks, std::move(marks));
    document_.Change(std::move(next), Tr("marks imported"));
    document_.set_mark_index(document_.marks().size() - 1);
    viewer_.Say(count == 1 ? fmt::format(fmt::runtime(Tr("One mark was imported from {}")), file_)
                           : fmt::format(fmt::runtime(Tr("{} marks were imported from {}")), count, file_));
  } catch (const Error& e) {
    Refuse(e.what());
  }
}

void MarkImport::Refuse(const std::string& why) {
  viewer_.controls().Release();
  viewer_.dialogs().Ask(why, {{Tr("OK"), nullptr}});
  viewer_.trace().Write("marks_refused", {{"why", why}});
}

bool MarkImport::WaitUntil(std::chrono::steady_clock::time_point until) const {
  const auto ends = [&](const std::future<Labels>& work) {
    return work.wait_until(until) == std::future_status::ready;
  };
  return (!reading_.valid() || ends(reading_)) && std::all_of(discarded_.begin(), discarded_.end(), ends);
}

}  // namespace kerf
