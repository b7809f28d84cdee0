/// The Python module's compiled half: the client library, its messages as dicts. The other half
/// (handgraft/__init__.py) makes numpy arrays and names of it.

#include <algorithm>
#include <chrono>
#include <deque>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <variant>

#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include "client/gateway/page_file.h"
#include "client/link/client.h"
#include "client/link/demonstration.h"
#include "client/link/model_files.h"
#include "client/link/pose_file.h"
#include "client/link/session.h"
#include "client/python/awaiting.h"
#include "client/python/model_functions.h"
#include "client/python/page.h"
#include "client/python/python_message.h"
#include "core/base/error.h"

namespace handgraft::python {

namespace py = pybind11;
using py::literals::operator""_a;

namespace {

/// Lets Ctrl-C end a wait: what Python's handler raises goes through it.
void checkSignals() {
  if (_Py_IsFinalizing() != 0) return;  // then nobody gets the GIL any more
  const py::gil_scoped_acquire gil;
  if (PyErr_CheckSignals() != 0) throw py::error_already_set();
}

std::shared_ptr<client::Client> connect(int domain,
                                        const std::string& interface,
                                        bool start,
                                        std::vector<std::string> peers,
                                        const std::string& server,
                                        const std::string& identity) {
  client::ClientOptions options;
  options.network.domain = domain;
  options.network.interface = interface;
  options.network.peers = std::move(peers);
  options.network.server = server;
  options.network.identity = identity;
  options.absence = start ? client::Absence::kStartShared : client::Absence::kFail;
  options.waiting.checkpoint = checkSignals;
  options.on_notice = [](const std::string& /*line*/) {};
  const Unlocked unlocked;
  return std::make_shared<client::Client>(std::move(options));
}

/// A pose's file, as the PriorEdit that has it as prior and start.
py::object poseFile(const std::string& path) {
  const client::PoseFile pose = client::readPose(path);
  v1::PriorEdit edit;
  edit.joints(pose.joints);
  edit.joint_positions(pose.joint_rad);
  if (pose.X_WH) edit.X_WH().push_back(*pose.X_WH);
  return dictOf(edit);
}

/// A live session; keeps its client alive.
class LiveSession {
 public:
  LiveSession(std::shared_ptr<client::Client> client, const v1::SessionState& state)
      : client_(std::move(client)), session_(*client_, state) {}

  client::Session& get() { return session_; }

  client::Client& client() { return *client_; }

  [[nodiscard]] const std::shared_ptr<client::Client>& shared() const { return client_; }

 private:
  std::shared_ptr<client::Client> client_;
  client::Session session_;
};

/// A demonstrator whom a session's hand follows; keeps its client alive.
class Demonstrator {
 public:
  explicit Demonstrator(LiveSession& session)
      : client_(session.shared()), writer_(released(*client_, session.get().id())) {}

  void send(const py::dict& frame) {
    const auto message = messageOf<v1::DemonstratorFrame>(frame);
    const Unlocked unlocked;
    writer_->write(message);
  }

 private:
  static std::unique_ptr<client::DemonstratorWriter> released(client::Client& client,
                                                              std::uint64_t session_id) {
    const Unlocked unlocked;
    return std::make_unique<client::DemonstratorWriter>(client, session_id);
  }

  std::shared_ptr<client::Client> client_;
  std::unique_ptr<client::DemonstratorWriter> writer_;
};

/// The next thing on the streams, ("solution" or "state", dict); nothing within the patience.
class Watch {
 public:
  Watch(std::shared_ptr<client::Client> client, std::uint64_t session_id)
      : client_(std::move(client)), stream_(*client_, session_id) {}

  py::object next(double patience_s) {
    const auto until =
        std::chrono::steady_clock::now() + std::chrono::duration<double>(patience_s);
    {
      const Unlocked unlocked;
      while (events_.empty()) {
        stream_.take(
            [this](const v1::PoseSolution& solution) {
              events_.emplace_back(solution);
            },
            [this](const v1::SessionState& state) {
              // Who comes late is told older states first.
              if (state.revision() >= revision_) events_.emplace_back(state);
              revision_ = std::max(revision_, state.revision());
            });
        if (!events_.empty()) break;
        if (!client_->alive()) {
          throw client::NoServer(fmt::format("handgraft-server on {} stopped answering",
                                             describe(client_->network())));
        }
        client_->checkpoint();
        if (std::chrono::steady_clock::now() >= until) break;
        stream_.wait(std::chrono::milliseconds(20));
      }
    }
    if (events_.empty()) return py::none();
    const Event event = std::move(events_.front());
    events_.pop_front();
    if (const auto* state = std::get_if<v1::SessionState>(&event)) {
      return py::make_tuple("state", dictOf(*state));
    }
    return py::make_tuple("solution", dictOf(std::get<v1::PoseSolution>(event)));
  }

 private:
  using Event = std::variant<v1::PoseSolution, v1::SessionState>;

  std::shared_ptr<client::Client> client_;
  client::SessionStream stream_;
  std::deque<Event> events_;
  std::uint64_t revision_ = 0;
};

v1::RequestBody bodyOf(const py::dict& body) {
  return messageOf<v1::RequestBody>(body);
}

void defineErrors() {
  // Python's own classes, made in handgraft/errors.py, so that they have docstrings and types.
  static const py::object* errors = new py::object(py::module_::import("handgraft.errors"));
  py::register_exception_translator([](std::exception_ptr error) {
    const auto raise = [](const char* name, const char* message, int code = 0) {
      const py::object type = errors->attr(name);
      const py::object raised = type(message);
      if (code != 0) {
        raised.attr("code") =
            idl::nameOf(idl::typeOf<v1::ErrorCode>(), static_cast<std::uint32_t>(code));
      }
      PyErr_SetObject(type.ptr(), raised.ptr());
    };
    try {
      std::rethrow_exception(std::move(error));
    } catch (const client::Refused& refused) {
      raise("Refused", refused.what(), static_cast<int>(refused.code()));
    } catch (const client::NoServer& lost) {
      raise("NoServer", lost.what());
    } catch (const client::SolveFailed& failed) {
      raise("SolveFailed", failed.what());
    } catch (const Cancelled& cancelled) {
      raise("Cancelled", cancelled.what());
    } catch (const InvalidInput& invalid) {
      raise("InvalidInput", invalid.what());
    } catch (const TransportError& broken) {
      raise("TransportError", broken.what());
    }
  });
}

/// Page's thread is waited for.
struct WithoutGil {
  void operator()(Page* page) const {
    const Unlocked unlocked;
    delete page;
  }
};

using client::Client;

void defineSessions(ClientClass& type) {
  type.def("list_sessions",
           [](Client& server) {
             return awaitDict(server.listSessions());
           })
      .def(
          "open_session",
          [](const std::shared_ptr<Client>& server, const py::dict& request) {
            const auto state =
                await(server->openSession(messageOf<v1::OpenSessionRequest>(request)));
            return std::make_unique<LiveSession>(server, state);
          },
          "request"_a)
      .def(
          "join_session",
          [](const std::shared_ptr<Client>& server, std::uint64_t id) {
            return std::make_unique<LiveSession>(server, await(server->describeSession(id)));
          },
          "session_id"_a)
      .def(
          "load_session",
          [](const std::shared_ptr<Client>& server, const std::string& text) {
            return std::make_unique<LiveSession>(server, await(server->loadSession(text)));
          },
          "text"_a);
}

void defineServer(py::module_& module) {
  ClientClass type(module, "Client");
  type.def(py::init(&connect), "domain"_a, "interface"_a, "start"_a, "peers"_a, "server"_a,
           "identity"_a)
      .def_property_readonly("is_private", &Client::isPrivate)
      .def("alive", &Client::alive)
      .def("status",
           [](Client& server) {
             return dictOf(server.status());
           })
      .def(
          "ask",
          [](Client& server, const py::dict& body) {
            return awaitDict(server.ask(bodyOf(body)));
          },
          "body"_a)
      .def(
          "page_file",
          [](Client& server, std::uint64_t id, const std::string& folder) {
            const Unlocked unlocked;
            return client::gateway::pageFile(server, id, client::gateway::readWebFiles(folder));
          },
          "session_id"_a, "folder"_a);
  defineModels(type);
  defineSessions(type);
  py::class_<Page, std::unique_ptr<Page, WithoutGil>>(module, "Page")
      .def(py::init<std::shared_ptr<Client>, const std::string&>(), "server"_a, "folder"_a)
      .def_property_readonly("address", &Page::address);
}

using SessionClass = py::class_<LiveSession>;

void defineSolving(SessionClass& session_class) {
  session_class
      .def("state",
           [](LiveSession& session) {
             session.get().take();
             return dictOf(session.get().state());
           })
      .def(
          "edit",
          [](LiveSession& session, const py::dict& body, std::uint64_t base_revision,
             const std::optional<py::dict>& when) {
            std::optional<v1::EditTime> at;
            if (when) at = messageOf<v1::EditTime>(*when);
            return awaitDict(
                session.get().edit(messageOf<v1::EditBody>(body), base_revision, at));
          },
          "body"_a, "base_revision"_a, "when"_a)
      .def(
          "solve",
          [](LiveSession& session, const std::optional<py::dict>& options) {
            std::optional<v1::SolveOptions> solving;
            if (options) solving = messageOf<v1::SolveOptions>(*options);
            return dictOf(session.get().adopt(await(session.get().solve(solving))));
          },
          "options"_a)
      .def(
          "await_final",
          [](LiveSession& session, std::uint64_t revision) -> py::object {
            const v1::PoseSolution* pose = nullptr;
            {
              const Unlocked unlocked;
              pose = session.get().awaitFinal(revision);
            }
            return pose == nullptr ? py::none() : dictOf(*pose);
          },
          "revision"_a)
      .def(
          "await_diagnosed",
          [](LiveSession& session, std::uint64_t revision) {
            const Unlocked unlocked;
            const v1::PoseSolution pose = session.get().awaitDiagnosed(revision);
            const py::gil_scoped_acquire held;
            return dictOf(pose);
          },
          "revision"_a)
      .def("last", [](LiveSession& session) -> py::object {
        session.get().take();
        const v1::PoseSolution* pose = session.get().solution();
        return pose == nullptr ? py::none() : dictOf(*pose);
      });
}

void defineRecords(SessionClass& session_class) {
  session_class
      .def("settings",
           [](LiveSession& session) {
             return awaitDict(session.get().settings());
           })
      .def("transfer",
           [](LiveSession& session) {
             return awaitDict(session.get().transfer());
           })
      .def("save",
           [](LiveSession& session) {
             return await(session.get().save());
           })
      .def(
          "export",
          [](LiveSession& session, const py::dict& given) {
            py::dict request(given.attr("copy")());
            request["session_id"] = session.get().id();
            const client::ExportedFile file =
                await(session.client().exportSession(messageOf<v1::ExportRequest>(request)));
            return py::make_tuple(py::bytes(file.content), file.notes);
          },
          "request"_a)
      .def("stop_solving",
           [](LiveSession& session) {
             await(session.get().stopSolving());
           })
      .def("close", [](LiveSession& session) {
        await(session.get().close());
      });
}

void defineSession(py::module_& module) {
  py::class_<Watch>(module, "Watch").def("next", &Watch::next, "patience_s"_a);
  SessionClass session_class(module, "Session");
  session_class
      .def_property_readonly("id",
                             [](LiveSession& session) {
                               return session.get().id();
                             })
      .def("watch", [](LiveSession& session) {
        return std::make_unique<Watch>(session.shared(), session.get().id());
      });
  py::class_<Demonstrator>(module, "DemonstratorWriter")
      .def(py::init<LiveSession&>(), "session"_a)
      .def("send", &Demonstrator::send, "frame"_a);
  defineSolving(session_class);
  defineRecords(session_class);
}

}  // namespace

PYBIND11_MODULE(_handgraft, module) {
  module.doc() = "The client library; use the package handgraft.";
  defineErrors();
  module.def("is_path", &client::isPath, "text"_a);
  module.def("pose_file", &poseFile, "path"_a);
  defineServer(module);
  defineSession(module);
}

}  // namespace handgraft::python
