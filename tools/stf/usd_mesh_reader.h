// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "stfLib/acquire/mesh_reader.h"
#include "stfLib/base/error.h"

namespace stf {

/// The visible meshes of a USD file in world space, in mm and with z up, each with the name of the material it is bound
/// to. Subdivision surfaces are refined, instances and what payloads hold are included; of other shapes, `messages` is
/// told how many there are. Throws Error with a message that starts with the path.
std::vector<MeshPart> readUsdMeshes(const std::string& path, const MessageSink& messages);

} // namespace stf
