#include "proto/additions.hpp"

#include <set>

#include "collided/v1/added_in.pb.h"

namespace collided::v1 {
namespace {

using google::protobuf::Descriptor;
using google::protobuf::EnumDescriptor;
using google::protobuf::FileDescriptor;

class Collector {
 public:
  void add(const FileDescriptor& file) {
    if (!seen_.insert(&file).second) return;
    for (int i = 0; i < file.dependency_count(); ++i) add(*file.dependency(i));
    for (int i = 0; i < file.message_type_count(); ++i) add(*file.message_type(i));
    for (int i = 0; i < file.enum_type_count(); ++i) add(*file.enum_type(i));
    for (int s = 0; s < file.service_count(); ++s)
      for (int i = 0; i < file.service(s)->method_count(); ++i) add(*file.service(s)->method(i), method_added_in);
  }
  Additions take() { return std::move(found_); }

 private:
  void add(const Descriptor& message) {
    for (int i = 0; i < message.field_count(); ++i) add(*message.field(i), field_added_in);
    for (int i = 0; i < message.nested_type_count(); ++i) add(*message.nested_type(i));
    for (int i = 0; i < message.enum_type_count(); ++i) add(*message.enum_type(i));
  }
  void add(const EnumDescriptor& values) {
    for (int i = 0; i < values.value_count(); ++i) add(*values.value(i), value_added_in);
  }
  template <class Element, class Extension>
  void add(const Element& element, const Extension& added_in) {
    if (element.options().HasExtension(added_in))
      found_.emplace(element.full_name(), element.options().GetExtension(added_in));
  }

  std::set<const FileDescriptor*> seen_;
  Additions found_;
};

}  // namespace

Additions additions_of(const FileDescriptor& file) {
  Collector collector;
  collector.add(file);
  return collector.take();
}

}  // namespace collided::v1
