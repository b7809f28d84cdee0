#pragma once

#include "core/contact/segmentation.h"
#include "idl/models.h"
#include "server/reading/read_model.h"
#include "server/store/upload_store.h"

/// Requests to load models, as what is to be read. What comes from the wire is checked here, as
/// in convert.h (InvalidInput).
namespace handgraft::server {

hand::SkinOptions skinOptionsFrom(const v1::SkinRecipe& recipe);

HandReading handReadingFrom(const v1::HandOptions& options);

/// Threshold to interpolation count; joints are a file's.
contact::SegmentationOptions segmentationFrom(const v1::ContactOptions& options);

/// All but the object.
ContactReading contactReadingFrom(const v1::ContactOptions& options);

/// All but the object of contacts.
ReadRequest readRequestFrom(const v1::LoadModelRequest& request, const UploadedFiles& files);

}  // namespace handgraft::server
