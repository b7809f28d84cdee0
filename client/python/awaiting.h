#pragma once

#include <utility>

#include <pybind11/pybind11.h>

#include "client/link/pending.h"
#include "client/python/python_message.h"
#include "client/python/unlocked.h"

namespace handgraft::python {

/// Waits without the GIL.
template <class T>
T await(client::Pending<T> pending) {
  const Unlocked unlocked;
  return pending.get();
}

template <class T>
pybind11::object awaitDict(client::Pending<T> pending) {
  return dictOf(await(std::move(pending)));
}

}  // namespace handgraft::python
