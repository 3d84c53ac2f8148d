package test

import (
	"io"
	"net"
	"path/filepath"
	"strings"
	"sync"
	"testing"

	collided "collided/client/go"
)

// proxy is between a client and a daemon: it cuts connections, and leads to another daemon.
type proxy struct {
	address string
	mutex   sync.Mutex
	path    string
	open    map[net.Conn]bool
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
	p.open = map[net.Conn]bool{}
}

func (p *proxy) join(near net.Conn) {
	p.mutex.Lock()
	defer p.mutex.Unlock()
	far, err := net.Dial("unix", p.path)
	if err != nil {
		near.Close()
		return
	}
	p.open[near], p.open[far] = true, true
	pipe := func(from, to net.Conn) {
		_, _ = io.Copy(to, from)
		from.Close()
		to.Close()
	}
	go pipe(near, far)
	go pipe(far, near)
}
