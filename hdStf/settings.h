// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "pxr/imaging/hd/renderDelegate.h"
#include "pxr/pxr.h"

PXR_NAMESPACE_OPEN_SCOPE

/// The render settings the delegate offers, those of settingTable.h. Defaults come from the environment where it says
/// something.
HdRenderSettingDescriptorList HdStfMakeSettingDescriptors();

/// Those of them that a host's panel can show: usdview has widgets for bool, int, float and string, and warns of every
/// other type each time it makes its menu. A double is offered as float; it is kept as double.
HdRenderSettingDescriptorList HdStfPanelDescriptors(HdRenderSettingDescriptorList const& descriptors);

/// The value in the type of the setting's default and within its range; empty if it cannot be had (a wrong type, not
/// a number), or if \p key is not a setting of this delegate. Pure: any thread.
VtValue HdStfNormalizeSetting(HdRenderSettingDescriptorList const& descriptors, TfToken const& key,
                              VtValue const& value);

PXR_NAMESPACE_CLOSE_SCOPE
