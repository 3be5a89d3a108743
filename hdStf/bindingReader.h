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

/// Values by their names, as primvars have them (`stf:scale`).
using HdStfBindingValues = std::vector<std::pair<TfToken, VtValue>>;

/// What messages call them: primvars of a prim, or inputs of a material's StfShell node.
enum class HdStfBindingSource { Primvars, ShaderInputs };

/// Reads the properties of StfShellAPI from a prim's constant primvars (names without `primvars:`; others are skipped),
/// or from inputs named likewise, over those that are \p beneath. Nothing where no base volume is named. A value may
/// come as an array of one. What has a wrong type or is out of range is reported once with the prim's path, and what is
/// beneath, or the schema's default, stands. Pure but for the messages: any thread.
std::optional<stf::StfBinding> HdStfReadBinding(SdfPath const& id, HdStfBindingValues const& values,
                                                HdStfMessages& messages,
                                                HdStfBindingSource source = HdStfBindingSource::Primvars,
                                                std::optional<stf::StfBinding> const& beneath = std::nullopt);

PXR_NAMESPACE_CLOSE_SCOPE
