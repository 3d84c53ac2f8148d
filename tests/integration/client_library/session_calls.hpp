#pragma once
// Calls of sessions on scenes in CCD, and the errors that they throw.

#include <string>

#include "client/cpp/error.hpp"
#include "tests/integration/client_library/session_scene.hpp"

namespace collided::test {

inline constexpr auto kMode = pb::DETECTION_MODE_CCD;

inline FrameOutput detect(Session& session, uint64_t id) {
  const SessionFrame frame = session_frame(id, kMode);
  return session.detect(frame.updates(), frame.options);
}

/// The error that `call` throws; OK if it throws none.
template <class Call>
client::Error error_of(const Call& call) try {
  call();
  return {0, "nothing was thrown"};
} catch (const client::Error& error) {
  return error;
}

}  // namespace collided::test
