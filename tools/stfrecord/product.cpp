// SPDX-License-Identifier: Apache-2.0
#include "tools/stfrecord/product.h"

#include <algorithm>
#include <cctype>

namespace stfrecord {
namespace {

/// What a type of USD is in an image.
struct Format {
    int channels = 0; ///< 0: as many as there are
    bool half = false;
    bool integer = false;
};

/// By the name of a type of USD, such as color3f or half; nothing for one that images cannot hold.
std::optional<Format> formatOf(std::string type) {
    for (const char* role : {"color", "normal", "point", "vector", "texCoord"}) {
        if (type.rfind(role, 0) == 0) {
            type = "role" + type.substr(std::string(role).size());
        }
    }
    for (const char* name : {"role", "float", "half", "int"}) {
        const std::string base = name;
        if (type.rfind(base, 0) != 0) {
            continue;
        }
        std::string rest = type.substr(base.size());
        Format format;
        format.channels = 1;
        format.half = base == "half";
        format.integer = base == "int";
        if (!rest.empty() && rest[0] >= '2' && rest[0] <= '4') {
            format.channels = rest[0] - '0';
            rest.erase(0, 1);
        }
        if (base == "role") {
            format.half = rest == "h";
            return format.channels > 1 && (rest == "f" || rest == "h" || rest == "d") ? std::make_optional(format)
                                                                                      : std::nullopt;
        }
        return rest.empty() ? std::make_optional(format) : std::nullopt;
    }
    return std::nullopt;
}

template<class T>
std::vector<T> firstChannels(const std::vector<T>& values, std::size_t have, std::size_t want) {
    std::vector<T> result;
    result.reserve(values.size() / have * want);
    for (std::size_t i = 0; i + have <= values.size(); i += have) {
        result.insert(result.end(), values.begin() + std::ptrdiff_t(i), values.begin() + std::ptrdiff_t(i + want));
    }
    return result;
}

void convert(Layer& layer, const ProductVar& var, std::vector<std::string>& problems) {
    if (var.dataType.empty()) {
        return;
    }
    const std::optional<Format> format = formatOf(var.dataType);
    const std::string who = "render var " + var.layer + ": ";
    if (!format) {
        problems.push_back(who + "no image holds values of type " + var.dataType + "; it is written as it is");
        return;
    }
    if (var.aov.rfind("cryptoObject", 0) == 0) {
        if (format->half || format->channels != layer.channels) {
            problems.push_back(who + "ids are lost in any other type than float4 or color4f; it is written as that");
        }
        return;
    }
    if (format->integer != !layer.integers.empty()) {
        problems.push_back(who + (format->integer ? "it is no integer" : "ids are integers") + ", not " + var.dataType +
                           "; it is written as it is");
        return;
    }
    layer.half = format->half;
    if (format->channels > layer.channels) {
        problems.push_back(who + "it has " + std::to_string(layer.channels) + " channels, not those of " +
                           var.dataType + "; it is written with these");
    } else if (format->channels < layer.channels) {
        const std::size_t have = std::size_t(layer.channels), want = std::size_t(format->channels);
        layer.floats = firstChannels(layer.floats, have, want);
        layer.integers = firstChannels(layer.integers, have, want);
        layer.channels = format->channels;
    }
}

} // namespace

std::vector<std::string> aovsOf(const std::string& name) {
    return name == "cryptoObject" ? std::vector<std::string>{"cryptoObject00", "cryptoObject01", "cryptoObject02"}
                                  : std::vector<std::string>{name};
}

std::vector<Layer> productLayers(const std::vector<ProductVar>& vars, std::vector<Layer> rendered,
                                 std::vector<std::string>& problems) {
    std::vector<Layer> layers;
    for (const ProductVar& var : vars) {
        const auto it =
            std::find_if(rendered.begin(), rendered.end(), [&](const Layer& layer) { return layer.aov == var.aov; });
        if (it == rendered.end()) {
            continue; // said when it was asked for
        }
        Layer layer = *it;
        layer.name = var.layer;
        convert(layer, var, problems);
        layers.push_back(std::move(layer));
    }
    return layers;
}

} // namespace stfrecord
