#pragma once

#include <string>
#include <string_view>

#include <nlohmann/json_fwd.hpp>

#include "idl/fields.h"

/// Messages as JSON and back: the one way in which they become text anywhere.
///
/// A struct is an object, its keys in the IDL's order; a union an object with `kind`, the
/// label's name, and the member that it chooses (without it for `Nothing`); an enum its name;
/// an optional value null or the value; octets lower-case hexadecimal; infinities and what is
/// no number "inf",
/// "-inf", "nan"; unsigned numbers above 2^53, which not every reader of JSON keeps, decimal
/// text.
namespace handgraft::idl {

using Json = nlohmann::ordered_json;

Json jsonOf(const Type& type, const void* message);

/// Fills a new message. What is not said stays as the message's class begins: zero, empty.
/// Errors: InvalidField names the path of a field that there is none of, is of another type, is
/// out of range, not finite, too long, or no enumerator.
void readJson(const Type& type, void* message, const Json& json, const std::string& path);

/// For messages of which nothing may be left out but lists: a limit that nobody said is no 0.
/// Errors: InvalidField names the path of the first field that is not said. `json` is one that
/// readJson takes.
void requireWhole(const Type& type, const Json& json, const std::string& path);

/// Errors: InvalidInput for what is no JSON.
void readJsonText(const Type& type, void* message, std::string_view text);

/// `indent` below 0: on one line. Bytes that are no UTF-8 are replaced.
std::string textOf(const Json& json, int indent = -1);
std::string jsonText(const Type& type, const void* message, int indent);

template <class Message>
auto jsonOf(const Message& message) {
  return jsonOf(typeOf<Message>(), &message);
}

template <class Message>
std::string jsonText(const Message& message, int indent = -1) {
  return jsonText(typeOf<Message>(), &message, indent);
}

template <class Message>
Message fromJson(const Json& json, const std::string& path = "") {
  Message message;
  readJson(typeOf<Message>(), &message, json, path);
  return message;
}

template <class Message>
Message fromJsonText(std::string_view text) {
  Message message;
  readJsonText(typeOf<Message>(), &message, text);
  return message;
}

}  // namespace handgraft::idl
