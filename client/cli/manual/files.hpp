#pragma once
// Man pages and completions, as they are installed.

#include <string>

#include "client/cli/manual/program.hpp"

namespace collided::manual {

/// Writes the program's pages, those of its commands, and its completions under `share`, which is created if
/// necessary: man/man1, bash-completion/completions, zsh/site-functions, fish/vendor_completions.d. Throws
/// std::runtime_error that names the file that cannot be written.
void write_files(const Program& program, const std::string& share);

/// A single one. Throws likewise.
void write_file(const std::string& path, const std::string& text);

}  // namespace collided::manual
