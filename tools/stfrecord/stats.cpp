// SPDX-License-Identifier: Apache-2.0
#include "tools/stfrecord/stats.h"

#include "stfLib/render/cryptomatte.h"
#include "tools/stfrecord/atomicFile.h"

#include "pxr/base/tf/stringUtils.h"

#include <nlohmann/json.hpp>

#include <fstream>
#include <stdexcept>

namespace stfrecord {

PXR_NAMESPACE_USING_DIRECTIVE

namespace {

using Json = nlohmann::ordered_json;

double number(const VtDictionary& stats, const std::string& key) {
    const auto it = stats.find(key);
    const VtValue value = it == stats.end() ? VtValue() : VtValue::Cast<double>(it->second);
    return value.IsEmpty() ? 0.0 : value.UncheckedGet<double>();
}

/// An entry that holds JSON as text; an empty list where there is none.
Json list(const VtDictionary& stats, const std::string& key) {
    const auto it = stats.find(key);
    if (it == stats.end() || !it->second.IsHolding<std::string>()) {
        return Json::array();
    }
    const Json json = Json::parse(it->second.UncheckedGet<std::string>(), nullptr, false);
    return json.is_array() ? json : Json::array();
}

Json frameJson(const FrameStats& frame, const Json& messages) {
    const VtDictionary& stats = frame.delegate;
    const double megabyte = 1024.0 * 1024.0;
    Json json;
    json["scene"] = frame.scene;
    if (!frame.product.empty()) {
        json["product"] = frame.product;
    }
    json["frame"] = frame.frame;
    json["width"] = frame.width;
    json["height"] = frame.height;
    json["samples"] = int(number(stats, "numCompletedSamples"));
    json["seconds"] = {{"load", number(stats, "stf:loadSeconds")},
                       {"precompute", number(stats, "stf:precomputeSeconds")},
                       {"synthesis", number(stats, "stf:synthesisSeconds")},
                       {"shell", number(stats, "stf:shellSeconds")},
                       {"core", number(stats, "stf:coreSeconds")},
                       {"indirect", number(stats, "stf:indirectSeconds")},
                       {"firstPixel", number(stats, "stf:firstPixelSeconds")},
                       {"render", number(stats, "stf:renderSeconds")},
                       {"total", frame.seconds}};
    json["made"] = {{"syntheses", int(number(stats, "stf:syntheses"))},
                    {"grids", int(number(stats, "stf:grids"))},
                    {"poses", int(number(stats, "stf:poses"))}};
    json["memoryMB"] = {{"peak", number(stats, "peakMemory") / megabyte},
                        {"tables", number(stats, "stf:tableBytes") / megabyte},
                        {"shell", number(stats, "stf:shellBytes") / megabyte}};
    json["rays"] = static_cast<std::uint64_t>(number(stats, "stf:rays"));
    json["estimatedError"] = number(stats, "stf:estimatedError");
    json["plan"] = list(stats, "stf:plan");
    json["messages"] = messages;
    return json;
}

} // namespace

void collectMessages(const VtDictionary& delegateStats, Console& console) {
    for (const Json& message : list(delegateStats, "stf:messages")) {
        const std::string severity = message.value("severity", "error");
        // Printed when they arose, as Tf warnings, which do not tell an error from a warning.
        console.note(severity, message.value("text", ""), severity == "error");
    }
}

void writeStats(const std::vector<FrameStats>& frames, const std::vector<Message>& messages, const std::string& path) {
    Json messageList = Json::array();
    for (const Message& message : messages) {
        messageList.push_back({{"severity", message.severity}, {"text", message.text}});
    }
    Json json = Json::array();
    for (const FrameStats& frame : frames) {
        json.push_back(frameJson(frame, messageList));
    }
    const Json& whole = frames.size() == 1 ? json[0] : json;
    writeAtomically(path, [&](const std::string& temporary) {
        std::ofstream file(temporary);
        file << whole.dump(2, ' ', false, Json::error_handler_t::replace) << "\n";
        file.close();
        if (!file) {
            throw std::runtime_error("cannot write " + path);
        }
    });
}

std::vector<std::pair<std::string, std::string>> imageMetadata(const FrameStats& frame, const Image& image) {
    const Json json = frameJson(frame, Json::array());
    const auto text = [](const Json& value) { return value.dump(-1, ' ', false, Json::error_handler_t::replace); };
    std::vector<std::pair<std::string, std::string>> result = {{"renderPlan", text(json["plan"])},
                                                               {"renderTimes", text(json["seconds"])},
                                                               {"samplesPerPixel", text(json["samples"])},
                                                               {"estimatedError", text(json["estimatedError"])}};
    const auto manifest = frame.delegate.find("stf:cryptoObject");
    const std::string layer = "00";
    for (const Layer& first : image.layers) {
        if (first.aov != "cryptoObject00" || manifest == frame.delegate.end() ||
            !manifest->second.IsHolding<std::string>()) {
            continue;
        }
        // The layers' common name, and seven digits of its hash to tell several cryptomattes apart.
        const bool numbered = TfStringEndsWith(first.name, layer);
        const std::string name = numbered ? first.name.substr(0, first.name.size() - layer.size()) : first.name;
        const std::string key = "cryptomatte/" + TfStringPrintf("%08x", stf::murmurHash3(name)).substr(0, 7) + "/";
        result.insert(result.end(), {{key + "name", name},
                                     {key + "hash", "MurmurHash3_32"},
                                     {key + "conversion", "uint32_to_float32"},
                                     {key + "manifest", manifest->second.UncheckedGet<std::string>()}});
    }
    return result;
}

std::string planTable(const VtDictionary& delegateStats) {
    std::string text = TfStringPrintf("%-32s %-14s %-5s %9s  %s\n", "object", "stage", "runs", "seconds", "why");
    for (const Json& entry : list(delegateStats, "stf:plan")) {
        text += TfStringPrintf("%-32s %-14s %-5s %9.3f  %s\n", entry.value("object", "").c_str(),
                               entry.value("stage", "").c_str(), entry.value("runs", false) ? "yes" : "no",
                               entry.value("seconds", 0.0), entry.value("why", "").c_str());
    }
    return text;
}

} // namespace stfrecord
