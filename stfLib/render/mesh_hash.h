// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "stfLib/surface/control_mesh.h"

#include <string>

namespace stf {

/// Hash of how the faces of a mesh hang together: nothing that depends on where its points are.
std::string topologyHash(const ControlMesh& mesh);
/// Hash of all that the shell's surface and its mapping read of a mesh at rest: topology, the rest pose (the points,
/// where it has none), texture coordinates, tangents. Colours are not among them.
std::string restHash(const ControlMesh& mesh);
/// Hash of what differs between poses of one mesh: points and authored normals.
std::string poseHash(const ControlMesh& mesh);

} // namespace stf
