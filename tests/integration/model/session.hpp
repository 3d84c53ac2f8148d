#pragma once
// Runs sessions against a daemon, and compares each answer with the model's.

#include <stdexcept>

#include "tests/integration/model/choices.hpp"
#include "tests/integration/model/frame_channel.hpp"

namespace collided::test {

/// The daemon answered otherwise than the model.
class Mismatch : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};
inline void require(bool holds, const std::string& what) {
  if (!holds) throw Mismatch(what);
}
inline void require_code(int code, int expected, const std::string& what) {
  require(code == expected, what + ": code " + std::to_string(code) + " instead of " + std::to_string(expected));
}

/// A scene of the daemon's beside its model.
struct LiveScene {
  std::string id, resume_token;
  size_t owner;  ///< of the clients
  pb::DetectionMode mode;
  SceneModel model;
  std::unique_ptr<FrameChannel> stream = nullptr;
};

/// Throws Mismatch where the contacts of an answer are not those of the way.
void check_answer(const SceneModel& model, const ModelFrame& frame, pb::Accuracy accuracy, const Way& way,
                  const std::vector<pb::ContactChunk>& chunks, const pb::FrameDone& done);

class SessionRunner {
 public:
  explicit SessionRunner(std::vector<Client>& clients) : clients_(clients) {}
  ~SessionRunner();
  SessionRunner(const SessionRunner&) = delete;
  SessionRunner& operator=(const SessionRunner&) = delete;

  void run(const Session& session);

 private:
  void run(const Command& command);
  LiveScene& scene_for(Numbers& numbers);
  LiveScene& create(Numbers& numbers, size_t owner);
  void refuse_create(Numbers& numbers, size_t owner);
  void step(Numbers& numbers, LiveScene& scene, const ModelFrame& frame);
  void burst(Numbers& numbers, LiveScene& scene);
  void refuse_frame(Numbers& numbers, LiveScene& scene);
  void open(Numbers& numbers, LiveScene& scene);
  void take_over(Numbers& numbers, LiveScene& scene);
  void break_off(Numbers& numbers, LiveScene& scene);
  void close(LiveScene& scene);
  void remove(LiveScene& scene);
  void look(const LiveScene& scene);
  void intrude(Numbers& numbers, const LiveScene& scene);

  Client& client_of(const LiveScene& scene) { return clients_[scene.owner]; }
  /// The code of the answer, which is in `answer` where it is OK.
  int ask(Numbers& numbers, LiveScene& scene, const pb::Frame& frame, Answer& answer);

  std::vector<Client>& clients_;
  std::vector<std::unique_ptr<LiveScene>> scenes_;
};

}  // namespace collided::test
