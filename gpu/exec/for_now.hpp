#pragma once
// A value that a variable has for a while.

#include <utility>

namespace collided {

/// As long as this lives, also where that ends with a throw.
template <class T>
class ForNow {
 public:
  ForNow(T& variable, T value) : variable_(variable), before_(std::exchange(variable, value)) {}
  ForNow(const ForNow&) = delete;
  ForNow& operator=(const ForNow&) = delete;
  ~ForNow() { variable_ = before_; }

 private:
  T& variable_;
  const T before_;
};

}  // namespace collided
