#pragma once

#include <nlohmann/json.hpp>
#include <pybind11/pybind11.h>

#include "idl/fields.h"
#include "idl/json.h"

/// Messages as Python values and back, through the one list of fields (idl/fields.h).
///
/// A struct is a dict; a union a dict with `kind` and the member that it chooses; an enum its
/// name; an optional value None or the value; octets are bytes; numbers in sequences and arrays
/// are a numpy array.
namespace handgraft::python {

pybind11::object valueOf(const idl::Type& type, void* value);

/// Python values as JSON; numpy arrays and whatever iterates are lists.
/// Errors: TypeError for what is none of these.
idl::Json jsonOf(const pybind11::handle& value);

template <class Message>
pybind11::object dictOf(Message message) {
  return valueOf(idl::typeOf<Message>(), &message);
}

/// Errors: InvalidInput that names the path of a field that is wrong.
template <class Message>
Message messageOf(const pybind11::handle& value) {
  return idl::fromJson<Message>(jsonOf(value));
}

}  // namespace handgraft::python
