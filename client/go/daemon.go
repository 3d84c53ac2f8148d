package collided

import (
	"bytes"
	"context"
	"errors"
	"os"
	"os/exec"
	"path/filepath"
	"runtime"
	"strings"
	"time"

	"google.golang.org/grpc/codes"
)

const (
	readyPatience   = 60 * time.Second
	compilePatience = 30 * time.Minute // a GPU's driver may have to compile the kernels
	stopPatience    = 10 * time.Second
	poll            = 5 * time.Millisecond
)

// Its only client may use everything.
var ownLimits = []string{
	"--max-scenes-per-client", "1000000", "--max-streams-per-client", "1000000",
	"--max-device-mb-per-client", "1000000", "--max-frame-seconds", "1000000",
}

// Daemon is a daemon of one's own, on a Unix socket in a temporary folder. On Linux it ends with this process.
type Daemon struct {
	// Address is what to connect to.
	Address string
	// Addresses are all that it listens on, such as 127.0.0.1:40551 for the option --address 127.0.0.1:0.
	Addresses []string

	folder string
	cmd    *exec.Cmd
	ended  chan struct{} // closed once the process is gone
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
	base := os.TempDir()
	if len(base) > 80 {
		base = "/tmp" // the path of a socket has at most 107 bytes
	}
	folder, err := os.MkdirTemp(base, "collided-")
	if err != nil {
		return nil, failf(codes.Internal, "", "there is no room for a daemon: %v", err)
	}
	d := &Daemon{Address: "unix:" + folder + "/socket", folder: folder, ended: make(chan struct{})}
	words := append([]string{"--address", d.Address, "--ready-file", d.file("ready"), "--log-level", "warning"}, ownLimits...)
	d.cmd = exec.Command(program, append(words, options...)...)
	d.cmd.Env = ownEnvironment()
	if err := d.start(ctx); err != nil {
		d.Stop()
		return nil, err
	}
	return d, nil
}

// ownEnvironment is without options of daemons that others start.
func ownEnvironment() []string {
	own := []string{}
	for _, variable := range os.Environ() {
		if !strings.HasPrefix(variable, "COLLIDED_") {
			own = append(own, variable)
		}
	}
	return own
}

// Stop stops it and removes its folder. Of nil it does nothing.
func (d *Daemon) Stop() {
	if d == nil {
		return
	}
	if d.cmd.Process != nil {
		_ = d.cmd.Process.Signal(os.Interrupt)
		select {
		case <-d.ended:
		case <-time.After(stopPatience):
			_ = d.cmd.Process.Kill()
			<-d.ended
		}
	}
	_ = os.RemoveAll(d.folder)
}

func (d *Daemon) file(name string) string { return filepath.Join(d.folder, name) }

func (d *Daemon) start(ctx context.Context) error {
	log, err := os.Create(d.file("log"))
	if err != nil {
		return failf(codes.Internal, "", "there is no room for a daemon: %v", err)
	}
	defer log.Close()
	d.cmd.Stdout, d.cmd.Stderr = log, log
	endWithParent(d.cmd)
	started := make(chan error, 1)
	go d.run(started)
	if err := <-started; err != nil {
		return failf(codes.Unavailable, "", "the daemon cannot be started: %v", err)
	}
	return d.waitUntilReady(ctx)
}

// run keeps its thread, with which the daemon would end, until the daemon has.
func (d *Daemon) run(started chan<- error) {
	runtime.LockOSThread()
	defer runtime.UnlockOSThread()
	err := d.cmd.Start()
	started <- err
	if err == nil {
		_ = d.cmd.Wait()
	}
	close(d.ended)
}

func (d *Daemon) waitUntilReady(ctx context.Context) error {
	start := time.Now()
	for {
		select {
		case <-d.ended:
			return failf(codes.Unavailable, "", "the daemon ended before it was ready%s", d.lastWords())
		case <-ctx.Done():
			return contextError(ctx.Err())
		case <-time.After(poll):
		}
		ready, err := os.ReadFile(d.file("ready"))
		if err != nil && !errors.Is(err, os.ErrNotExist) {
			return failf(codes.Internal, "", "the daemon's file cannot be read: %v", err)
		}
		if len(ready) > 0 {
			d.Addresses = strings.Fields(string(ready))
			return nil
		}
		if took := time.Since(start); took > readyPatience && (took > compilePatience || !d.compiles()) {
			return failf(codes.Unavailable, "", "the daemon was not ready in %v", took.Round(time.Second))
		}
	}
}

// compiles tells whether the daemon has said that kernels are being compiled, which takes longer than any other start.
func (d *Daemon) compiles() bool {
	log, _ := os.ReadFile(d.file("log"))
	return bytes.Contains(log, []byte("compiling the kernels"))
}

func (d *Daemon) lastWords() string {
	log, _ := os.ReadFile(d.file("log"))
	lines := bytes.Split(bytes.TrimSpace(log), []byte("\n"))
	if len(lines) > 2 {
		lines = lines[len(lines)-2:]
	}
	return ": " + string(bytes.Join(lines, []byte(": ")))
}
