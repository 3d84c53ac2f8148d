// Package features finds what an older daemon does not know: it would ignore a field, and answer another question.
package features

import (
	"fmt"
	"sync"

	"google.golang.org/protobuf/proto"
	"google.golang.org/protobuf/reflect/protoreflect"

	v1 "collided.invalid/client/go/v1"
)

// Lack is something that a request has and the daemon does not know.
type Lack struct {
	// What is the path of a field, with its value where that is an enum's, or the name of a method.
	What string
	// Message names what is missing, the release that brought it, and the daemon.
	Message string
}

// Features holds what the protocol has gained since release 0.1.0 (added_in.proto) and a daemon lacks; usually nothing.
type Features struct {
	daemon  string
	missing map[protoreflect.FullName]string // with the release that brought each
}

// Of compares the protocol's own additions with those that a daemon lists.
func Of(info *v1.GetServerInfoResponse, address string) *Features {
	return of(info, address, additions())
}

func of(info *v1.GetServerInfoResponse, address string, additions map[protoreflect.FullName]string) *Features {
	version := info.GetVersion()
	if version == "" {
		version = "of an unknown version"
	}
	f := &Features{daemon: fmt.Sprintf("the daemon at %s is %s", address, version), missing: map[protoreflect.FullName]string{}}
	for name, release := range additions {
		f.missing[name] = release
	}
	for _, known := range info.GetFeatures() {
		delete(f.missing, protoreflect.FullName(known))
	}
	return f
}

// Check finds what the daemon would ignore of a message, whose path in a request is path; nil: nothing.
func (f *Features) Check(message proto.Message, path string) *Lack {
	if f == nil || len(f.missing) == 0 {
		return nil
	}
	return f.checkFields(message.ProtoReflect(), path)
}

// CheckCall is Check of a call's request, and of the method that takes it.
func (f *Features) CheckCall(request proto.Message) *Lack {
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
			if lack := f.require(method.FullName(), string(method.Name())); lack != nil {
				return lack
			}
		}
	}
	return f.Check(request, "")
}

func (f *Features) checkFields(message protoreflect.Message, path string) (lack *Lack) {
	message.Range(func(field protoreflect.FieldDescriptor, value protoreflect.Value) bool {
		at := string(field.Name())
		if path != "" {
			at = path + "." + at
		}
		if lack = f.require(field.FullName(), at); lack != nil {
			return false
		}
		if !field.IsList() {
			lack = f.checkEntry(field, value, at)
			return lack == nil
		}
		for i := 0; i < value.List().Len() && lack == nil && field.Kind() != protoreflect.BytesKind; i++ {
			lack = f.checkEntry(field, value.List().Get(i), fmt.Sprintf("%s[%d]", at, i))
		}
		return lack == nil
	})
	return lack
}

func (f *Features) checkEntry(field protoreflect.FieldDescriptor, value protoreflect.Value, at string) *Lack {
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

func (f *Features) require(name protoreflect.FullName, what string) *Lack {
	if release, isMissing := f.missing[name]; isMissing {
		return &Lack{what, fmt.Sprintf("%s needs a daemon of release %s or later; %s", what, release, f.daemon)}
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
