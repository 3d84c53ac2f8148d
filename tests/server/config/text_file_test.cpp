// TOML files nested so deeply that parsing them would overflow the stack.
#include "server/config/text_file.hpp"

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
