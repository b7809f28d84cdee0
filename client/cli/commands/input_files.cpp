#include "client/cli/commands/input_files.h"

namespace handgraft::client {

std::vector<NamedFile> inputsOf(const std::optional<ModelFiles>& model,
                                const std::string& option) {
  std::vector<NamedFile> inputs;
  if (!model) return inputs;
  for (const UploadFile& file : model->files) {
    if (file.uri != kSitesUri && !file.text) inputs.push_back({option, file.path});
  }
  return inputs;
}

}  // namespace handgraft::client
