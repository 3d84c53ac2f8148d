#pragma once
// Numbers in messages.

#include <sstream>
#include <string>

namespace collided {

/// With all digits that tell it from its neighbours.
template <class T>
std::string text(const T& value) {
  std::ostringstream out;
  out.precision(17);
  out << value;
  return out.str();
}

}  // namespace collided
