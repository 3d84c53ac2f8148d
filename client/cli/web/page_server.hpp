#pragma once
// Serves the page and what it shows, to any number of browsers up to a limit, on a thread of its own. Nothing waits for
// a browser: each has at most one message on its way, and whatever came meanwhile but the latest is left out.

#include <memory>
#include <string>

#include "client/cli/web/access.hpp"

namespace collided::cli {

class PageServer {
 public:
  /// Listens. `secret` is part of the page's address. Throws std::runtime_error naming --listen.
  PageServer(const ListenAddress& listen, std::string page, std::string secret);
  PageServer(const PageServer&) = delete;
  PageServer& operator=(const PageServer&) = delete;
  /// Ends all connections.
  ~PageServer();

  /// Of the page, with the secret.
  std::string url() const;
  /// Whether other hosts can reach it.
  bool is_public() const;

  // What is shown from now on, also to browsers that come later. From any thread; messages.hpp makes the messages.

  void show_status(std::string message);
  /// Forgets the frame, which belongs to the scene before.
  void show_scene(std::string message);
  void show_frame(std::string message);

 private:
  class State;
  const std::shared_ptr<State> state_;
};

}  // namespace collided::cli
