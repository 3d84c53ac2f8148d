#pragma once
// What parse_scene() refuses, and what is told of a scene that it takes.

#include <gtest/gtest.h>

#include <functional>
#include <memory>
#include <string>

#include "server/convert/facts.hpp"
#include "server/errors.hpp"
#include "tests/server/convert/scene_request.hpp"
#include "tests/server/scenes/tiny_scene.hpp"

namespace collided::server {

template <class Error>
void expect_refused(const std::string& field, const std::function<void(pb::CreateSceneRequest&)>& change) {
  auto bad = request();
  change(bad);
  try {
    parse_scene(bad, {});
    ADD_FAILURE() << "accepted: " << field;
  } catch (const Error& e) {
    EXPECT_EQ(e.field(), field) << e.what();
    EXPECT_NE(std::string(e.what()).find(field), std::string::npos) << e.what();
  }
}

/// The facts of a scene without frames.
inline pb::Scene shown(const pb::CreateSceneRequest& wanted) {
  ServedDevices devices(std::vector<DeviceTerms>(1));
  CountingObserver observer;
  const SceneIdentity identity{"id", "token", "", 0, std::make_shared<ClientIdentity>(), 7.5, 1};
  pb::Scene message;
  fill_scene(Scene(identity, parse_scene(wanted, {}).plan, {devices, observer}), &message);
  return message;
}

/// Or "accepted".
inline std::string refusal_of(const pb::CreateSceneRequest& request, const SceneDefaults& defaults = {}) {
  try {
    parse_scene(request, defaults);
  } catch (const InvalidInput& e) {
    return e.what();
  } catch (const LimitExceeded& e) {
    return e.what();
  }
  return "accepted";
}

}  // namespace collided::server
