#pragma once

#include <memory>
#include <string>

#include "core/session/models.h"
#include "server/store/model_store.h"

namespace handgraft::server {

/// Models for sessions that swap theirs. Errors of its methods: Rejection (ERROR_NOT_FOUND); a
/// hand's skin is made if need be.
std::shared_ptr<session::ModelSource> sourceOf(std::shared_ptr<const NamedModels> models);
/// The same of models that outlive it.
std::shared_ptr<session::ModelSource> sourceOf(const ModelStore& models);

/// An object's mesh alone; the file that holds it stays with it.
std::shared_ptr<const geometry::TriangleMesh> meshOf(
    const std::shared_ptr<const StoredObject>& object);

/// What a session on these models is opened with; a hand's skin is made if need be.
/// Errors: Rejection (ERROR_NOT_FOUND); InvalidInput if the contacts were read for another
/// mesh. `source`: of the models that it may take later.
session::SessionModels sessionModels(const std::string& hand,
                                     const std::string& object,
                                     const std::string& contacts,
                                     const NamedModels& models,
                                     std::shared_ptr<session::ModelSource> source,
                                     const Progress& progress);

/// The same of a motion: its contacts are the grasp that stands for it (retargeting::graspOf).
session::SessionModels motionModels(const std::string& hand,
                                    const std::string& object,
                                    const std::string& motion,
                                    const NamedModels& models,
                                    std::shared_ptr<session::ModelSource> source,
                                    const Progress& progress);

}  // namespace handgraft::server
