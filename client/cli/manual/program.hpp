#pragma once
// What a program's options say of themselves, without the headers of CLI11: the one source of man pages and
// completions.

#include <string>
#include <vector>

namespace collided::manual {

/// The words that an option takes, or an argument.
struct Values {
  static constexpr int kAnyNumber = 1 << 29;

  std::string type;                  ///< as --help shows it: "FILE", "INT", for two words "NAME NAME"
  std::vector<std::string> choices;  ///< if these are the only words
  std::string range;                 ///< of numbers, such as "0 to 8"
  int count = 0;                     ///< at most so many words
  bool is_list = false;              ///< one word may be several, with commas between
};

/// An option, or an argument, which has one name without dashes.
struct Option {
  std::vector<std::string> names;  ///< "-h", "--help"
  std::string description;
  Values values;  ///< those of a switch have a type if it takes =TYPE
  std::string group, default_value, variable;
  std::vector<std::string> needs, excludes;  ///< names of other options
  bool is_required = false;
  bool is_repeatable = false;
  bool is_configurable = false;  ///< may come from a configuration file

  /// The long name, if there is one.
  const std::string& name() const { return names.back(); }
};

struct Command {
  std::string name, summary;
  std::string usage;   ///< such as "collidectl detect [OPTIONS] FRAME [FRAME]"
  std::string footer;  ///< paragraphs, and indented examples
  std::vector<Option> arguments, options;
};

/// A part of a man page that options do not tell.
struct Section {
  std::string title;
  std::vector<std::pair<std::string, std::string>> entries;  ///< a term, or none, and a paragraph
};

struct Program {
  Command self;  ///< without a command
  std::vector<Command> commands;
  std::string version, date;  ///< 2026-11-23
  int section = 1;            ///< of the manual
  std::vector<Section> sections;
  std::vector<std::string> see_also;  ///< "collided(8)"
};

}  // namespace collided::manual
