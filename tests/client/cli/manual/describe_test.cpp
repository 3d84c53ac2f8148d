// A program of CLI11, described.

#include "client/cli/manual/describe.hpp"

#include <gtest/gtest.h>

namespace collided::manual {
namespace {

Option only_option(CLI::App& app) {
  const Program program = describe(app, {{"SCENE", {"funnel", "nbody"}}});
  EXPECT_EQ(program.self.options.size(), 2u);  // --help is the first
  return program.self.options.at(1);
}

TEST(Describe, AnOptionTellsItsTypeRangeAndDefault) {
  CLI::App app("", "program");
  int count = 3;
  app.add_option("-n,--count", count, "How many")->check(CLI::Range(-1, 8))->capture_default_str();
  const Option option = only_option(app);
  EXPECT_EQ(option.names, (std::vector<std::string>{"-n", "--count"}));
  EXPECT_EQ(option.description, "How many");
  EXPECT_EQ(option.values.type, "INT");
  EXPECT_EQ(option.values.range, "-1 to 8");
  EXPECT_EQ(option.values.count, 1);
  EXPECT_EQ(option.default_value, "3");
  EXPECT_FALSE(option.is_repeatable);
}

TEST(Describe, ChoicesAreThoseOfTheCheckOrTheKnownWordsOfTheType) {
  CLI::App checked("", "program"), known("", "program");
  std::string word;
  checked.add_option("--mode", word)->check(CLI::IsMember({"ccd", "dcd"}));
  known.add_option("--scene", word)->type_name("SCENE");
  EXPECT_EQ(only_option(checked).values.choices, (std::vector<std::string>{"ccd", "dcd"}));
  EXPECT_EQ(only_option(known).values.choices, (std::vector<std::string>{"funnel", "nbody"}));
}

TEST(Describe, ListsTakeOneWordAndOtherVectorsAllThatCome) {
  CLI::App list("", "program"), vector("", "program");
  std::vector<std::string> words{"vt", "ee"};
  list.add_option("--kinds", words)->delimiter(',')->allow_extra_args(false)->capture_default_str();
  vector.add_option("--frames", words);
  EXPECT_EQ(only_option(list).values.count, 1);
  EXPECT_TRUE(only_option(list).values.is_list);
  EXPECT_EQ(only_option(list).default_value, "vt,ee");
  EXPECT_EQ(only_option(vector).values.count, Values::kAnyNumber);
}

TEST(Describe, ASwitchTakesNoWord) {
  CLI::App app("", "program");
  bool is_on = false;
  app.add_flag("--json", is_on);
  EXPECT_EQ(only_option(app).values.count, 0);
}

TEST(Describe, GroupsOfOptionsArePartsOfTheCommand) {
  CLI::App app("", "program");
  std::string word;
  app.add_option_group("Log")->add_option("--level", word);
  EXPECT_EQ(only_option(app).group, "Log");
}

TEST(Describe, WhatHasNoGroupIsHidden) {
  CLI::App app("", "program");
  bool is_on = false;
  app.add_flag("--secret", is_on)->group("");
  app.add_subcommand("hidden")->group("");
  app.add_subcommand("shown");
  const Program program = describe(app);
  EXPECT_EQ(program.self.options.size(), 1u);
  ASSERT_EQ(program.commands.size(), 1u);
  EXPECT_EQ(program.commands[0].name, "shown");
}

}  // namespace
}  // namespace collided::manual
