#include "base/files/catalogue.h"

#include <gtest/gtest.h>

#include <atomic>
#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <map>
#include <string>
#include <thread>

#include "base/files/files.h"
#include "kerf/error.h"
#include "support/folder.h"
#include "view/ui/translate.h"

namespace kerf {
namespace {

/// Returns the bytes of a catalogue, as msgfmt writes them.
std::string MakeMo(const std::map<std::string, std::string>& texts) {
  const auto count = static_cast<std::uint32_t>(texts.size());
  std::string head, table, bytes;
  const auto add = [](std::string& to, std::size_t value) {
    const auto number = static_cast<std::uint32_t>(value);
    to.append(reinterpret_cast<const char*>(&number), sizeof(number));
  };
  for (const std::size_t value : {std::size_t{0x950412de}, std::size_t{0}, std::size_t{count}, std::size_t{28},
                                  std::size_t{28 + 8 * count}, std::size_t{0}, std::size_t{0}}) {
    add(head, value);
  }
  const std::size_t begin = 28 + 16 * count;
  for (const bool translated : {false, true}) {
    for (const auto& [text, translation] : texts) {
      const std::string& one = translated ? translation : text;
      add(table, one.size());
      add(table, begin + bytes.size());
      bytes += one + '\0';
    }
  }
  return head + table + bytes;
}

const std::map<std::string, std::string> kTexts{
    {"", "Content-Type: text/plain; charset=UTF-8\n"},
    {"Undo", "Zurück"},
    {"inside", "innerhalb"},
    {"decimal separator", ","},
    {"the level lies {:.2f} mm {} the edge", "die Schwelle liegt {:.2f} mm {} der Kante"},
    {"the level lies {:.2f} mm {} the edge ({} HU)", "die Schwelle liegt {:.2f} mm {} der Kante ({} HU)"},
    {"{0} of the pieces is {1}", "{1}: Teile {0}"},
    {"{} mm", "{} Millimeter"},
};

class CatalogueFile : public ::testing::Test {
 protected:
  CatalogueFile() { WriteTextFile(file_, MakeMo(kTexts)); }
  test::Folder folder_;
  std::string file_ = folder_.file("kerf.mo");
};

TEST_F(CatalogueFile, TranslatesWholeTexts) {
  const Catalogue catalogue(file_);
  EXPECT_STREQ(catalogue.Find("Undo"), "Zurück");
  EXPECT_EQ(catalogue.Find("Redo"), nullptr);
  EXPECT_EQ(catalogue.Find(""), nullptr) << "the header is no text";
  EXPECT_EQ(catalogue.point(), ",");
  EXPECT_EQ(Catalogue().point(), ".");
  EXPECT_EQ(Catalogue().Translate("Undo"), "Undo");
}

TEST_F(CatalogueFile, RecognisesTextsThatWereMadeWithValues) {
  const Catalogue catalogue(file_);
  EXPECT_EQ(catalogue.Translate("the level lies 0.25 mm inside the edge"),
            "die Schwelle liegt 0,25 mm innerhalb der Kante");
  EXPECT_EQ(catalogue.Translate("the level lies 0.25 mm inside the edge (300 HU)"),
            "die Schwelle liegt 0,25 mm innerhalb der Kante (300 HU)");
  EXPECT_EQ(catalogue.Translate("a.vdb of the pieces is {}"), "{}: Teile a.vdb");
  // A text that was not made by the program stays as it is.
  for (const char* text : {"Left jaw", "3.5 mm", "the level lies", "", "{"}) EXPECT_EQ(catalogue.Translate(text), text);
}

TEST_F(CatalogueFile, RefusesDamagedFiles) {
  const std::string whole = MakeMo(kTexts);
  for (std::size_t size = 0; size < whole.size(); size += 3) {
    WriteTextFile(file_, whole.substr(0, size));
    EXPECT_THROW(Catalogue{file_}, Error) << size;
  }
  for (std::size_t at = 0; at < 28 + 16 * kTexts.size(); ++at) {  // any number may be wrong
    std::string damaged = whole;
    damaged[at] = '\x7f';
    WriteTextFile(file_, damaged);
    try {
      const Catalogue catalogue(file_);
      catalogue.Translate("the level lies 0.25 mm inside the edge");
    } catch (const Error&) {
    }
  }
}

/// Two languages in the user's folder.
class Languages : public ::testing::Test {
 protected:
  Languages() {
    setenv("XDG_DATA_HOME", folder_.path().c_str(), 1);
    for (const std::string code : {"aa", "bb"}) {
      const std::string folder = folder_.path() + "/kerf/locale/" + code + "/LC_MESSAGES";
      std::filesystem::create_directories(folder);
      WriteTextFile(folder + "/kerf.mo", MakeMo({{"", "header"}, {"Undo", "Undo in " + code}}));
    }
  }
  ~Languages() override {
    SetLanguage("en");
    unsetenv("XDG_DATA_HOME");
  }
  test::Folder folder_;
};

// A report that is being written stays in its language while the user changes that of the window.
TEST_F(Languages, OfOneTextDoesNotDependOnThatOfTheWindow) {
  std::atomic<bool> ends{false};
  int wrong = 0;
  std::thread writer([&] {
    while (!ends) wrong += TranslateInto("bb", "Undo") == "Undo in bb" ? 0 : 1;
  });
  int shown_wrong = 0;
  for (int i = 0; i < 300; ++i) {
    SetLanguage(i % 2 == 0 ? "aa" : "en");
    shown_wrong += std::string(Tr("Undo")) == (i % 2 == 0 ? "Undo in aa" : "Undo") ? 0 : 1;
  }
  ends = true;
  writer.join();
  EXPECT_EQ(wrong, 0);
  EXPECT_EQ(shown_wrong, 0);
  EXPECT_EQ(TranslateInto("cc", "Undo"), "Undo");
  SetLanguage("cc");
  EXPECT_EQ(CurrentLanguage(), "en");
}

}  // namespace
}  // namespace kerf
