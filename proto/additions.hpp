#pragma once
// Lists what requests can have that release 0.1.0 does not know.

#include <google/protobuf/descriptor.h>

#include <map>
#include <string>

namespace collided::v1 {

/// Full names of fields, enum values and methods, with the release that brought each (collided/v1/added_in.proto).
using Additions = std::map<std::string, std::string>;

/// Returns the additions of a file and of all files that it imports.
Additions additions_of(const google::protobuf::FileDescriptor& file);

}  // namespace collided::v1
