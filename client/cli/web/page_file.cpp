// The page that collidectl view serves.

#include "client/cli/web/page_file.hpp"

#include <filesystem>
#include <fstream>
#include <sstream>
#include <stdexcept>

namespace collided::cli {

namespace fs = std::filesystem;

namespace {

fs::path find_page() {
  const fs::path folder = fs::read_symlink("/proc/self/exe").parent_path();
  const fs::path installed = folder / "../share/collided/viewer.html",  // bin/collidectl, installed or in a bundle
      built = folder / "../../../viewer/viewer.html";                   // build/PRESET/client/cli/collidectl
  std::error_code error;
  for (const fs::path& page : {installed, built})
    if (fs::is_regular_file(page, error)) return page;
  throw std::runtime_error(
      "the viewer's page is not built: run client/viewer/build in the sources (it needs Node and "
      "npm), or name the page with --page");
}

}  // namespace

std::string read_page(const std::string& file) {
  const fs::path path = file.empty() ? find_page() : fs::path(file);
  std::ifstream in(path, std::ios::binary);
  std::ostringstream text;
  if (!in || !(text << in.rdbuf())) throw std::runtime_error("--page " + path.string() + ": cannot be read");
  return std::move(text).str();
}

}  // namespace collided::cli
