// Man pages of a program, its commands and its configuration file.

#include "client/cli/manual/man_page.hpp"

#include <algorithm>
#include <cctype>
#include <sstream>

#include "client/cli/manual/footer.hpp"
#include "client/cli/manual/option_text.hpp"
#include "client/cli/manual/roff.hpp"

namespace collided::manual {

namespace {

std::string upper(std::string text) {
  std::transform(text.begin(), text.end(), text.begin(), [](unsigned char c) { return std::toupper(c); });
  return text;
}

std::string page_head(const Program& program, const std::string& name, int section, const std::string& summary) {
  return ".\\\" Made from the options of " + program.self.name + ".\n.TH " + upper(name) + " " +
         std::to_string(section) + " " + program.date + " \"collided " + program.version + "\"\n.nh\n" +
         heading("NAME") + escaped(name) + " \\-\n" + paragraph(as_phrase(summary));
}

/// "collidectl detect [OPTIONS] FRAME", the program's and the command's names in bold.
std::string synopsis(const Command& command) {
  const size_t end = command.usage.find(" [");
  return heading("SYNOPSIS") + bold(command.usage.substr(0, end)) +
         (end >= command.usage.size() ? "" : escaped(command.usage.substr(end))) + "\n";
}

std::string arguments_and_options(const Command& command) {
  std::string text, group;
  if (!command.arguments.empty()) text += heading("ARGUMENTS");
  for (const Option& argument : command.arguments) text += entry(italic(argument.name()), option_text(argument));
  if (!command.options.empty()) text += heading("OPTIONS");
  for (const Option& option : command.options) {
    if (option.group != group) text += subheading(escaped(group = option.group));
    text += entry(option_tag(option), option_text(option));
  }
  return text;
}

std::string footer_text(const Footer& footer) {
  std::string text;
  if (!footer.examples.empty()) text += heading("EXAMPLES") + example(footer.examples);
  if (!footer.exit_codes.empty()) text += heading("\"EXIT STATUS\"") + paragraph(footer.exit_codes);
  return text;
}

std::string description(const std::string& summary, const Footer& footer) {
  std::string text = heading("DESCRIPTION") + paragraph(sentence(summary));
  for (const std::string& part : footer.paragraphs) text += ".PP\n" + paragraph(part);
  return text;
}

std::string commands_text(const Program& program) {
  if (program.commands.empty()) return "";
  std::string text = heading("COMMANDS");
  for (const Command& command : program.commands) text += entry(bold(command.name), sentence(command.summary));
  return text;
}

std::string sections_text(const Program& program) {
  std::string text;
  for (const Section& section : program.sections) {
    text += heading("\"" + section.title + "\"");
    for (const auto& [term, words] : section.entries)
      text += term.empty() ? paragraph(words) : entry(bold(term), words);
  }
  return text;
}

/// "name(1)", the name in bold.
std::string see_also(std::vector<std::string> pages) {
  std::string text = heading("\"SEE ALSO\"");
  for (size_t i = 0; i < pages.size(); ++i) {
    const size_t open = pages[i].find('(');
    text += ".BR " + escaped(pages[i].substr(0, open)) + " " + pages[i].substr(open) +
            (i + 1 < pages.size() ? " ,\n" : "\n");
  }
  return text;
}

std::string page_of(const Program& program, const std::string& name) {
  return name + "(" + std::to_string(program.section) + ")";
}

}  // namespace

std::string program_page(const Program& program) {
  const Footer footer = footer_of(program.self.footer);
  std::vector<std::string> others;
  for (const Command& command : program.commands)
    others.push_back(page_of(program, program.self.name + "-" + command.name));
  others.insert(others.end(), program.see_also.begin(), program.see_also.end());
  return page_head(program, program.self.name, program.section, program.self.summary) + synopsis(program.self) +
         description(program.self.summary, footer) + commands_text(program) + arguments_and_options(program.self) +
         sections_text(program) + footer_text(footer) + see_also(std::move(others));
}

std::string command_page(const Program& program, const Command& command) {
  const std::string name = program.self.name + "-" + command.name;
  Footer footer = footer_of(command.footer);
  if (footer.exit_codes.empty()) footer.exit_codes = footer_of(program.self.footer).exit_codes;
  std::vector<std::string> others{page_of(program, program.self.name)};
  others.insert(others.end(), program.see_also.begin(), program.see_also.end());
  return page_head(program, name, program.section, command.summary) + synopsis(command) +
         description(command.summary, footer) + arguments_and_options(command) + footer_text(footer) +
         see_also(std::move(others));
}

std::string config_page(const Program& program, const ConfigFile& file) {
  std::string text =
      page_head(program, file.name, 5, file.summary) + heading("DESCRIPTION") + paragraph(file.intro) + heading("KEYS");
  std::string group;
  for (const Option& option : program.self.options) {
    if (!option.is_configurable) continue;
    if (option.group != group) text += subheading(escaped(group = option.group));
    text += entry(key_tag(option), option_text(option));
  }
  return text + heading("EXAMPLES") + example(file.example) + see_also({page_of(program, program.self.name)});
}

}  // namespace collided::manual
