// SPDX-License-Identifier: Apache-2.0
#include "stfLib/acquire/scan_reader.h"

#include "stfLib/acquire/scan_inr.h"
#include "stfLib/acquire/scan_itk.h"
#include "stfLib/acquire/scan_raw.h"
#include "stfLib/acquire/scan_vdb.h"

#include <algorithm>
#include <cctype>
#include <filesystem>

namespace stf {

namespace {

bool endsWith(const std::string& name, const std::string& ending) {
    return name.size() >= ending.size() && name.compare(name.size() - ending.size(), ending.size(), ending) == 0;
}

void checkHeader(const ScanHeader& h) {
    if (minComponent(h.size) < 1) {
        throw Error("a scan of " + sizeText(h.size) + " voxels cannot be");
    }
    // Far above any scanner: a header that was not understood, or is damaged.
    if (maxComponent(h.size) > (1 << 20)) {
        throw Error("a scan of " + sizeText(h.size) +
                    " voxels cannot be (at most 1048576 along an axis): is its header damaged, or of the other byte "
                    "order?");
    }
    if (!isFinite(h.spacingMm) || !(minComponent(h.spacingMm) > 0) || maxComponent(h.spacingMm) > 1e6) {
        throw Error("the distance of voxels is " + std::to_string(h.spacingMm.x) + " x " +
                    std::to_string(h.spacingMm.y) + " x " + std::to_string(h.spacingMm.z) + " mm");
    }
}

std::unique_ptr<ScanReader> open(const std::string& path, const ScanReadOptions& options, const MessageSink& messages) {
    namespace fs = std::filesystem;
    std::error_code error;
    if (!fs::exists(path, error)) {
        throw Error("no such file or folder");
    }
    std::string name = fs::path(path).filename().string();
    std::transform(name.begin(), name.end(), name.begin(), [](unsigned char c) { return char(std::tolower(c)); });
    if (options.raw) {
        return openRaw(path, options.layout, messages);
    }
    if (endsWith(name, ".inr") || endsWith(name, ".inr.gz")) {
        return openInr(path);
    }
    if (endsWith(name, ".vdb")) {
        return openVdb(path, options.grid, messages);
    }
    if (endsWith(name, ".raw") || endsWith(name, ".raw.gz") || endsWith(name, ".bin")) {
        throw Error("a file without a header needs its size and type (--dims, --type)");
    }
    return fs::is_directory(path) ? openSlices(path, options.series, messages) : openItk(path);
}

} // namespace

std::unique_ptr<ScanReader> openScan(const std::string& path, const ScanReadOptions& options,
                                     const MessageSink& messages) {
    try {
        auto reader = open(path, options, [&](Severity severity, const std::string& text) {
            report(messages, severity, path + ": " + text);
        });
        checkHeader(reader->header());
        return reader;
    } catch (const Error& e) {
        throw Error(path + ": " + e.what());
    }
}

} // namespace stf
