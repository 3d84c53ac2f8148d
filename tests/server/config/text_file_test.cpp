// TOML files that the parser would not survive.
#include "server/config/file/text_file.hpp"

#include <gtest/gtest.h>

#include "tests/server/config/parse.hpp"

namespace collided::server {
namespace {

std::string times(int count, const std::string& text) {
  std::string all;
  for (int i = 0; i < count; ++i) all += text;
  return all;
}

TEST(TomlText, BracketsAndDottedKeysAreCounted) {
  for (const auto& [deep, line] : {std::pair{times(17, "["), 1},
                                   {"a = 1\n\nb = " + times(17, "["), 3},
                                   {"a = " + times(17, "{ a = "), 1},
                                   {"a = " + times(17, "\n["), 18},
                                   {times(17, "a.") + "a = 1", 1},
                                   {"\n" + times(17, "\"a\" . ") + "a = 1", 2},
                                   {"a = [" + times(17, "[],") + times(16, "["), 1},
                                   {"a = 'x' # [\n" + times(17, "["), 2},
                                   {"a = \"\\\"\" \n" + times(17, "["), 2},
                                   {"a = \"x\n" + times(17, "["), 2},
                                   {"a = '''\n[''' \n" + times(17, "["), 3}})
    EXPECT_EQ(too_deep_line(deep), line) << deep;
}

TEST(TomlText, WhatOnlyLooksDeepIsNot) {
  const std::string many = times(100, "[");
  for (const auto& flat : {times(16, "[") + times(16, "]"), times(100, "[]\n"), "a = \"" + many + "\"",
                           "a = '" + many + "'", "# " + many, "a = \"\"\"\n" + many + "\n\"\"\"",
                           "a = '''\n" + many + "'''", "a = [" + times(100, "1.5,") + "]", times(100, "a.b = 1.5\n"),
                           "a = \"\\\\\" # " + many, std::string("a = \""), std::string("a = \"\\"), times(100, "]")})
    EXPECT_EQ(too_deep_line(flat), 0) << flat;
}

TEST(TomlText, AConfigurationThatNestsTooDeepIsRefusedWithItsLine) {
  for (const auto& deep : {times(100'000, "["), times(100'000, "a."), "max-scenes = " + times(100'000, "[")}) {
    const TextFile file("max-window = 2\n" + deep);
    const auto path = file.path();
    const auto parsed = parse({"--config", path.c_str()});
    EXPECT_EQ(parsed.exit_code, 2);
    EXPECT_NE(parsed.text.find(path + ":2: nests deeper than 16 levels"), std::string::npos) << parsed.text;
  }
}

TEST(TomlText, DottedKeysBesideEmptyArraysAreFound) {
  for (const auto& [bad, line] : {std::pair<std::string, int>{"a = []\na.b = 1", 2},
                                  {"a.b = 1\nc = 1\na = [ ]", 1},
                                  {"a = [\r\n# none\r\n]\r\na . b = 1", 4},
                                  {"a = []\n\n[a.b]\n", 3},
                                  {"a = []\n  [[a.b]] # x\n", 2},
                                  {"a = []\n\"a\".b = 1", 2},
                                  {"c = {a = [], a.b = 1}", 1},
                                  {"c = [[], {a.b = 1}]", 1}})
    EXPECT_EQ(dotted_line(bad), line) << bad;
  for (const auto& good :
       {"", "a.b = 1", "[a.b]\nc = [1.5]", "a = []\nb = 1.5\nc = [1.5, 2.5]\n[d]\n[[e]]", "a = '[]'\nb.c = 1",
        "a = []\n'a.b' = \"c.d = 1\"\n# a.b = 1", "a = [\n1.5,\n2.5\n]\nb = []"})
    EXPECT_EQ(dotted_line(good), 0) << good;
}

TEST(TomlText, AKeyThroughAnEmptyArrayIsRefusedWithItsLine) {
  const TextFile file("device = []\ndevice.id = 1\n");
  const auto path = file.path();
  const auto parsed = parse({"--config", path.c_str()});
  EXPECT_EQ(parsed.exit_code, 2);
  EXPECT_NE(parsed.text.find(path + ":2: has a key or header with a dot"), std::string::npos) << parsed.text;
}

TEST(TomlText, TextThatIsNotUtf8IsFound) {
  for (const auto& text : {"", "a = 1\n", "a = '\u00e9\u20ac\U0001F600\U0010FFFF'", "\x7f"})
    EXPECT_EQ(not_utf8_line(text), 0) << text;
  for (const auto& bad : {"\x80", "\xff", "\xc3", "\xc3(", "\xe2\x82", "\xf0\x9f\x98", "\xc0\x80", "\xe0\x80\x80",
                          "\xed\xa0\x80", "\xf4\x90\x80\x80", "\xf8\x88\x80\x80\x80"}) {
    EXPECT_EQ(not_utf8_line(bad), 1) << bad;
    EXPECT_EQ(not_utf8_line("a = 1\nb = '" + std::string(bad) + "'\n"), 2) << bad;
  }
}

// The parser reads beyond its text where it tells of such bytes in a literal string.
TEST(TomlText, AConfigurationThatIsNotUtf8IsRefusedWithItsLine) {
  const TextFile file("max-window = 2\nlog-level = '\xff'\n");
  const auto path = file.path();
  const auto parsed = parse({"--config", path.c_str()});
  EXPECT_EQ(parsed.exit_code, 2);
  EXPECT_NE(parsed.text.find(path + ":2: is not UTF-8"), std::string::npos) << parsed.text;
}

}  // namespace
}  // namespace collided::server
