// collidectl: collision detection from the command line.

#include <grpc/support/log.h>
#include <poll.h>
#include <signal.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <iostream>

#include "client/app/daemon/interrupt.hpp"
#include "client/app/options/usage.hpp"
#include "client/app/options/usage_error.hpp"
#include "client/app/output/output.hpp"
#include "client/app/report/outcome.hpp"
#include "client/cli/commands.hpp"
#include "deploy/version/version.hpp"

namespace {

int fail(int exit_code, const std::string& what) {
  std::cerr << "collidectl: " << collided::cli::without_controls(what) << std::endl;
  return exit_code;
}

/// Keeps gRPC's log from hiding collidectl's one-line error; GRPC_VERBOSITY brings it back.
void silence_grpc() {
  if (std::getenv("GRPC_VERBOSITY") == nullptr) gpr_set_log_function([](gpr_log_func_args*) {});
}

/// No message if the reader, such as `head`, has closed the pipe.
int fail(const collided::cli::OutputClosed& e) { return e.error_number == EPIPE ? 128 + SIGPIPE : fail(1, e.what()); }

/// Whether nobody reads standard output any more. An earlier write may have found that, whose errno is gone.
bool is_unread() {
  pollfd output{STDOUT_FILENO, 0, 0};
  return poll(&output, 1, 0) > 0 && (output.revents & (POLLERR | POLLHUP)) != 0;
}

/// `exit_code`, unless the output could not be written.
int finish(int exit_code) {
  errno = 0;
  if (std::fflush(stdout) == 0 && std::ferror(stdout) == 0) return exit_code;
  return fail(collided::cli::OutputClosed(is_unread() ? EPIPE : errno));
}

/// Flushes earlier output before the error.
int fail_after_output(int exit_code, const std::string& what) {
  std::fflush(stdout);
  return fail(exit_code, what);
}

#ifndef COLLIDED_RENDER
void add_absent_render(CLI::App& app) {
  auto* const command = app.add_subcommand("render", "Draw steps and their contacts (not in this build)");
  command->allow_extras();
  command->callback([] {
    throw collided::cli::UsageError(
        "this build draws no pictures: it was made without Embree, as the Python wheels are; the "
        "Debian package collided and a build from source have render");
  });
}
#endif

}  // namespace

int main(int argc, char** argv) {
  using namespace collided::cli;
  silence_grpc();
  signal(SIGPIPE, SIG_IGN);  // writing fails instead, so that no daemon and no scene is left behind
  CLI::App app{"Collision detection with a collided daemon, its own or a running one", "collidectl"};
  app.set_version_flag("--version", collided::version_text("collidectl"));
  app.footer("Exit codes: 0 done, 1 failure, 2 bad usage, 128 + n interrupted by signal n.");
  app.require_subcommand(1);
  app.formatter(usage_formatter());
  add_detect(app);
  add_stream(app);
  add_replay(app);
#ifdef COLLIDED_RENDER
  add_render(app);
#else
  add_absent_render(app);
#endif
  add_watch(app);
  add_view(app);
  add_estimate(app);
  add_scenes(app);
  add_export(app);
  add_info(app);
  add_tradeoff(app);
  add_bench(app);
  add_load(app);
  add_batch(app);
  add_merge(app);
  add_completion(app);
  add_manual(app);
  refuse_empty_values(app);
  try {
    app.parse(argc, argv);
    return finish(0);
  } catch (const CLI::Success& asked) {  // --help, --version
    return finish(app.exit(asked));
  } catch (const CLI::Error& e) {
    return fail(2, usage_message(app, e));
  } catch (const UsageError& e) {
    return fail(2, e.what());
  } catch (const OutputClosed& e) {
    return fail(e);
  } catch (const Interrupted& e) {
    return fail_after_output(128 + e.signal_number, e.what());
  } catch (const DoneBut& e) {
    return fail_after_output(3, e.what());
  } catch (const std::exception& e) {
    return fail_after_output(1, e.what());
  }
}
