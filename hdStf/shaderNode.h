// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "pxr/pxr.h"

PXR_NAMESPACE_OPEN_SCOPE

/// Makes the node StfShell known to OpenUSD's shader registry, from its definition among the schema's resources: hosts
/// hand on materials of known nodes only. Once per process, with the first delegate; without the resources nothing
/// happens. Where the host has read shaders before, OpenUSD before 22.11 takes no more, and a warning says so.
void HdStfAnnounceShaderNode();

PXR_NAMESPACE_CLOSE_SCOPE
