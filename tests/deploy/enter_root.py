#!/usr/bin/env python3
"""Runs a command in a root, in namespaces that its caller has made: /proc is theirs, the loopback is up.

usage: enter_root.py ROOT COMMAND...
"""

import fcntl
import os
import socket
import struct
import subprocess
import sys

SIOCSIFFLAGS, IFF_UP = 0x8914, 1

root, command = sys.argv[1], sys.argv[2:]
subprocess.run(["mount", "-t", "proc", "proc", f"{root}/proc"], check=True)
with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as any_socket:
    fcntl.ioctl(any_socket, SIOCSIFFLAGS, struct.pack("16sh", b"lo", IFF_UP))
os.chroot(root)
os.chdir("/")
environment = {"PATH": "/usr/sbin:/usr/bin:/sbin:/bin", "HOME": "/root", "LC_ALL": "C.UTF-8", "DEBIAN_FRONTEND": "noninteractive"}
environment |= {name: value for name, value in os.environ.items() if name.lower().endswith("_proxy")}
os.execvpe(command[0], command, environment)
