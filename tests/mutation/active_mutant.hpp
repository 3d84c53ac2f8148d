#pragma once

#include <cstdlib>

// Which of the mutants that a program holds is at work; 0 for none. Included before everything else.
inline const int collided_mutant = [] {
  const char* number = std::getenv("COLLIDED_MUTANT");
  return number ? std::atoi(number) : 0;
}();
