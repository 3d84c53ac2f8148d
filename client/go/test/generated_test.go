package test

import (
	"os"
	"os/exec"
	"path/filepath"
	"strings"
	"testing"

	"google.golang.org/protobuf/proto"
	"google.golang.org/protobuf/reflect/protodesc"
	"google.golang.org/protobuf/reflect/protoregistry"
	"google.golang.org/protobuf/types/descriptorpb"
)

func TestTheGeneratedCodeIsThatOfTheProtocol(t *testing.T) {
	protoc, err := exec.LookPath("protoc")
	if err != nil {
		t.Skip("protoc is not installed (Debian: protobuf-compiler)")
	}
	set := filepath.Join(t.TempDir(), "set")
	const folder = "../../../proto"
	cmd := exec.Command(protoc, "-I", folder, "-o", set, "--include_imports",
		"collided/v1/collision_service.proto", "collided/v1/error_details.proto")
	if said, err := cmd.CombinedOutput(); err != nil {
		t.Fatal(string(said))
	}
	bytes, err := os.ReadFile(set)
	must(t, err)
	var files descriptorpb.FileDescriptorSet
	must(t, proto.Unmarshal(bytes, &files))
	for _, want := range files.File {
		if !strings.HasPrefix(want.GetName(), "collided/") {
			continue // descriptor.proto, of which the compiler and the library have a version each
		}
		known, err := protoregistry.GlobalFiles.FindFileByPath(want.GetName())
		must(t, err)
		got := protodesc.ToFileDescriptorProto(known)
		got.Options, want.Options = nil, nil // Go's own package
		if !proto.Equal(got, want) {
			t.Errorf("%s has changed: run client/go/generate", want.GetName())
		}
	}
}
