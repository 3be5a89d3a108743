// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "stfLib/base/error.h"

#include "pxr/pxr.h"

#include <mutex>
#include <set>
#include <string>
#include <vector>

PXR_NAMESPACE_OPEN_SCOPE

/// \class HdStfMessages
///
/// What the delegate has to say about the scene: each text once, as a warning to the host (never as a Tf error: these
/// are facts about data, and errors posted on worker threads reach nobody's error mark) and in a list that
/// GetRenderStats hands out. An Error means that something of the scene is missing in the image, or not as authored.
///
/// Threading: all methods may be called from any thread.
class HdStfMessages {
public:
    struct Message {
        stf::Severity severity;
        std::string text;
    };

    /// Reports \p text if it was not reported before. Info goes to the list only.
    void Report(stf::Severity severity, std::string const& text);

    /// Everything reported so far, oldest first.
    std::vector<Message> Get() const;

private:
    mutable std::mutex _mutex;
    std::set<std::string> _seen;
    std::vector<Message> _messages;
};

/// "info", "warning" or "error".
char const* HdStfSeverityName(stf::Severity severity);

PXR_NAMESPACE_CLOSE_SCOPE
