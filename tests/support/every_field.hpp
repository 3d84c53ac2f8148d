#pragma once
// All that an answer can tell of a contact.

#include "gpu/contact_set.hpp"

namespace collided::test {

inline constexpr FieldSet kEveryField = [] {
  FieldSet every;
  for_each_field([&](ContactField field) { every = every.with(field); });
  return every;
}();

}  // namespace collided::test
