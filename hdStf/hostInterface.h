// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "pxr/pxr.h"

#include <cstddef>

/// \file hostInterface.h
/// What a script in a host can ask the loaded plugin by C calls, where the host's own interface to a delegate gives no
/// access: Blender's reads no setting descriptors and of the statistics only `percentDone`. Any thread.
///
/// Both copy UTF-8 text with its closing zero into `buffer` as far as `size` bytes go, and return how many bytes all of
/// it needs (0: it could not be made).

#if defined(_WIN32)
#define HDSTF_EXPORT __declspec(dllexport)
#else
#define HDSTF_EXPORT __attribute__((visibility("default")))
#endif

extern "C" {

/// The settings that panels are offered, in order, as JSON: `[{"key", "name", "default", "description"}, ..]`; defaults
/// are booleans, integers, numbers with a point, or strings. Where there are such: "least" and "most" of numbers,
/// "choices" of strings.
HDSTF_EXPORT size_t hdStfSettingsJson(char* buffer, size_t size);

/// State of the delegate that was made last and is still there, as JSON: `{"annotation", "percentDone", "messages":
/// [{"severity", "text"}, ..]}`; `{}` if there is none.
HDSTF_EXPORT size_t hdStfStatusJson(char* buffer, size_t size);
}

PXR_NAMESPACE_OPEN_SCOPE

class HdStfRenderDelegate;

/// Called by delegates when they are there, and before they go.
void HdStfAnnounceDelegate(HdStfRenderDelegate const* delegate);
void HdStfRetireDelegate(HdStfRenderDelegate const* delegate);

PXR_NAMESPACE_CLOSE_SCOPE
