#include "client/python/python_message.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <string>

#include <fmt/format.h>
#include <pybind11/numpy.h>

namespace handgraft::python {

namespace py = pybind11;

namespace {

using idl::Json;
using idl::Kind;
using idl::Type;

constexpr const char* kLabelKey = "kind";  // as in idl/json

template <class Number>
py::object numbersOf(const Type& type, void* values) {
  const std::size_t size = type.size(values);
  py::array_t<Number> numbers(static_cast<py::ssize_t>(size));
  if (size > 0) {
    const auto* first = static_cast<const Number*>(type.at(values, 0));
    std::copy(first, first + size, numbers.mutable_data());
  }
  return numbers;
}

/// Text of the wire may be anything; what is no UTF-8 is replaced.
py::object textOf(const std::string& text) {
  PyObject* decoded =
      PyUnicode_DecodeUTF8(text.data(), static_cast<py::ssize_t>(text.size()), "replace");
  if (decoded == nullptr) throw py::error_already_set();
  return py::reinterpret_steal<py::object>(decoded);
}

py::object listOf(const Type& type, void* values) {
  switch (type.element->kind) {
    case Kind::kDouble:
      return numbersOf<double>(type, values);
    case Kind::kFloat:
      return numbersOf<float>(type, values);
    case Kind::kInt32:
      return numbersOf<std::int32_t>(type, values);
    case Kind::kUint32:
      return numbersOf<std::uint32_t>(type, values);
    case Kind::kOctet: {
      const std::size_t size = type.size(values);
      return size == 0 ? py::bytes()
                       : py::bytes(static_cast<const char*>(type.at(values, 0)), size);
    }
    default:
      break;
  }
  py::list list;
  for (std::size_t i = 0; i < type.size(values); ++i)
    list.append(valueOf(*type.element, type.at(values, i)));
  return list;
}

py::object structOf(const Type& type, void* message) {
  py::dict fields;
  for (const idl::Field& field : type.fields)
    fields[field.name] = valueOf(*field.type, field.in(message));
  return fields;
}

py::object unionOf(const Type& type, void* message) {
  py::dict fields;
  const std::uint32_t label = type.label(message);
  fields[kLabelKey] = idl::nameOf(*type.discriminator, label);
  if (const idl::Field* chosen = idl::chosenOf(type, label)) {
    fields[chosen->name] = valueOf(*chosen->type, chosen->in(message));
  }
  return fields;
}

Json numberJson(double value) {
  if (std::isfinite(value)) return value;
  return std::isnan(value) ? "nan" : value > 0.0 ? "inf" : "-inf";
}

Json octetsJson(const std::string& bytes) {
  std::string text;
  for (const char byte : bytes)
    text += fmt::format("{:02x}", static_cast<unsigned char>(byte));
  return text;
}

}  // namespace

py::object valueOf(const Type& type, void* value) {
  switch (type.kind) {
    case Kind::kBoolean:
      return py::bool_(*static_cast<bool*>(value));
    case Kind::kOctet:
      return py::int_(*static_cast<std::uint8_t*>(value));
    case Kind::kInt32:
      return py::int_(*static_cast<std::int32_t*>(value));
    case Kind::kUint32:
      return py::int_(*static_cast<std::uint32_t*>(value));
    case Kind::kInt64:
      return py::int_(*static_cast<std::int64_t*>(value));
    case Kind::kUint64:
      return py::int_(*static_cast<std::uint64_t*>(value));
    case Kind::kFloat:
      return py::float_(*static_cast<float*>(value));
    case Kind::kDouble:
      return py::float_(*static_cast<double*>(value));
    case Kind::kString:
      return textOf(*static_cast<std::string*>(value));
    case Kind::kEnum:
      return py::str(idl::nameOf(type, idl::enumAt(value)));
    case Kind::kStruct:
      return structOf(type, value);
    case Kind::kUnion:
      return unionOf(type, value);
    case Kind::kSequence:
      if (!type.isOptional()) return listOf(type, value);
      return type.size(value) == 0 ? py::none() : valueOf(*type.element, type.at(value, 0));
    case Kind::kArray:
      return listOf(type, value);
  }
  return py::none();
}

Json jsonOf(const py::handle& value) {
  if (value.is_none()) return nullptr;
  if (py::isinstance<py::bool_>(value)) return value.cast<bool>();
  if (py::isinstance<py::str>(value)) return value.cast<std::string>();
  if (py::isinstance<py::bytes>(value)) return octetsJson(value.cast<std::string>());
  if (py::isinstance<py::dict>(value)) {
    Json fields = Json::object();
    for (const auto& [key, field] : py::reinterpret_borrow<py::dict>(value)) {
      fields[py::str(key).cast<std::string>()] = jsonOf(field);
    }
    return fields;
  }
  // An array of numpy says that it may be an index, whatever its length.
  if (PyIndex_Check(value.ptr()) != 0 && !py::hasattr(value, "__len__")) {
    const py::int_ whole = py::reinterpret_steal<py::int_>(PyNumber_Index(value.ptr()));
    if (!whole) throw py::error_already_set();
    int overflow = 0;
    const long long number = PyLong_AsLongLongAndOverflow(whole.ptr(), &overflow);
    if (overflow == 0) return number;
    return py::str(py::object(whole)).cast<std::string>();
  }
  if (py::isinstance<py::float_>(value) || PyNumber_Check(value.ptr()) != 0) {
    if (!py::isinstance<py::iterable>(value) || !py::hasattr(value, "__len__")) {
      return numberJson(value.cast<double>());
    }
  }
  if (py::isinstance<py::iterable>(value)) {
    Json list = Json::array();
    for (const py::handle item : py::reinterpret_borrow<py::iterable>(value))
      list.push_back(jsonOf(item));
    return list;
  }
  throw py::type_error("a message holds dicts, lists, arrays, numbers, text and None, not " +
                       py::str(py::type::of(value)).cast<std::string>());
}

}  // namespace handgraft::python
