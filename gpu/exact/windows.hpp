#pragma once
// Times at which a case may hold, from signs that double precision is sure of (rough.hpp). Most cases hold at no time,
// and most forms have their roots where another form says so: exact roots are needed for what is left alone.

#include <utility>
#include <vector>

#include "gpu/exact/contact.hpp"

namespace collided::exact {

class Windows {
 public:
  using Window = std::pair<RoughForm::Place, RoughForm::Place>;

  /// All of (0, 1).
  Windows();
  /// Ascending.
  explicit Windows(std::vector<Window> windows) : windows_(std::move(windows)) {}

  bool are_empty() const { return windows_.empty(); }
  /// Leaves out times at which f is below 0, or is not 0.
  void need_not_negative(const LazyForm& f);
  void need_zero(const LazyForm& f);
  void need(const Case& c);
  /// Leaves out times at which all of the forms are below 0.
  void need_one_not_negative(const std::vector<LazyForm>& forms);
  /// True if f is certain to be above 0 in all that is left.
  bool are_above(const LazyForm& f) const;

 private:
  template <class IsOut>
  void leave_out(const LazyForm& f, const IsOut& is_out);

  std::vector<Window> windows_;  ///< ascending
};

}  // namespace collided::exact
