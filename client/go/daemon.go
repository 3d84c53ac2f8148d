package collided

import (
	"bufio"
	"context"
	"errors"
	"io"
	"os"
	"os/exec"
	"runtime"
	"strings"
	"time"

	"google.golang.org/grpc/codes"
)

const (
	readyPatience   = 60 * time.Second
	compilePatience = 30 * time.Minute // a GPU's driver may have to compile the kernels
	stopPatience    = 10 * time.Second
)

// Daemon is a daemon of one's own, on a Unix socket in a temporary folder. It ends with this process.
type Daemon struct {
	// Address is what to connect to.
	Address string
	// Addresses are all that it listens on, such as 127.0.0.1:40551 for the option --address 127.0.0.1:0.
	Addresses []string

	cmd   *exec.Cmd
	stdin io.Closer
	ended chan struct{} // closed once the process and its folder are gone
}

// FindDaemon tells where the daemon's program is: $COLLIDED_DAEMON, or collided on the PATH. NotFound if there is none.
func FindDaemon() (string, error) {
	if runtime.GOOS != "linux" {
		return "", failf(codes.NotFound, "", "the daemon runs on Linux, and this is %s: run it in a container, in WSL or on a Linux "+
			"host, and connect to its address", runtime.GOOS)
	}
	if named := os.Getenv("COLLIDED_DAEMON"); named != "" {
		if _, err := exec.LookPath(named); err != nil {
			return "", failf(codes.NotFound, "", "COLLIDED_DAEMON is '%s', which is not a program", named)
		}
		return named, nil
	}
	found, err := exec.LookPath("collided")
	if err != nil {
		return "", failf(codes.NotFound, "", "no daemon 'collided' is on the PATH; set COLLIDED_DAEMON, or connect to an address")
	}
	return found, nil
}

// StartDaemon starts a daemon and waits until it is ready. options are those of collided, such as "--threads", "2"; variables
// of the environment, such as COLLIDED_THREADS, are none.
func StartDaemon(ctx context.Context, options ...string) (*Daemon, error) {
	program, err := FindDaemon()
	if err != nil {
		return nil, err
	}
	d := &Daemon{cmd: exec.Command(program, append([]string{"--private"}, options...)...), ended: make(chan struct{})}
	ready, err := d.start()
	if err != nil {
		return nil, failf(codes.Unavailable, "", "the daemon cannot be started: %v", err)
	}
	select {
	case err = <-ready:
	case <-ctx.Done():
		err = contextError(ctx.Err())
	}
	if err != nil {
		d.kill()
		return nil, err
	}
	return d, nil
}

// Stop stops it and removes its folder. Of nil it does nothing.
func (d *Daemon) Stop() {
	if d == nil {
		return
	}
	_ = d.stdin.Close()
	select {
	case <-d.ended:
	case <-time.After(stopPatience):
		d.kill()
	}
}

func (d *Daemon) kill() {
	_ = d.stdin.Close()
	_ = d.cmd.Process.Kill()
	<-d.ended
}

// start returns a channel that tells when the daemon is ready, or why it is not.
func (d *Daemon) start() (<-chan error, error) {
	out, in, err := os.Pipe()
	if err != nil {
		return nil, err
	}
	defer in.Close()
	d.cmd.Stdout, d.cmd.Stderr = in, in
	if d.stdin, err = d.cmd.StdinPipe(); err == nil {
		err = d.cmd.Start()
	}
	if err != nil {
		_ = out.Close()
		return nil, err
	}
	ready := make(chan error, 1)
	go func() {
		defer close(d.ended)
		defer out.Close()
		ready <- d.waitUntilReady(out)
		_ = out.SetReadDeadline(time.Time{})
		_, _ = io.Copy(io.Discard, out)
		_ = d.cmd.Wait()
	}()
	return ready, nil
}

func (d *Daemon) waitUntilReady(out *os.File) error {
	start := time.Now()
	_ = out.SetReadDeadline(start.Add(readyPatience))
	var last, before string // lines
	for log := bufio.NewReader(out); ; {
		line, err := log.ReadString('\n')
		if line = strings.TrimSpace(line); line != "" {
			before, last = last, line
		}
		switch {
		case strings.HasPrefix(line, "ready "):
			d.Addresses = strings.Split(strings.TrimPrefix(line, "ready "), ",")
			d.Address = d.Addresses[0]
			return nil
		case strings.Contains(line, "not expected: ") && strings.Contains(line, "--private"):
			return failf(codes.FailedPrecondition, "", "a private daemon must be of release 0.2.0 or later, and %s is older", d.cmd.Path)
		case errors.Is(err, os.ErrDeadlineExceeded):
			return failf(codes.Unavailable, "", "the daemon was not ready in %v", time.Since(start).Round(time.Second))
		case err != nil:
			return failf(codes.Unavailable, "", "the daemon ended before it was ready: %s",
				strings.TrimPrefix(before+": "+last, ": "))
		case strings.Contains(line, "compiling the kernels"): // which takes longer than any other start
			_ = out.SetReadDeadline(start.Add(compilePatience))
		}
	}
}
