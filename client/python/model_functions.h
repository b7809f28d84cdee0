#pragma once

#include <memory>

#include <pybind11/pybind11.h>

#include "client/link/client.h"

namespace handgraft::python {

using ClientClass = pybind11::class_<client::Client, std::shared_ptr<client::Client>>;

/// What a client does with models: lists, describes, sends and drops them.
void defineModels(ClientClass& type);

}  // namespace handgraft::python
