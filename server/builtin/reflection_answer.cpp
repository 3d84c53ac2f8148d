// Answers one request of gRPC's reflection.
#include "server/builtin/reflection_answer.hpp"

#include <google/protobuf/descriptor.h>
#include <google/protobuf/descriptor.pb.h>
#include <grpcpp/support/status.h>

#include <set>

#include "server/shorten.hpp"

namespace collided::server {
namespace {

namespace rpc = grpc::reflection::v1;
using google::protobuf::DescriptorPool;
using google::protobuf::FieldDescriptor;
using google::protobuf::FileDescriptor;

const DescriptorPool& pool() { return *DescriptorPool::generated_pool(); }

void fail(grpc::StatusCode code, const std::string& message, rpc::ServerReflectionResponse& response) {
  response.mutable_error_response()->set_error_code(code);
  response.mutable_error_response()->set_error_message(message);
}

void add_with_dependencies(const FileDescriptor& file, std::set<const FileDescriptor*>& added,
                           rpc::FileDescriptorResponse& files) {
  if (!added.insert(&file).second) return;
  google::protobuf::FileDescriptorProto proto;
  file.CopyTo(&proto);
  proto.SerializeToString(files.add_file_descriptor_proto());
  for (int i = 0; i < file.dependency_count(); ++i) add_with_dependencies(*file.dependency(i), added, files);
}

void add_file(const FileDescriptor* file, const std::string& wanted, rpc::ServerReflectionResponse& response) {
  if (!file) return fail(grpc::StatusCode::NOT_FOUND, shorten(wanted, 256) + " is not known", response);
  std::set<const FileDescriptor*> added;
  add_with_dependencies(*file, added, *response.mutable_file_descriptor_response());
}

const FileDescriptor* file_of_extension(const rpc::ExtensionRequest& wanted) {
  const auto* type = pool().FindMessageTypeByName(wanted.containing_type());
  const FieldDescriptor* field = type ? pool().FindExtensionByNumber(type, wanted.extension_number()) : nullptr;
  return field ? field->file() : nullptr;
}

void add_extension_numbers(const std::string& type_name, rpc::ServerReflectionResponse& response) {
  const auto* type = pool().FindMessageTypeByName(type_name);
  if (!type) return fail(grpc::StatusCode::NOT_FOUND, shorten(type_name, 256) + " is not known", response);
  std::vector<const FieldDescriptor*> extensions;
  pool().FindAllExtensions(type, &extensions);
  auto& numbers = *response.mutable_all_extension_numbers_response();
  numbers.set_base_type_name(type_name);
  for (const auto* extension : extensions) numbers.add_extension_number(extension->number());
}

}  // namespace

rpc::ServerReflectionResponse answer_reflection(const rpc::ServerReflectionRequest& request,
                                                const std::vector<std::string>& services) {
  rpc::ServerReflectionResponse response;
  response.set_valid_host(request.host());
  *response.mutable_original_request() = request;
  switch (request.message_request_case()) {
    case rpc::ServerReflectionRequest::kListServices:
      for (const auto& name : services) response.mutable_list_services_response()->add_service()->set_name(name);
      break;
    case rpc::ServerReflectionRequest::kFileByFilename:
      add_file(pool().FindFileByName(request.file_by_filename()), request.file_by_filename(), response);
      break;
    case rpc::ServerReflectionRequest::kFileContainingSymbol:
      add_file(pool().FindFileContainingSymbol(request.file_containing_symbol()), request.file_containing_symbol(),
               response);
      break;
    case rpc::ServerReflectionRequest::kFileContainingExtension:
      add_file(file_of_extension(request.file_containing_extension()),
               request.file_containing_extension().containing_type(), response);
      break;
    case rpc::ServerReflectionRequest::kAllExtensionNumbersOfType:
      add_extension_numbers(request.all_extension_numbers_of_type(), response);
      break;
    default:
      fail(grpc::StatusCode::INVALID_ARGUMENT, "message_request is not set", response);
  }
  return response;
}

}  // namespace collided::server
