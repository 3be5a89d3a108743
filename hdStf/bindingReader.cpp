// SPDX-License-Identifier: Apache-2.0
#include "hdStf/bindingReader.h"

#include "hdStf/conversions.h"
#include "hdStf/messages.h"
#include "hdStf/tokens.h"

#include "pxr/base/tf/pathUtils.h"
#include "pxr/base/vt/array.h"
#include "pxr/usd/sdf/assetPath.h"

#include <algorithm>
#include <cmath>
#include <initializer_list>
#include <limits>
#include <string>

PXR_NAMESPACE_OPEN_SCOPE

namespace {

/// An array with one element as that element; anything else as it is.
template<class... T>
VtValue _Unwrap(VtValue const& value) {
    VtValue result = value;
    const auto tryType = [&](auto const* tag) {
        using Element = std::decay_t<decltype(*tag)>;
        if (value.IsHolding<VtArray<Element>>() && value.UncheckedGet<VtArray<Element>>().size() == 1) {
            result = VtValue(value.UncheckedGet<VtArray<Element>>().cdata()[0]);
        }
    };
    (tryType(static_cast<T const*>(nullptr)), ...);
    return result;
}

/// Reads one property after the other of one prim.
class _Reader {
public:
    _Reader(SdfPath const& id, HdStfBindingSource source, HdStfMessages& messages)
        : _id(id), _source(source), _messages(messages) {}

    template<class Number>
    void Read(TfToken const& name, VtValue const& authored, Number* result, Number smallest, bool smallestIncluded) {
        const VtValue value = VtValue::Cast<Number>(_Unwrap<float, double, int>(authored));
        if (value.IsEmpty()) {
            _Complain(name, "has type " + authored.GetTypeName() + " where a number is expected");
            return;
        }
        const Number number = value.template UncheckedGet<Number>();
        if (!std::isfinite(static_cast<double>(number)) || number < smallest ||
            (number == smallest && !smallestIncluded)) {
            _Complain(name, "is out of range");
            return;
        }
        *result = number;
    }

    void Read(TfToken const& name, VtValue const& authored, std::optional<stf::Rgb>* result) {
        const VtValue value = VtValue::Cast<GfVec3f>(_Unwrap<GfVec3f, GfVec3d>(authored));
        if (value.IsEmpty()) {
            _Complain(name, "has type " + authored.GetTypeName() + " where a colour is expected");
            return;
        }
        const stf::Rgb color = HdStfToVec3f(value.UncheckedGet<GfVec3f>());
        if (!stf::isFinite(color) || stf::minComponent(color) < 0) {
            _Complain(name, "is out of range");
            return;
        }
        *result = color;
    }

    /// A token or string, one of \p allowed if that is not empty.
    void Read(TfToken const& name, VtValue const& authored, std::string* result,
              std::initializer_list<char const*> allowed) {
        const VtValue value = _Unwrap<TfToken, std::string>(authored);
        std::string text;
        if (value.IsHolding<TfToken>()) {
            text = value.UncheckedGet<TfToken>().GetString();
        } else if (value.IsHolding<std::string>()) {
            text = value.UncheckedGet<std::string>();
        } else {
            _Complain(name, "has type " + authored.GetTypeName() + " where a token is expected");
            return;
        }
        if (allowed.size() > 0 && std::find(allowed.begin(), allowed.end(), text) == allowed.end()) {
            _Complain(name, "is \"" + text + "\", which is not one of its values");
            return;
        }
        *result = text;
    }

    /// A missing file resolves to nothing; messages then name it as authored.
    void ReadAsset(TfToken const& name, VtValue const& authored, std::string* path, std::string* authoredPath) {
        const VtValue value = _Unwrap<SdfAssetPath, std::string>(authored);
        if (value.IsHolding<SdfAssetPath>()) {
            SdfAssetPath const& asset = value.UncheckedGet<SdfAssetPath>();
            *authoredPath = asset.GetAssetPath();
            // A relative path that did not resolve must not be looked up in the working directory by chance.
            *path = asset.GetResolvedPath().empty() && !TfIsRelativePath(asset.GetAssetPath())
                        ? asset.GetAssetPath()
                        : asset.GetResolvedPath();
        } else if (value.IsHolding<std::string>()) {
            *path = *authoredPath = value.UncheckedGet<std::string>();
        } else {
            _Complain(name, "has type " + authored.GetTypeName() + " where an asset is expected");
        }
    }

private:
    void _Complain(TfToken const& name, std::string const& what) {
        const std::string property =
            _source == HdStfBindingSource::Primvars
                ? "primvars:" + name.GetString()
                : "inputs:" + name.GetString().substr(HdStfPrimvarTokens->prefix.GetString().size());
        _messages.Report(stf::Severity::Error,
                         _id.GetString() + ": " + property + " " + what + "; its default is used");
    }

    SdfPath const& _id;
    HdStfBindingSource _source;
    HdStfMessages& _messages;
};

} // namespace

std::optional<stf::StfBinding> HdStfReadBinding(SdfPath const& id, HdStfBindingValues const& values,
                                                HdStfMessages& messages, HdStfBindingSource source,
                                                std::optional<stf::StfBinding> const& beneath) {
    stf::StfBinding binding = beneath.value_or(stf::StfBinding());
    _Reader reader(id, source, messages);
    auto const& tokens = *HdStfPrimvarTokens;
    for (auto const& [name, value] : values) {
        if (name == tokens.baseVolume) {
            reader.ReadAsset(name, value, &binding.baseVolume, &binding.authoredPath);
        } else if (name == tokens.thickness) {
            reader.Read(name, value, &binding.thickness, 0.0f, true);
        } else if (name == tokens.scale) {
            reader.Read(name, value, &binding.scale, 0.0f, false);
        } else if (name == tokens.mapping) {
            reader.Read(name, value, &binding.mapping, {"auto", "uv", "synthesize", "blend"});
        } else if (name == tokens.coreMaterial) {
            reader.Read(name, value, &binding.coreMaterial, {});
        } else if (name == tokens.coreSigmaA) {
            reader.Read(name, value, &binding.coreSigmaA);
        } else if (name == tokens.coreSigmaSPrime) {
            reader.Read(name, value, &binding.coreSigmaSPrime);
        } else if (name == tokens.coreModel) {
            reader.Read(name, value, &binding.coreModel, {"auto", "dipole", "walk", "none"});
        } else if (name == tokens.transport) {
            reader.Read(name, value, &binding.transport, {"dE1", "classic"});
        } else if (name == tokens.quality) {
            reader.Read(name, value, &binding.quality, 0.0f, false);
        } else if (name == tokens.seed) {
            reader.Read(name, value, &binding.seed, std::numeric_limits<int>::min(), true);
        }
    }
    if (binding.authoredPath.empty()) {
        return std::nullopt;
    }
    return binding;
}

PXR_NAMESPACE_CLOSE_SCOPE
