// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "stfLib/render/stf_binding.h"

#include "pxr/base/tf/token.h"
#include "pxr/base/vt/value.h"
#include "pxr/pxr.h"
#include "pxr/usd/sdf/path.h"

#include <optional>
#include <utility>
#include <vector>

PXR_NAMESPACE_OPEN_SCOPE

class HdStfMessages;

/// Reads the properties of StfShellAPI from a prim's constant primvars (names without `primvars:`; others are skipped).
/// Nothing where no base volume is named. A value may come as an array of one. What has a wrong type or is out of range
/// is reported once with the prim's path, and the schema's default stands. Pure but for the messages: any thread.
std::optional<stf::StfBinding>
HdStfReadBinding(SdfPath const& id, std::vector<std::pair<TfToken, VtValue>> const& primvars, HdStfMessages& messages);

PXR_NAMESPACE_CLOSE_SCOPE
