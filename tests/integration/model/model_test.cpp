// Random sessions of two clients over both transports against one daemon, each answer compared with a sequential model
// (scene_model.hpp). A session that fails is shrunk to a short one. COLLIDED_MODEL_SESSIONS: how many, 500 if not set;
// RC_PARAMS="seed=..." repeats a run.

#include <gtest/gtest.h>
#include <rapidcheck.h>

#include <cstdlib>

#include "tests/integration/model/session.hpp"

namespace collided::test {
namespace {

void set_parameters() {
  const char* sessions = std::getenv("COLLIDED_MODEL_SESSIONS");
  const char* own = std::getenv("RC_PARAMS");
  // The size of a case is the most commands that it has.
  const std::string parameters = std::string("max_size=24 max_success=") + (sessions ? sessions : "500");
  setenv("RC_PARAMS", (parameters + " " + (own ? own : "")).c_str(), 1);
}

TEST(Model, SessionsAreAnsweredAsTheModelSays) {
  set_parameters();
  const TokensFile tokens({{"left"}, {"right"}});
  LocalDaemon daemon({"--tokens-file", tokens.path()});
  std::vector<Client> clients;
  for (const char* name : {"left", "right"})
    clients.push_back(
        {name, pb::CollisionService::NewStub(channel_as(name, daemon.process().address())), daemon.path()});
  std::string first;  // what shrinks to another mismatch, or to none, is told as it was found
  EXPECT_TRUE(rc::check("sessions are answered as the model says",
                        [&] {
                          const Session session = *sessions();
                          try {
                            SessionRunner(clients).run(session);
                          } catch (const Mismatch& mismatch) {
                            if (first.empty()) first = mismatch.what();
                            throw;
                          }
                        }))
      << "the first mismatch: " << first;
}

}  // namespace
}  // namespace collided::test
