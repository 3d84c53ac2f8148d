#include "client/cpp/transport/features.hpp"

#include <grpcpp/support/status_code_enum.h>

#include <utility>
#include <vector>

#include "client/cpp/error.hpp"

namespace collided::client {

namespace {

using google::protobuf::EnumValueDescriptor;
using google::protobuf::FieldDescriptor;
using google::protobuf::Message;

/// Calls `visit` with the index of each entry of a field, and how a path names it.
template <class Visit>
void for_each_entry(const Message& message, const FieldDescriptor& field, const std::string& at, const Visit& visit) {
  if (!field.is_repeated()) return visit(-1, at);
  for (int i = 0; i < message.GetReflection()->FieldSize(message, &field); ++i)
    visit(i, at + "[" + std::to_string(i) + "]");
}

const Message& message_in(const Message& message, const FieldDescriptor& field, int entry) {
  const auto& reflection = *message.GetReflection();
  return entry < 0 ? reflection.GetMessage(message, &field) : reflection.GetRepeatedMessage(message, &field, entry);
}

int number_in(const Message& message, const FieldDescriptor& field, int entry) {
  const auto& reflection = *message.GetReflection();
  return entry < 0 ? reflection.GetEnumValue(message, &field) : reflection.GetRepeatedEnumValue(message, &field, entry);
}

}  // namespace

Features::Features(const v1::GetServerInfoResponse& info, const std::string& address, v1::Additions additions)
    : daemon_("the daemon at " + address + " is " +
              (info.version().empty() ? "of an unknown version" : info.version())),
      missing_(std::move(additions)) {
  for (const std::string& known : info.features()) missing_.erase(known);
}

void Features::check(const Message& message, const std::string& path) const {
  if (!missing_.empty()) check_fields(message, path);
}

void Features::check_call(const Message& request) const {
  if (missing_.empty()) return;
  const auto& file = *request.GetDescriptor()->file();
  for (int s = 0; s < file.service_count(); ++s)
    for (int i = 0; i < file.service(s)->method_count(); ++i) {
      const auto& method = *file.service(s)->method(i);
      if (method.input_type() == request.GetDescriptor())
        require(std::string(method.full_name()), std::string(method.name()));
    }
  check_fields(request, "");
}

void Features::check_fields(const Message& message, const std::string& path) const {
  std::vector<const FieldDescriptor*> fields;
  message.GetReflection()->ListFields(message, &fields);
  for (const FieldDescriptor* field : fields) {
    const std::string at = (path.empty() ? "" : path + ".") + std::string(field->name());
    require(std::string(field->full_name()), at);
    if (field->cpp_type() == FieldDescriptor::CPPTYPE_MESSAGE)
      for_each_entry(message, *field, at, [&](int entry, const std::string& place) {
        check_fields(message_in(message, *field, entry), place);
      });
    if (field->cpp_type() == FieldDescriptor::CPPTYPE_ENUM)
      for_each_entry(message, *field, at, [&](int entry, const std::string& place) {
        const EnumValueDescriptor* value = field->enum_type()->FindValueByNumber(number_in(message, *field, entry));
        if (value) require(std::string(value->full_name()), place + " = " + std::string(value->name()));
      });
  }
}

void Features::require(const std::string& name, const std::string& what) const {
  const auto found = missing_.find(name);
  if (found == missing_.end()) return;
  throw Error(grpc::UNIMPLEMENTED, what + " needs a daemon of release " + found->second + " or later; " + daemon_,
              what);
}

}  // namespace collided::client
