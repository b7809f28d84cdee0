#include "client/present/contacts_output.h"

#include "client/present/json_output.h"
#include "client/present/model_text.h"
#include "client/present/output_file.h"
#include "client/present/png_file.h"
#include "core/base/error.h"

namespace handgraft::client {

std::string outputOf(Client& server,
                     const std::string& contacts,
                     const PosedLinks& hand,
                     const ContactsOutput& output) {
  const v1::ModelDescription description =
      server.describe(v1::MODEL_CONTACTS, contacts, true).get();  // the map says its threshold
  const v1::ContactsDescription& set = description.contacts();
  if (!output.set.empty()) {
    if (set.file().empty()) {
      throw TransportError(fmt::format("the server sent no file of contacts '{}'", contacts));
    }
    writeFile(output.set, set.file());
  }
  if (!output.png.empty()) {
    const v1::ModelDescription object =
        server.describe(v1::MODEL_OBJECT, set.object(), true).get();
    const ContactsPicture picture = pictureOf(set, object.object(), hand);
    writePng(output.png, render::renderTwoViews(picture.scene, picture.caption, picture.views));
  }
  return output.json ? json::written(json::description(description)) + "\n"
                     : text::description(description);
}

}  // namespace handgraft::client
