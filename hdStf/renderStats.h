// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "hdStf/messages.h"
#include "hdStf/renderJob.h"

#include "pxr/base/vt/dictionary.h"
#include "pxr/pxr.h"

PXR_NAMESPACE_OPEN_SCOPE

/// The entries of HdRenderDelegate::GetRenderStats (docs/settings.md): those that hosts show, and `stf:*` ones.
VtDictionary HdStfMakeRenderStats(HdStfRenderJob::Progress const& progress, HdStfMessages const& messages);

PXR_NAMESPACE_CLOSE_SCOPE
