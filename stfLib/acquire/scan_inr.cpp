// SPDX-License-Identifier: Apache-2.0
#include "stfLib/acquire/scan_inr.h"

#include "stfLib/acquire/scan_raw.h"

#include <map>
#include <sstream>
#include <zlib.h>

namespace stf {

namespace {

constexpr std::size_t kBlock = 256, kLargestHeader = 64 * kBlock;
const std::string kMagic = "#INRIMAGE-4#{", kEnd = "##}";

// The header with its closing mark; gzread reads files that are not packed as they are.
std::string headerText(const std::string& path) {
    const gzFile file = ::gzopen(path.c_str(), "rb");
    if (!file) {
        throw Error("cannot be opened");
    }
    std::string text;
    char block[kBlock];
    while (text.size() < kLargestHeader && text.find(kEnd) == std::string::npos) {
        const int n = ::gzread(file, block, kBlock);
        if (n > 0) {
            text.append(block, std::size_t(n));
        }
        if (n < int(kBlock) || text.compare(0, kMagic.size(), kMagic) != 0) {
            break;
        }
    }
    ::gzclose(file);
    if (text.compare(0, kMagic.size(), kMagic) != 0) {
        throw Error("is no INRIMAGE-4 file: it does not begin with '" + kMagic + "'");
    }
    if (text.find(kEnd) == std::string::npos || text.size() % kBlock != 0) {
        throw Error("the INRIMAGE-4 header does not end with '" + kEnd + "' within its first " +
                    std::to_string(text.size()) + " bytes");
    }
    return text;
}

class Fields {
public:
    explicit Fields(const std::string& text) {
        std::istringstream lines(text);
        for (std::string line; std::getline(lines, line);) {
            const std::size_t equals = line.find('=');
            if (equals != std::string::npos && line[0] != '#') {
                std::string value = line.substr(equals + 1);
                while (!value.empty() && (value.back() == '\r' || value.back() == ' ')) {
                    value.pop_back();
                }
                fields_[line.substr(0, equals)] = value;
            }
        }
    }
    const std::string& text(const std::string& key) const {
        const auto found = fields_.find(key);
        if (found == fields_.end()) {
            throw Error("the INRIMAGE-4 header has no " + key);
        }
        return found->second;
    }
    double number(const std::string& key) const {
        const std::string& value = text(key);
        std::istringstream in(value);
        double x = 0;
        if (!(in >> x)) {
            throw Error("the INRIMAGE-4 header says " + key + "=" + value);
        }
        return x;
    }
    int whole(const std::string& key) const {
        const double x = number(key);
        if (!(x >= 1 && x <= 2147483647.0) || x != double(int(x))) {
            throw Error("the INRIMAGE-4 header says " + key + "=" + text(key));
        }
        return int(x);
    }
    bool has(const std::string& key) const { return fields_.count(key) > 0; }

private:
    std::map<std::string, std::string> fields_;
};

ScanType typeOf(const Fields& f) {
    const std::string& kind = f.text("TYPE");
    const int bits = f.whole("PIXSIZE");
    if (kind == "float" && (bits == 32 || bits == 64)) {
        return bits == 32 ? ScanType::Float32 : ScanType::Float64;
    }
    if (kind == "unsigned fixed" || kind == "signed fixed") {
        const bool sign = kind == "signed fixed";
        if (bits == 8) {
            return sign ? ScanType::Int8 : ScanType::UInt8;
        }
        if (bits == 16) {
            return sign ? ScanType::Int16 : ScanType::UInt16;
        }
        if (bits == 32) {
            return sign ? ScanType::Int32 : ScanType::UInt32;
        }
    }
    throw Error("the INRIMAGE-4 header says TYPE=" + kind + ", PIXSIZE=" + f.text("PIXSIZE") +
                ", which this program does not read");
}

bool isBigEndian(const Fields& f) {
    const std::string& cpu = f.text("CPU");
    if (cpu == "decm" || cpu == "alpha" || cpu == "pc") {
        return false;
    }
    if (cpu == "sun" || cpu == "sgi") {
        return true;
    }
    throw Error("the INRIMAGE-4 header says CPU=" + cpu + " (known: decm, alpha, pc, sun, sgi)");
}

} // namespace

std::unique_ptr<ScanReader> openInr(const std::string& path) {
    const std::string text = headerText(path);
    const Fields fields(text);
    RawLayout layout;
    layout.size = {fields.whole("XDIM"), fields.whole("YDIM"), fields.whole("ZDIM")};
    layout.headerBytes = text.size();
    layout.type = typeOf(fields);
    layout.bigEndian = bytesOf(layout.type) > 1 && isBigEndian(fields);
    if (fields.has("VDIM") && fields.whole("VDIM") != 1) {
        throw Error("holds " + fields.text("VDIM") + " values per voxel; a scan has one");
    }
    ScanHeader header;
    header.format = "INR";
    header.spacingKnown = fields.has("VX") && fields.has("VY") && fields.has("VZ");
    if (header.spacingKnown) {
        header.spacingMm = {fields.number("VX"), fields.number("VY"), fields.number("VZ")};
    }
    return openVoxelBlock(path, layout, header);
}

} // namespace stf
