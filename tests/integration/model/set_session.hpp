#pragma once
// Sets of scenes, stepped by DetectBatch.

#include "tests/integration/model/session.hpp"

namespace collided::test {

/// Makes a set of the client's, steps its worlds, some of them with bad positions, and deletes it; each world is as a
/// scene of its own. Throws Mismatch.
void run_set(Numbers& numbers, Client& client);

}  // namespace collided::test
