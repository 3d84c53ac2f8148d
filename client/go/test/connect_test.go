package test

import (
	"os"
	"os/exec"
	"path/filepath"
	"strings"
	"testing"
	"time"

	"google.golang.org/grpc/codes"

	collided "collided.invalid/client/go"
)

// certificates makes an authority of its own, with a certificate for localhost and one for a client.
func certificates(t *testing.T) (file func(name string) string) {
	folder := t.TempDir()
	file = func(name string) string { return filepath.Join(folder, name) }
	openssl := func(words string) {
		t.Helper()
		cmd := exec.Command("openssl", strings.Fields(words)...)
		cmd.Dir = folder
		if said, err := cmd.CombinedOutput(); err != nil {
			t.Fatal(string(said))
		}
	}
	const key = "-newkey ec -pkeyopt ec_paramgen_curve:prime256v1 -nodes "
	openssl("req -x509 " + key + "-keyout ca.key -out ca.pem -days 2 -subj /CN=authority")
	must(t, os.WriteFile(file("names"), []byte("subjectAltName=DNS:localhost,DNS:daemon.example"), 0o600))
	for _, name := range []string{"localhost", "me"} {
		openssl("req " + key + "-keyout " + name + ".key -out " + name + ".csr -subj /CN=" + name)
		openssl("x509 -req -in " + name + ".csr -CA ca.pem -CAkey ca.key -CAcreateserial -out " + name + ".pem -days 2 -extfile names")
	}
	return file
}

// served expects a contact over a call and a stream.
func served(t *testing.T, address string, options collided.Options) {
	t.Helper()
	ctx := within(t)
	client, err := collided.Connect(ctx, address, options)
	must(t, err)
	defer client.Close()
	s := fallStream(ctx, t, client)
	same(t, detect(ctx, t, s, fall(0, 2)).VertexTriangle.Count, 1)
}

func TestTLSACertificateAndATokenGetThrough(t *testing.T) {
	file := certificates(t)
	must(t, os.WriteFile(file("tokens"), []byte("[[tokens]]\nname = \"a\"\ntoken = \"token-of-client-a\"\n"), 0o600))
	d := daemon(t, "--address", "127.0.0.1:0", "--tokens-file", file("tokens"), "--tls-certificate", file("localhost.pem"),
		"--tls-key", file("localhost.key"), "--tls-client-ca", file("ca.pem"))
	port := ""
	for _, address := range d.Addresses {
		if !strings.HasPrefix(address, "unix:") {
			port = address[strings.LastIndex(address, ":"):]
		}
	}
	good := collided.Options{TLSCA: file("ca.pem"), TLSCertificate: file("me.pem"), TLSKey: file("me.key"),
		Token: "token-of-client-a", Patience: time.Second}
	served(t, "localhost"+port, good)
	served(t, d.Address, collided.Options{Token: good.Token})
	named := good
	named.TLSServerName = "daemon.example"
	served(t, "127.0.0.1"+port, named)

	ctx := within(t)
	bad := good
	bad.Token = "token-of-client-x"
	_, err := collided.Connect(ctx, "localhost"+port, bad)
	refused(t, err, codes.Unauthenticated, "", ".")
	good.Patience = 300 * time.Millisecond
	_, err = collided.Connect(ctx, "127.0.0.1"+port, good)
	refused(t, err, codes.Unavailable, "", "127.0.0.1")
	anonymous := collided.Options{TLSCA: good.TLSCA, Token: good.Token, Patience: good.Patience}
	_, err = collided.Connect(ctx, "localhost"+port, anonymous)
	refused(t, err, codes.Unavailable, "", ".")
	_, err = collided.Connect(ctx, "localhost"+port, collided.Options{Patience: good.Patience})
	refused(t, err, codes.Unavailable, "", ".")
}

func TestBadOptionsAreRefusedAndATokenIsNotToldToStrangers(t *testing.T) {
	ctx := within(t)
	none := filepath.Join(t.TempDir(), "none")
	cases := []struct {
		address, field string
		options        collided.Options
	}{
		{"localhost:1", "options.deadline", collided.Options{Deadline: -1}},
		{"localhost:1", "options.patience", collided.Options{Patience: -1}},
		{"localhost:1", "options.tls_ca", collided.Options{TLSCA: none}},
		{"localhost:1", "options.tls_ca", collided.Options{TLSServerName: "x"}},
		{"localhost:1", "options.tls_key", collided.Options{TLSKey: "x"}},
		{"localhost:1", "options.token", collided.Options{Token: "a b"}},
		{"example.org:1", "options.token", collided.Options{Token: "secret"}},
		{"ipv4:127.0.0.1:1,10.0.0.1:1", "options.token", collided.Options{Token: "secret"}},
		{"localhost.example.org:1", "options.token", collided.Options{Token: "secret"}},
		{"127.0.0.1.example.org:1", "options.token", collided.Options{Token: "secret"}},
		{"[2001:db8::1]:1", "options.token", collided.Options{Token: "secret"}},
		{"dns:///10.0.0.1:1", "options.token", collided.Options{Token: "secret"}},
	}
	for _, c := range cases {
		_, err := collided.Connect(ctx, c.address, c.options)
		refused(t, err, codes.InvalidArgument, c.field, ".")
	}
	for _, address := range []string{"unix:/none", "[::1]:1", "127.1.2.3:1", "dns:///localhost:1", "localhost:1"} {
		_, err := collided.Connect(ctx, address, collided.Options{Token: "secret", Patience: time.Millisecond})
		refused(t, err, codes.Unavailable, "", ".")
	}
	_, err := collided.Connect(ctx, "unix:"+none, collided.Options{Patience: 100 * time.Millisecond})
	refused(t, err, codes.Unavailable, "", "no daemon answers at unix:.*no such file")
}

func TestTheDaemonIsNamedFoundOrMissed(t *testing.T) {
	program, err := collided.FindDaemon()
	must(t, err)
	folder := t.TempDir()
	must(t, os.WriteFile(filepath.Join(folder, "text"), nil, 0o600))
	t.Setenv("COLLIDED_DAEMON", filepath.Join(folder, "text"))
	_, err = collided.FindDaemon()
	refused(t, err, codes.NotFound, "", "COLLIDED_DAEMON is .*, which is not a program")
	t.Setenv("COLLIDED_DAEMON", "")
	must(t, os.Symlink(program, filepath.Join(folder, "collided")))
	t.Setenv("PATH", folder)
	found, err := collided.FindDaemon()
	must(t, err)
	same(t, found, filepath.Join(folder, "collided"))
	t.Setenv("PATH", t.TempDir())
	_, err = collided.Connect(within(t), "", collided.Options{})
	refused(t, err, codes.NotFound, "", "set COLLIDED_DAEMON")
}

func TestADaemonOfOnesOwnTakesItsOptionsFromItsCallerAlone(t *testing.T) {
	t.Setenv("COLLIDED_LOG_FORMAT", "nonsense")
	daemon(t)
}

func TestADaemonThatIsOlderThanPrivateIsToldOf(t *testing.T) {
	program := filepath.Join(t.TempDir(), "old")
	text := "#!/bin/sh\necho The following argument was not expected: --private >&2; exit 2\n"
	must(t, os.WriteFile(program, []byte(text), 0o700))
	t.Setenv("COLLIDED_DAEMON", program)
	_, err := collided.StartDaemon(within(t))
	refused(t, err, codes.FailedPrecondition, "", "must be of release 0.2.0 or later, and .*old is older")
}

func TestADaemonIsLookedForEveryTwoSeconds(t *testing.T) {
	ctx := within(t)
	d := daemon(t, "--grace-seconds", "0")
	way := newProxy(t, d)
	client, err := collided.Connect(ctx, way.address, collided.Options{})
	must(t, err)
	defer client.Close()
	d.Stop()
	const tries = 7 // gRPC's own pauses would add up to half a minute
	begin := time.Now()
	for way.refusals() < tries {
		_, err = client.GetServerInfo(ctx)
		same(t, collided.IsConnectionLost(err), true)
		time.Sleep(time.Millisecond)
	}
	same(t, time.Since(begin) < 10*time.Second, true)
	way.leadTo(daemon(t))
	for err != nil {
		_, err = client.GetServerInfo(ctx)
	}
}

func TestADaemonOfOnesOwnEndsWithItsClient(t *testing.T) {
	ctx := within(t)
	client, err := collided.Connect(ctx, "", collided.Options{})
	must(t, err)
	fallScene(ctx, t, client)
	client.Close()
	_, err = client.GetServerInfo(ctx)
	refused(t, err, codes.Canceled, "", "closing")
	_, err = collided.StartDaemon(ctx, "--no-such-option")
	refused(t, err, codes.Unavailable, "", "ended before it was ready: .*no-such-option")
}

const childVariable = "COLLIDED_TEST_CHILD"

func TestADaemonOfOnesOwnEndsWithAClientThatIsKilled(t *testing.T) {
	if os.Getenv(childVariable) != "" {
		d, err := collided.StartDaemon(within(t))
		must(t, err)
		os.Stdout.WriteString(d.Address + "\n")
		time.Sleep(time.Hour)
	}
	cmd := exec.Command(os.Args[0], "-test.run", t.Name())
	cmd.Env = append(os.Environ(), childVariable+"=1")
	out, err := cmd.StdoutPipe()
	must(t, err)
	must(t, cmd.Start())
	said := make([]byte, 200)
	count, err := out.Read(said)
	must(t, err)
	address := strings.TrimSpace(string(said[:count]))
	ctx := within(t)
	client, err := collided.Connect(ctx, address, collided.Options{})
	must(t, err)
	defer client.Close()
	must(t, cmd.Process.Kill())
	for err == nil {
		_, err = client.GetServerInfo(ctx)
	}
	same(t, collided.IsConnectionLost(err), true)
	for folder := filepath.Dir(strings.TrimPrefix(address, "unix:")); err == nil || !os.IsNotExist(err); {
		must(t, ctx.Err())
		_, err = os.Stat(folder)
	}
}
