package features

import (
	"testing"

	"google.golang.org/protobuf/encoding/prototext"
	"google.golang.org/protobuf/proto"
	"google.golang.org/protobuf/reflect/protodesc"
	"google.golang.org/protobuf/reflect/protoreflect"
	"google.golang.org/protobuf/reflect/protoregistry"
	"google.golang.org/protobuf/types/descriptorpb"
	"google.golang.org/protobuf/types/dynamicpb"

	v1 "collided.invalid/client/go/v1"
)

const (
	release = "99.0.0"
	number  = 99
)

// newer is the protocol of a release that has brought two fields, an enum value and a method.
func newer(t *testing.T) protoreflect.FileDescriptor {
	files := &protoregistry.Files{}
	var copyInto func(file protoreflect.FileDescriptor) protoreflect.FileDescriptor
	copyInto = func(file protoreflect.FileDescriptor) protoreflect.FileDescriptor {
		if known, err := files.FindFileByPath(file.Path()); err == nil {
			return known
		}
		for i := 0; i < file.Imports().Len(); i++ {
			copyInto(file.Imports().Get(i).FileDescriptor)
		}
		changed := protodesc.ToFileDescriptorProto(file)
		gain(changed)
		made, err := protodesc.NewFile(changed, files)
		if err == nil {
			err = files.RegisterFile(made)
		}
		if err != nil {
			t.Fatal(err)
		}
		return made
	}
	return copyInto(v1.File_collided_v1_collision_service_proto)
}

func gain(file *descriptorpb.FileDescriptorProto) {
	for _, message := range file.MessageType {
		name := map[string]string{"SceneSpec": "mirrored", "MeshSpec": "layered"}[message.GetName()]
		if name == "" {
			continue
		}
		options := &descriptorpb.FieldOptions{}
		proto.SetExtension(options, v1.E_FieldAddedIn, release)
		message.Field = append(message.Field, &descriptorpb.FieldDescriptorProto{
			Name: proto.String(name), JsonName: proto.String(name), Number: proto.Int32(number), Options: options,
			Type: descriptorpb.FieldDescriptorProto_TYPE_BOOL.Enum(), Label: descriptorpb.FieldDescriptorProto_LABEL_OPTIONAL.Enum(),
		})
	}
	for _, enum := range file.EnumType {
		if enum.GetName() == "Report" {
			options := &descriptorpb.EnumValueOptions{}
			proto.SetExtension(options, v1.E_ValueAddedIn, release)
			enum.Value = append(enum.Value, &descriptorpb.EnumValueDescriptorProto{
				Name: proto.String("REPORT_DEEPEST"), Number: proto.Int32(number), Options: options})
		}
	}
	for _, service := range file.Service {
		for _, method := range service.Method {
			if method.GetName() == "EstimateScene" {
				method.Options = &descriptorpb.MethodOptions{}
				proto.SetExtension(method.Options, v1.E_MethodAddedIn, release)
			}
		}
	}
}

func TestAClientRefusesWhatAnOlderDaemonWouldIgnore(t *testing.T) {
	protocol := newer(t)
	gained := additionsOf(protocol)
	if len(gained) != len(additions())+4 {
		t.Fatalf("additions are %v", gained)
	}
	for _, c := range []struct{ message, text, known, refused string }{
		{"CreateSceneRequest", "spec { mirrored: true }", "", "spec.mirrored"},
		{"CreateSceneRequest", "spec { meshes {} meshes { layered: true } }", "", "spec.meshes[1].layered"},
		{"CreateSceneRequest", "spec { report: REPORT_DEEPEST }", "", "spec.report = REPORT_DEEPEST"},
		{"EstimateSceneRequest", "", "", "EstimateScene"},
		{"CreateSceneRequest", "spec { meshes { name: 'a' } report: REPORT_ALL kinds: [1, 2] }", "", ""},
		{"CreateSceneRequest", "spec { mirrored: true }", "collided.v1.SceneSpec.mirrored", ""},
		{"EstimateSceneRequest", "", "collided.v1.CollisionService.EstimateScene", ""},
	} {
		request := dynamicpb.NewMessage(protocol.Messages().ByName(protoreflect.Name(c.message)))
		if err := prototext.Unmarshal([]byte(c.text), request); err != nil {
			t.Fatal(err)
		}
		f := of(&v1.GetServerInfoResponse{Version: "0.1.0", Features: []string{c.known}}, "here", gained)
		lack := f.CheckCall(request)
		if c.refused == "" {
			if lack != nil {
				t.Errorf("%s %s: %v", c.message, c.text, lack)
			}
			continue
		}
		want := Lack{c.refused, c.refused + " needs a daemon of release 99.0.0 or later; the daemon at here is 0.1.0"}
		if lack == nil || *lack != want {
			t.Errorf("%s %s: %v", c.message, c.text, lack)
		}
	}
}

func TestAnOptionOfAFrameIsRefused(t *testing.T) {
	lacking := of(&v1.GetServerInfoResponse{Version: "0.1.0"}, "here",
		map[protoreflect.FullName]string{"collided.v1.Frame.trial": release})
	if lack := lacking.Check(&v1.Frame{FrameId: 1}, "frame"); lack != nil {
		t.Error(lack)
	}
	if lack := lacking.Check(&v1.Frame{FrameId: 1, Trial: true}, "frame"); lack == nil || lack.What != "frame.trial" {
		t.Error(lack)
	}
}
