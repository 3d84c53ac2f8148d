"""An interactive shell, as someone sits in front of it."""

import os
import pty
import select
import signal
import time

PATIENCE = 60  # seconds, until a shell that says nothing more has failed


class Terminal:
    """`with Terminal(words, env) as shell:` runs a shell that believes it has a terminal."""

    def __init__(self, words, env, cwd):
        self.seen = ""
        self.pid, self.fd = pty.fork()
        if self.pid == 0:
            os.chdir(cwd)
            os.execvpe(words[0], words, {**env, "TERM": "dumb", "PS1": "$ ", "HISTFILE": "/dev/null"})

    def __enter__(self):
        return self

    def __exit__(self, *_):
        os.kill(self.pid, signal.SIGKILL)
        os.waitpid(self.pid, 0)
        os.close(self.fd)

    def type(self, text):
        self.seen = ""
        os.write(self.fd, text.encode())

    def wait_for(self, text):
        """Reads until the shell has shown the text."""
        end = time.monotonic() + PATIENCE
        while text not in self.seen:
            ready, _, _ = select.select([self.fd], [], [], max(0, end - time.monotonic()))
            if not ready:
                raise AssertionError(f"the shell does not show {text!r}, but {self.seen!r}")
            self.seen += os.read(self.fd, 65536).decode(errors="replace")
