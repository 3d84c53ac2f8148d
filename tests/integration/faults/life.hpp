#pragma once
// A scene and its stream, over gRPC or the local socket, from the connection to the deletion, in stages.

#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "tests/integration/local/local_daemon.hpp"

namespace collided::test {

enum class Transport { kGrpc, kLocal };

/// What the client saw.
struct Outcome {
  std::string code;     ///< "ok", or that of the refusal
  std::string message;  ///< of the refusal
  bool ok() const { return code == "ok"; }
};

class Life {
 public:
  /// `contacts`: of the frames of an undisturbed life, which the first life fills.
  Life(LocalDaemon& daemon, Transport transport, std::map<uint64_t, std::string>& contacts)
      : daemon_(daemon), transport_(transport), contacts_(contacts) {}

  struct Stage {
    const char* name;
    Outcome (Life::*run)();
  };
  /// In order; each may be run again if it was refused.
  static const std::vector<Stage>& stages();

  /// A further frame, which must be answered.
  void check_frame();

 private:
  Outcome connect();
  Outcome create();
  Outcome upload();
  Outcome open();
  Outcome frame();
  Outcome edit();
  Outcome detect();
  Outcome close();
  Outcome remove();

  pb::Frame next_frame() const;
  Outcome ask(const pb::Frame& frame);
  Outcome judge(uint64_t id, const Answer& answer);
  Outcome end_of_stream();
  Outcome answered(const std::vector<pb::ContactChunk>& chunks, uint64_t id);

  LocalDaemon& daemon_;
  const Transport transport_;
  std::map<uint64_t, std::string>& contacts_;
  std::unique_ptr<Stub> stub_;
  pb::Scene scene_;
  std::optional<Stream> remote_;
  std::optional<LocalStream> local_;
  uint64_t done_ = 0;  // the last frame that was answered
};

}  // namespace collided::test
