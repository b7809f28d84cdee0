#pragma once

#include <chrono>
#include <thread>
#include <utility>

#include <pybind11/pybind11.h>

#include "client/link/pending.h"
#include "client/python/python_message.h"

namespace handgraft::python {

/// The GIL given away while C++ waits, as pybind11's gil_scoped_release.
///
/// A daemon thread that wants it back while the interpreter ends is stopped for good: CPython
/// (before 3.14) unwinds it as pthread_exit does, which no destructor that may not throw
/// survives (a script that ended beside a thread in `watch` was aborted).
class Unlocked {
 public:
  Unlocked() : state_(PyEval_SaveThread()) {}

  Unlocked(const Unlocked&) = delete;
  Unlocked& operator=(const Unlocked&) = delete;

  ~Unlocked() noexcept(false) {  // NOLINT(bugprone-exception-escape): it must, see above
    while (_Py_IsFinalizing() != 0)
      std::this_thread::sleep_for(std::chrono::seconds(1));
    PyEval_RestoreThread(state_);
  }

 private:
  PyThreadState* state_;
};

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
