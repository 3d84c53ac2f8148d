package collided

import (
	"fmt"
	"sync"

	"google.golang.org/grpc/codes"
	"google.golang.org/protobuf/proto"
	"google.golang.org/protobuf/reflect/protoreflect"

	v1 "collided/client/go/v1"
)

// features is what the protocol of this package has gained since release 0.1.0 (added_in.proto) and a daemon lacks, mostly
// nothing: an older daemon would ignore a field, and answer another question.
type features struct {
	daemon  string
	missing map[protoreflect.FullName]string // with the release that brought each
}

func featuresOf(info *v1.GetServerInfoResponse, address string, additions map[protoreflect.FullName]string) *features {
	f := &features{daemon: fmt.Sprintf("the daemon at %s is %s", address, info.GetVersion()), missing: map[protoreflect.FullName]string{}}
	for name, release := range additions {
		f.missing[name] = release
	}
	for _, known := range info.GetFeatures() {
		delete(f.missing, protoreflect.FullName(known))
	}
	return f
}

// check fails with Unimplemented, naming field, release and daemon, if the daemon would ignore something of a message, whose path
// in a request is path.
func (f *features) check(message proto.Message, path string) error {
	if f == nil || len(f.missing) == 0 {
		return nil
	}
	return f.checkFields(message.ProtoReflect(), path)
}

// checkCall is check of a call's request, and of the method that takes it.
func (f *features) checkCall(request proto.Message) error {
	if f == nil || len(f.missing) == 0 {
		return nil
	}
	descriptor := request.ProtoReflect().Descriptor()
	services := descriptor.ParentFile().Services()
	for s := 0; s < services.Len(); s++ {
		for methods, i := services.Get(s).Methods(), 0; i < methods.Len(); i++ {
			method := methods.Get(i)
			if method.Input().FullName() != descriptor.FullName() {
				continue
			}
			if err := f.require(method.FullName(), string(method.Name())); err != nil {
				return err
			}
		}
	}
	return f.check(request, "")
}

func (f *features) checkFields(message protoreflect.Message, path string) (err error) {
	message.Range(func(field protoreflect.FieldDescriptor, value protoreflect.Value) bool {
		at := string(field.Name())
		if path != "" {
			at = path + "." + at
		}
		if err = f.require(field.FullName(), at); err != nil {
			return false
		}
		if !field.IsList() {
			err = f.checkEntry(field, value, at)
			return err == nil
		}
		for i := 0; i < value.List().Len() && err == nil && field.Kind() != protoreflect.BytesKind; i++ {
			err = f.checkEntry(field, value.List().Get(i), fmt.Sprintf("%s[%d]", at, i))
		}
		return err == nil
	})
	return err
}

func (f *features) checkEntry(field protoreflect.FieldDescriptor, value protoreflect.Value, at string) error {
	switch field.Kind() {
	case protoreflect.MessageKind:
		return f.checkFields(value.Message(), at)
	case protoreflect.EnumKind:
		if known := field.Enum().Values().ByNumber(value.Enum()); known != nil {
			return f.require(known.FullName(), at+" = "+string(known.Name()))
		}
	}
	return nil
}

func (f *features) require(name protoreflect.FullName, what string) error {
	if release, isMissing := f.missing[name]; isMissing {
		return failf(codes.Unimplemented, what, "%s needs a daemon of release %s or later; %s", what, release, f.daemon)
	}
	return nil
}

var ownAdditions struct {
	once  sync.Once
	found map[protoreflect.FullName]string
}

// additions are those of this package's own protocol.
func additions() map[protoreflect.FullName]string {
	ownAdditions.once.Do(func() { ownAdditions.found = additionsOf(v1.File_collided_v1_collision_service_proto) })
	return ownAdditions.found
}

// additionsOf are full names of all in a file, and in those that it imports, that names the release which brought it.
func additionsOf(file protoreflect.FileDescriptor) map[protoreflect.FullName]string {
	found, seen := map[protoreflect.FullName]string{}, map[string]bool{}
	addFile(file, found, seen)
	return found
}

func addFile(file protoreflect.FileDescriptor, found map[protoreflect.FullName]string, seen map[string]bool) {
	if seen[file.Path()] {
		return
	}
	seen[file.Path()] = true
	for i := 0; i < file.Imports().Len(); i++ {
		addFile(file.Imports().Get(i).FileDescriptor, found, seen)
	}
	addTypes(file.Messages(), file.Enums(), found)
	for i := 0; i < file.Services().Len(); i++ {
		for methods, m := file.Services().Get(i).Methods(), 0; m < methods.Len(); m++ {
			add(methods.Get(m), v1.E_MethodAddedIn, found)
		}
	}
}

func addTypes(messages protoreflect.MessageDescriptors, enums protoreflect.EnumDescriptors, found map[protoreflect.FullName]string) {
	for i := 0; i < enums.Len(); i++ {
		for values, v := enums.Get(i).Values(), 0; v < values.Len(); v++ {
			add(values.Get(v), v1.E_ValueAddedIn, found)
		}
	}
	for i := 0; i < messages.Len(); i++ {
		message := messages.Get(i)
		for fields, n := message.Fields(), 0; n < fields.Len(); n++ {
			add(fields.Get(n), v1.E_FieldAddedIn, found)
		}
		addTypes(message.Messages(), message.Enums(), found)
	}
}

func add(element protoreflect.Descriptor, option protoreflect.ExtensionType, found map[protoreflect.FullName]string) {
	if release := proto.GetExtension(element.Options(), option).(string); release != "" {
		found[element.FullName()] = release
	}
}
