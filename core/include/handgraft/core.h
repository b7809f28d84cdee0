#pragma once

/// The numerical core of Handgraft, without a server: readers of meshes, hands and contacts,
/// log maps, the transfer of patches onto a hand's skin, whole-hand poses.
///
/// SI units and radians; +z up; frames in the names (X_WO is the pose of O in W). Errors are
/// exceptions: InvalidInput names the thing, its value and the permitted range. core/examples
/// has a worked example; each folder's README tells how it works.
///
/// These headers are public: they change with a line in the changelog. What they include
/// besides is installed, too, and may change at any time.

#include "core/base/error.h"
#include "core/base/pose.h"
#include "core/base/progress.h"
#include "core/contact/contact_set.h"
#include "core/geometry/log_map.h"
#include "core/geometry/surface_point.h"
#include "core/geometry/triangle_mesh.h"
#include "core/hand/hand.h"
#include "core/hand/hand_model.h"
#include "core/hand/kinematics.h"
#include "core/hand/skin.h"
#include "core/hand/skin_cache.h"
#include "core/io/contact_file.h"
#include "core/io/mesh_file.h"
#include "core/io/motion_file.h"
#include "core/io/motion_import.h"
#include "core/io/object_file.h"
#include "core/io/problem_file.h"
#include "core/io/sites_file.h"
#include "core/io/urdf_file.h"
#include "core/manipulation/causal_solver.h"
#include "core/manipulation/grasp_interpolation.h"
#include "core/manipulation/offline_solver.h"
#include "core/manipulation/transfer_patches.h"
#include "core/manipulation/transfer_points.h"
#include "core/optimize/pose_problem.h"
#include "core/optimize/solver.h"
#include "core/session/session.h"
#include "core/transfer/patch_transfer.h"
