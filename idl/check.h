#pragma once

#include <string>

#include "core/base/error.h"
#include "idl/fields.h"

/// Messages come from strangers, and no vendor checks all that the IDL says of them.
namespace handgraft::idl {

/// A field of a message is wrong. The message begins with its path.
class InvalidField : public InvalidInput {
 public:
  InvalidField(const std::string& path, const std::string& why)
      : InvalidInput(path + ": " + why), path_(path) {}

  /// "body.optimize.options[0].starts"
  [[nodiscard]] const std::string& path() const { return path_; }

 private:
  std::string path_;
};

/// Numbers finite (unless they may be infinite) and in range, sequences within their bounds,
/// enumerators and labels of unions that exist. Errors: InvalidField names the first that is
/// not.
void check(const Type& type, const void* message, const std::string& path);

template <class Message>
void check(const Message& message, const std::string& path = "") {
  check(typeOf<Message>(), &message, path);
}

/// Of one number. Errors: InvalidField.
void checkNumber(double value, const Field& field, const std::string& path);

/// `path.name`, or the name alone.
std::string memberPath(const std::string& path, const char* name);

}  // namespace handgraft::idl
