#pragma once

#include <map>
#include <memory>
#include <string>
#include <vector>

#include "core/base/progress.h"
#include "core/contact/contact_set.h"
#include "core/geometry/triangle_mesh.h"
#include "core/hand/hand.h"

namespace handgraft::session {

/// Where sessions find models by name when an edit, an undo or a file asks for them.
class ModelSource {
 public:
  virtual ~ModelSource() = default;

  /// Errors: InvalidInput or the owner's own if there is none of that name. May take long.
  virtual hand::Hand hand(const std::string& name, const Progress& progress) = 0;
  virtual std::shared_ptr<const geometry::TriangleMesh> object(const std::string& name,
                                                               const Progress& progress) = 0;
};

/// A frame of a motion: its patches as they are then, as many as the session's contacts have.
struct FrameContacts {
  std::shared_ptr<const contact::ContactSet> contacts;
  std::vector<bool> is_there;  ///< of each patch
};

/// What a session is opened with.
struct SessionModels {
  std::string hand_name;
  hand::Hand hand;
  std::string object_name;
  std::shared_ptr<const geometry::TriangleMesh> object_O;
  std::string contacts_name;
  std::shared_ptr<const contact::ContactSet> contacts;  ///< on that object's mesh
  std::shared_ptr<ModelSource> source = nullptr;        ///< null: there are no others
  /// Where the contacts stand for a motion: those of its frames by which fingers are dealt.
  std::vector<FrameContacts> frames{};
  /// That try ways to lay the patches; which is taken does not depend on it.
  int threads = 1;
};

/// Those of a grasp with the models' own names, and no others to swap to.
SessionModels modelsOf(hand::Hand hand,
                       std::shared_ptr<const geometry::TriangleMesh> object_O,
                       const contact::ContactSet& contacts);

/// What a document's names stand for.
struct Models {
  const hand::Hand* hand = nullptr;
  std::shared_ptr<const geometry::TriangleMesh> object_O;
  /// On that mesh: carried there where the set was made for another one.
  std::shared_ptr<const contact::ContactSet> contacts;
  std::vector<FrameContacts> frames{};  ///< of a motion on that mesh
  int threads = 1;                      ///< to try ways to lay patches
};

/// The models of one session by name: those it was opened with, and those that edits brought
/// in, which stay what they were for as long as the session lives, so that undo finds them.
class ModelCache {
 public:
  /// Errors: BrokenContract if a model is missing.
  explicit ModelCache(SessionModels models);

  /// Errors: InvalidInput if nobody knows the name, or more than kMostModels were asked for.
  const hand::Hand& hand(const std::string& name, const Progress& progress);
  std::shared_ptr<const geometry::TriangleMesh> object(const std::string& name,
                                                       const Progress& progress);

  /// The session's contact set on another object: itself on a mesh like its own, else carried
  /// (contact/carry.h). Errors: InvalidInput as there.
  std::shared_ptr<const contact::ContactSet> contactsOn(const std::string& object,
                                                        const Progress& progress);

  Models find(const std::string& hand, const std::string& object, const Progress& progress);

  [[nodiscard]] const SessionModels& first() const { return first_; }

  // === Fingerprints, so that a saved session is not played on other models (SHA-256, hex).
  std::string handHash(const std::string& name);
  std::string objectHash(const std::string& name);
  std::string contactsHash();

 private:
  SessionModels first_;
  std::map<std::string, hand::Hand> hands_;
  std::map<std::string, std::shared_ptr<const geometry::TriangleMesh>> objects_;
  std::map<std::string, std::shared_ptr<const contact::ContactSet>> carried_;  ///< by object
  std::map<std::string, std::string> hashes_;
};

/// Hands and objects that one session may have known.
inline constexpr std::size_t kMostModels = 32;

}  // namespace handgraft::session
