package collided

import (
	"os/exec"
	"syscall"
)

// endWithParent makes the kernel stop the process when this one is gone, killed or not.
func endWithParent(cmd *exec.Cmd) { cmd.SysProcAttr = &syscall.SysProcAttr{Pdeathsig: syscall.SIGTERM} }
