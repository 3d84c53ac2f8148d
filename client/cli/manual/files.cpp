// Man pages and completions, as they are installed.

#include "client/cli/manual/files.hpp"

#include <filesystem>
#include <fstream>
#include <stdexcept>

#include "client/cli/manual/completion.hpp"
#include "client/cli/manual/man_page.hpp"

namespace collided::manual {

void write_file(const std::string& path, const std::string& text) {
  std::error_code error;
  std::filesystem::create_directories(std::filesystem::path(path).parent_path(), error);
  std::ofstream file(path, std::ios::binary);
  file << text;
  file.close();
  if (!file) throw std::runtime_error(path + " cannot be written");
}

void write_files(const Program& program, const std::string& share) {
  const std::string& name = program.self.name;
  const std::string section = std::to_string(program.section);
  const std::string pages = share + "/man/man" + section + "/";
  write_file(pages + name + "." + section, program_page(program));
  for (const Command& command : program.commands)
    write_file(pages + name + "-" + command.name + "." + section, command_page(program, command));
  write_file(share + "/bash-completion/completions/" + name, bash_completion(program));
  write_file(share + "/zsh/site-functions/_" + name, zsh_completion(program));
  write_file(share + "/fish/vendor_completions.d/" + name + ".fish", fish_completion(program));
}

}  // namespace collided::manual
