package test

import (
	"io"
	"net"
	"path/filepath"
	"strings"
	"sync"
	"testing"

	collided "collided.invalid/client/go"
)

// proxy is between a client and a daemon: it cuts connections, keeps requests or answers back, and leads to another daemon.
type proxy struct {
	address string
	stalled sync.Mutex // locked: requests wait
	mutex   sync.Mutex
	path    string
	open    map[net.Conn]bool
	isMute  bool
	refused int // connections, as no daemon was there
}

func newProxy(t *testing.T, to *collided.Daemon) *proxy {
	path := filepath.Join(t.TempDir(), "socket")
	listener, err := net.Listen("unix", path)
	must(t, err)
	p := &proxy{address: "unix:" + path, open: map[net.Conn]bool{}}
	p.leadTo(to)
	go func() {
		for {
			near, err := listener.Accept()
			if err != nil {
				return
			}
			p.join(near)
		}
	}()
	t.Cleanup(func() {
		listener.Close()
		p.cut()
	})
	return p
}

func (p *proxy) leadTo(daemon *collided.Daemon) {
	p.mutex.Lock()
	defer p.mutex.Unlock()
	p.path = strings.TrimPrefix(daemon.Address, "unix:")
}

// cut ends every connection, as if the network had gone.
func (p *proxy) cut() {
	p.mutex.Lock()
	defer p.mutex.Unlock()
	for connection := range p.open {
		connection.Close()
	}
	p.open, p.isMute = map[net.Conn]bool{}, false
}

func (p *proxy) refusals() int {
	p.mutex.Lock()
	defer p.mutex.Unlock()
	return p.refused
}

// mute keeps back what daemons answer until cut.
func (p *proxy) mute() {
	p.mutex.Lock()
	defer p.mutex.Unlock()
	p.isMute = true
}

func (p *proxy) passesRequests() bool {
	p.stalled.Lock()
	defer p.stalled.Unlock()
	return true
}

func (p *proxy) passesAnswers() bool {
	p.mutex.Lock()
	defer p.mutex.Unlock()
	return !p.isMute
}

// gate drops what does not pass.
type gate struct {
	to     net.Conn
	passes func() bool
}

func (g gate) Write(bytes []byte) (int, error) {
	if !g.passes() {
		return len(bytes), nil
	}
	return g.to.Write(bytes)
}

func (p *proxy) join(near net.Conn) {
	p.mutex.Lock()
	defer p.mutex.Unlock()
	far, err := net.Dial("unix", p.path)
	if err != nil {
		p.refused++
		near.Close()
		return
	}
	p.open[near], p.open[far] = true, true
	pipe := func(from net.Conn, to gate) {
		_, _ = io.Copy(to, from)
		from.Close()
		to.to.Close()
	}
	go pipe(near, gate{far, p.passesRequests})
	go pipe(far, gate{near, p.passesAnswers})
}
