"""Takes from this process what Linux has and another system lacks, and sets sys.platform, so that the package runs as it would there.

What the standard library, gRPC and numpy need of Linux themselves is imported first: they are not what is tried.
"""

import asyncio
import concurrent.futures.thread  # noqa: F401
import ctypes.util  # noqa: F401
import importlib.abc
import multiprocessing.util  # noqa: F401
import os
import subprocess  # noqa: F401
import sys
import tempfile  # noqa: F401

import google.protobuf.descriptor_pb2  # noqa: F401
import google.protobuf.internal.builder  # noqa: F401
import grpc.aio  # noqa: F401
import numpy  # noqa: F401

# Attributes by module; a name that ends with "_" stands for all that begin with it.
LACKS = {
    "darwin": {
        "fcntl": ["F_ADD_SEALS", "F_GET_SEALS", "F_SEAL_"],
        "os": ["MFD_", "eventfd", "eventfd_read", "eventfd_write", "EFD_", "getresuid", "memfd_create", "pidfd_open", "sched_setaffinity",
               "sched_getaffinity", "splice"],
        "select": ["epoll", "EPOLL"],
        "signal": ["pidfd_send_signal", "sigtimedwait"],
        "socket": ["SCM_CREDENTIALS", "SOCK_CLOEXEC", "SOCK_NONBLOCK", "SOCK_SEQPACKET", "SO_DOMAIN", "SO_PASSCRED", "SO_PEERCRED"],
    },
    "win32": {
        "os": ["EFD_", "MFD_", "O_CLOEXEC", "O_NONBLOCK", "WNOHANG", "eventfd", "fork", "fchmod", "getegid", "geteuid", "getgid", "getpgid",
               "getuid", "killpg", "memfd_create", "mkfifo", "pidfd_open", "register_at_fork", "setsid", "splice", "statvfs", "uname"],
        "select": ["epoll", "poll"],
        "signal": ["SIGHUP", "SIGKILL", "SIGSTOP", "pthread_sigmask"],
        "socket": ["AF_UNIX", "SCM_", "SOCK_CLOEXEC", "SOCK_NONBLOCK", "SOCK_SEQPACKET", "SO_PEERCRED", "recv_fds", "recvmsg", "send_fds",
                   "sendmsg", "socketpair"],
    },
}
NO_MODULES = {"darwin": [], "win32": ["fcntl", "grp", "posix", "pty", "pwd", "resource", "termios"]}


class _Absent(importlib.abc.MetaPathFinder):
    def __init__(self, names):
        self._names = names

    def find_spec(self, name, path=None, target=None):
        if name in self._names:
            raise ModuleNotFoundError(f"No module named {name!r}", name=name)


def pretend(system):
    """Makes this process believe that it runs on `system`. Returns an event loop, which needs what Linux has to be made."""
    loop = asyncio.new_event_loop()
    sys.meta_path.insert(0, _Absent(NO_MODULES[system]))
    for name in NO_MODULES[system]:
        sys.modules.pop(name, None)
    for module, names in LACKS[system].items():
        has = __import__(module)
        for attribute in list(vars(has)):
            if any(attribute == name or (name.endswith("_") and attribute.startswith(name)) for name in names):
                delattr(has, attribute)
    os.process_cpu_count = os.cpu_count  # Python 3.13's own calls sched_getaffinity, where Linux has it
    sys.platform = system  # os.name stays: pathlib chose its classes by it
    return loop
