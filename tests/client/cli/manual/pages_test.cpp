// Text of man pages and completions, whatever descriptions hold.

#include <gtest/gtest.h>

#include "client/cli/manual/completion.hpp"
#include "client/cli/manual/footer.hpp"
#include "client/cli/manual/option_text.hpp"
#include "client/cli/manual/roff.hpp"

namespace collided::manual {
namespace {

TEST(Roff, TextIsNeverARequest) {
  EXPECT_EQ(escaped("a-b\\c"), "a\\-b\\ec");
  EXPECT_EQ(paragraph(".so /etc/passwd"), "\\&.so /etc/passwd\n");
  EXPECT_EQ(paragraph("'quoted'"), "\\(aqquoted\\(aq\n");
}

TEST(Roff, OptionsAreBoldAndSentencesEndTheirLines) {
  EXPECT_EQ(paragraph("Needs --find-max, too. More"), "Needs \\fB\\-\\-find\\-max\\fR, too.\nMore\n");
}

TEST(Roff, LinesAreShort) {
  std::string words;
  for (int i = 0; i < 200; ++i) words += "word ";
  std::istringstream lines(paragraph(words));
  for (std::string line; std::getline(lines, line);) EXPECT_LE(line.size(), 80u);
}

TEST(Footer, HasParagraphsExamplesAndExitCodes) {
  const Footer footer = footer_of("One\nparagraph.\n\nAnother.\n\n  program --x\n\nExit codes: 0 done.");
  EXPECT_EQ(footer.paragraphs, (std::vector<std::string>{"One paragraph.", "Another."}));
  EXPECT_EQ(footer.examples, "  program --x\n");
  EXPECT_EQ(footer.exit_codes, "0 done.");
}

TEST(OptionText, TellsAllThatTheOptionTells) {
  const Option option{.names = {"--kinds"},
                      .description = "What to find",
                      .values = {.type = "TEXT", .choices = {"vt", "ee"}, .range = "", .count = 1, .is_list = true},
                      .group = "",
                      .default_value = "vt",
                      .variable = "KINDS",
                      .needs = {"--a", "--b"},
                      .excludes = {"--c"}};
  EXPECT_EQ(option_text(option),
            "What to find. One or more, with commas between, of vt, ee. Default: vt. Needs --a and --b. Not with --c. "
            "Variable: KINDS.");
  EXPECT_EQ(option_tag(option), "\\fB\\-\\-kinds\\fR \\fITEXT\\fR");
}

TEST(AsPhrase, KeepsAbbreviations) {
  EXPECT_EQ(as_phrase("Contacts of a step"), "contacts of a step");
  EXPECT_EQ(as_phrase("OBJ files"), "OBJ files");
}

TEST(Quoted, MarksInsideStayMarks) { EXPECT_EQ(quoted("it's"), "'it'\\''s'"); }

}  // namespace
}  // namespace collided::manual
