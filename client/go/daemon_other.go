//go:build !linux

package collided

import "os/exec"

func endWithParent(*exec.Cmd) {}
