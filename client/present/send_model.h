#pragma once

#include <optional>
#include <string>
#include <vector>

#include "client/link/client.h"
#include "client/link/model_files.h"
#include "client/present/interruption.h"

namespace handgraft::client {

/// The units that a refusal (ERROR_UNITS) recommends, the likeliest first: what follows each
/// `--units` in it.
std::vector<std::string> unitsIn(const std::string& refusal);

/// Sends models to the server.
class ModelSender {
 public:
  /// With `may_ask`, and where standard input and standard error are a terminal, the user is
  /// asked about units that the size makes doubtful.
  ModelSender(Client& server, Interruption& interruption, bool may_ask);

  /// The server's summary. Where the user said which units are meant, `model` holds them
  /// afterwards. Errors as those of `Client::load`.
  v1::ModelSummary load(ModelFiles& model);

  /// The name under which the server has the model afterwards. Another model of that name may
  /// be there, or the same one read otherwise; then this one is told apart by a hash of its
  /// content.
  std::string send(ModelFiles& model);

  /// The same for whoever goes on by that name: one that the user gave (`is_named`) is taken or
  /// refused, and of one that is told apart is said, on standard error, that its own is
  /// another's still.
  std::string import(ModelFiles& model, bool is_named);

 private:
  /// Complaints name files by the paths that were given.
  v1::ModelSummary loadOnce(const ModelFiles& model);
  /// Asks for one unit after the other; empty if the user agrees to none.
  std::string agreedUnits(const std::string& refusal);

  Client& server_;
  Interruption& interruption_;
  bool may_ask_;
};

/// `text` if it is a model's name; else what was sent of `files`.
std::string nameOnServer(ModelSender& sender,
                         const std::string& text,
                         std::optional<ModelFiles>& files);

}  // namespace handgraft::client
