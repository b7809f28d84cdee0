#pragma once

#include <atomic>
#include <chrono>
#include <memory>
#include <string>
#include <thread>
#include <utility>

#include "client/gateway/gateway.h"
#include "client/link/client.h"

namespace handgraft::python {

/// The page of a server's sessions, served on this machine alone for as long as this lives. Its
/// thread may want the GIL: whoever destroys it must not hold that.
class Page {
 public:
  Page(std::shared_ptr<client::Client> server, const std::string& folder)
      : server_(std::move(server)),
        gateway_(*server_, web_, client::gateway::readWebFiles(folder)),
        address_(client::gateway::addressOf(web_, gateway_.port())),
        thread_([this] {
          tend();
        }) {}

  ~Page() {
    ending_ = true;
    try {
      thread_.join();
    } catch (...) {  // there is no thread to wait for
    }
  }

  Page(const Page&) = delete;
  Page& operator=(const Page&) = delete;

  [[nodiscard]] const std::string& address() const { return address_; }

 private:
  void tend() {
    while (!ending_) {
      try {
        gateway_.tend();
      } catch (const std::exception&) {
        // Pages are told; the next time, perhaps.
      }
      std::this_thread::sleep_for(std::chrono::milliseconds(50));
    }
  }

  const client::gateway::WebOptions web_;
  const std::shared_ptr<client::Client> server_;
  client::gateway::Gateway gateway_;
  const std::string address_;
  std::atomic<bool> ending_ = false;
  std::thread thread_;  ///< last: it uses the others
};

}  // namespace handgraft::python
