#pragma once
// The page that collidectl view serves, as client/viewer/build bundles it.

#include <string>

namespace collided::cli {

/// The text of `file`; if it is empty, of the page that was installed with collidectl, or built in its build tree.
/// Throws std::runtime_error saying how to build it.
std::string read_page(const std::string& file);

}  // namespace collided::cli
