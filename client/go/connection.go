package collided

import (
	"context"
	"crypto/tls"
	"crypto/x509"
	"net"
	"os"
	"regexp"
	"strings"
	"time"

	"google.golang.org/grpc"
	"google.golang.org/grpc/backoff"
	"google.golang.org/grpc/codes"
	"google.golang.org/grpc/credentials"
	"google.golang.org/grpc/keepalive"
	"google.golang.org/grpc/metadata"
)

// Options tell how a client reaches its daemon. Files are in PEM format. TLS is used if TLSCA is set, else plain text.
type Options struct {
	// Patience is how long to wait for the connection; 0: 5 s.
	Patience time.Duration
	// Deadline is of one call whose context has none; 0: 60 s. Of a stream or a watch it limits the first answer, and the end.
	Deadline time.Duration
	// Token is a bearer token; empty: none is sent.
	Token string
	// TLSCA is the file with the certificates to trust.
	TLSCA string
	// TLSCertificate is the file of the client's own certificate (mTLS); needs TLSKey.
	TLSCertificate string
	// TLSKey is the file of its private key.
	TLSKey string
	// TLSServerName is the name in the daemon's certificate if it is not the address's.
	TLSServerName string
	// AllowInsecureToken sends the token in plain text even to another host.
	AllowInsecureToken bool
}

// connector has checked the options; each connect makes a connection of its own.
type connector struct {
	address string
	options Options
	secure  credentials.TransportCredentials // nil: plain text
}

// A peer that is gone is noticed within 15 s.
var pings = keepalive.ClientParameters{Time: 10 * time.Second, Timeout: 5 * time.Second, PermitWithoutStream: true}

// A daemon that is there again is found within 2 s or so.
var reconnect = grpc.ConnectParams{
	Backoff:           backoff.Config{BaseDelay: 100 * time.Millisecond, Multiplier: 1.6, Jitter: 0.2, MaxDelay: 2 * time.Second},
	MinConnectTimeout: 20 * time.Second,
}

var visible = regexp.MustCompile(`^[!-~]+$`)

func newConnector(address string, options Options) (*connector, error) {
	if options.Patience == 0 {
		options.Patience = 5 * time.Second
	}
	if options.Deadline == 0 {
		options.Deadline = time.Minute
	}
	if err := options.check(address); err != nil {
		return nil, err
	}
	secure, err := options.credentials()
	if err != nil {
		return nil, err
	}
	return &connector{address, options, secure}, nil
}

func (o *Options) check(address string) error {
	switch {
	case address == "":
		return invalidf("address", "is empty; it must be host:port or unix:/path")
	case o.Patience < 0:
		return invalidf("options.patience", "is %v; it must not be negative", o.Patience)
	case o.Deadline < 0:
		return invalidf("options.deadline", "is %v; it must not be negative", o.Deadline)
	case (o.TLSCertificate == "") != (o.TLSKey == ""):
		return invalidf("options.tls_key", "and tls_certificate go together; only one is set")
	case o.TLSCA == "" && o.TLSCertificate+o.TLSServerName != "":
		return invalidf("options.tls_ca", "is not set; tls_certificate and tls_server_name need it")
	case o.Token != "" && !visible.MatchString(o.Token):
		return invalidf("options.token", "has a character that is not visible ASCII")
	}
	return o.checkToken(address)
}

func (o *Options) checkToken(address string) error {
	if o.Token == "" || o.TLSCA != "" || o.AllowInsecureToken || isLocalAddress(address) {
		return nil
	}
	return invalidf("options.token", "is not sent to '%s' in plain text; use TLS (TLSCA) or AllowInsecureToken", address)
}

func (o *Options) credentials() (credentials.TransportCredentials, error) {
	if o.TLSCA == "" {
		return nil, nil
	}
	config := &tls.Config{RootCAs: x509.NewCertPool(), ServerName: o.TLSServerName, MinVersion: tls.VersionTLS12}
	authorities, err := os.ReadFile(o.TLSCA)
	if err != nil || !config.RootCAs.AppendCertsFromPEM(authorities) {
		return nil, invalidf("options.tls_ca", "is '%s', which has no certificates that can be read", o.TLSCA)
	}
	if o.TLSKey != "" {
		pair, err := tls.LoadX509KeyPair(o.TLSCertificate, o.TLSKey)
		if err != nil {
			return nil, invalidf("options.tls_key", "'%s' and tls_certificate '%s' cannot be used: %v", o.TLSKey, o.TLSCertificate, err)
		}
		config.Certificates = []tls.Certificate{pair}
	}
	return credentials.NewTLS(config), nil
}

// connect waits for a connection to address, this connector's if it is empty; Unavailable if no daemon answers in time.
func (c *connector) connect(ctx context.Context, address string) (*grpc.ClientConn, error) {
	if address == "" {
		address = c.address
	}
	if err := c.options.checkToken(address); err != nil {
		return nil, err
	}
	limited, cancel := context.WithTimeout(ctx, c.options.Patience)
	defer cancel()
	target, options := c.dialOptions(address)
	connection, err := grpc.DialContext(limited, target, options...)
	if err == nil {
		return connection, nil
	}
	if ctx.Err() != nil {
		return nil, contextError(ctx.Err())
	}
	return nil, failf(codes.Unavailable, "", "no daemon answers at %s within %v (Options.Patience): %v", address, c.options.Patience, err)
}

func (c *connector) dialOptions(address string) (string, []grpc.DialOption) {
	options := []grpc.DialOption{
		grpc.WithBlock(),
		grpc.WithReturnConnectionError(),
		grpc.WithKeepaliveParams(pings),
		grpc.WithConnectParams(reconnect),
	}
	if c.secure == nil {
		options = append(options, grpc.WithInsecure())
	} else {
		options = append(options, grpc.WithTransportCredentials(c.secure))
	}
	if isLocalAddress(address) {
		options = append(options, grpc.WithNoProxy())
	}
	path, isUnix := unixPath(address)
	if !isUnix {
		return address, options
	}
	// Not every version of gRPC knows unix: itself.
	dial := func(ctx context.Context, _ string) (net.Conn, error) {
		return (&net.Dialer{}).DialContext(ctx, "unix", path)
	}
	return "passthrough:///localhost", append(options, grpc.WithContextDialer(dial), grpc.WithAuthority("localhost"))
}

// callContext has the token, the scene's id, by which proxies find its daemon, and the deadline plus more.
func (c *connector) callContext(ctx context.Context, sceneID string, more time.Duration) (context.Context, context.CancelFunc) {
	ctx = c.streamContext(ctx, sceneID)
	if _, has := ctx.Deadline(); has {
		return context.WithCancel(ctx)
	}
	return context.WithTimeout(ctx, c.options.Deadline+more)
}

// limited is ctx, if it has a deadline; else it ends after that of a call, for several calls that are one to the caller.
func (c *connector) limited(ctx context.Context) (context.Context, context.CancelFunc) {
	if _, has := ctx.Deadline(); has {
		return context.WithCancel(ctx)
	}
	return context.WithTimeout(ctx, c.options.Deadline)
}

// streamContext is callContext without a deadline.
func (c *connector) streamContext(ctx context.Context, sceneID string) context.Context {
	// Not as call credentials, which gRPC refuses on plain-text connections, Unix sockets included.
	if c.options.Token != "" {
		ctx = metadata.AppendToOutgoingContext(ctx, "authorization", "Bearer "+c.options.Token)
	}
	if visible.MatchString(sceneID) {
		ctx = metadata.AppendToOutgoingContext(ctx, "scene-id", sceneID)
	}
	return ctx
}

// unixPath is what the operating system calls the socket of a unix: or unix-abstract: address.
func unixPath(address string) (path string, isUnix bool) {
	if name := strings.TrimPrefix(address, "unix-abstract:"); name != address {
		return "@" + name, true
	}
	path = strings.TrimPrefix(address, "unix:")
	return strings.TrimPrefix(path, "//"), path != address
}

var scheme = regexp.MustCompile(`^(dns|ipv4|ipv6|passthrough):/*`)

// isLocalAddress tells whether a gRPC address is on this host for certain: unix:..., localhost or a loopback IP.
func isLocalAddress(address string) bool {
	if _, isUnix := unixPath(address); isUnix {
		return true
	}
	if strings.Contains(address, ",") { // a list, whose others may be elsewhere
		return false
	}
	host := scheme.ReplaceAllString(address, "")
	if name, _, err := net.SplitHostPort(host); err == nil {
		host = name
	}
	ip := net.ParseIP(host)
	return host == "localhost" || ip != nil && ip.IsLoopback()
}
