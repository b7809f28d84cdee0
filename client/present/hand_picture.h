#pragma once

#include <array>

#include "client/present/render/two_views.h"
#include "idl/models.h"

namespace handgraft::client {

/// A scene with the sides that show it best. Frame W of the scene is S, the hand's root.
struct HandPicture {
  render::Scene scene;
  render::Caption caption;
  std::array<render::View, 2> views;
};

/// The hand at the pose in which its skin was made: its links, each site as a dot with its
/// normal and an arrow along its direction. From the palm's side and from the thumb's, fingers
/// up, as the sites tell.
///
/// `hand` must have been described with meshes.
/// Errors: TransportError if the description contradicts itself.
HandPicture pictureOfSites(const v1::HandDescription& hand);

/// The skin, each link's share in its own colour, from the same sides. Errors as above.
HandPicture pictureOfSkin(const v1::HandDescription& hand);

}  // namespace handgraft::client
