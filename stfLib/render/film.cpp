// SPDX-License-Identifier: Apache-2.0
#include "stfLib/render/film.h"

#include <limits>

namespace stf {

namespace {

struct AovInfo {
    const char* name;
    Aov aov;
    int channels;
};
constexpr AovInfo kAovs[] = {
    {"color", Aov::Color, 4},
    {"denoised", Aov::Denoised, 4},
    {"alpha", Aov::Alpha, 1},
    {"depth", Aov::Depth, 1},
    {"cameraDepth", Aov::CameraDepth, 1},
    {"normal", Aov::Normal, 3},
    {"Neye", Aov::Neye, 3},
    {"position", Aov::Position, 3},
    {"albedo", Aov::Albedo, 3},
    {"primId", Aov::PrimId, 1},
    {"instanceId", Aov::InstanceId, 1},
    {"elementId", Aov::ElementId, 1},
    {"sampleCount", Aov::SampleCount, 1},
    {"variance", Aov::Variance, 3},
    {"stf:single", Aov::StfSingle, 3},
    {"stf:multiple", Aov::StfMultiple, 3},
    {"stf:core", Aov::StfCore, 3},
    {"stf:reflection", Aov::StfReflection, 3},
};

const AovInfo& info(Aov aov) {
    for (const AovInfo& i : kAovs) {
        if (i.aov == aov) {
            return i;
        }
    }
    return kAovs[0];
}

} // namespace

bool aovFromName(const std::string& name, Aov& aov) {
    for (const AovInfo& i : kAovs) {
        if (name == i.name) {
            aov = i.aov;
            return true;
        }
    }
    return false;
}

bool aovIsInteger(Aov aov) {
    return aov == Aov::PrimId || aov == Aov::InstanceId || aov == Aov::ElementId;
}

int aovChannels(Aov aov) {
    return info(aov).channels;
}

void Film::resize(int width, int height) {
    width_ = std::max(0, width);
    height_ = std::max(0, height);
    clear();
}

void Film::clear() {
    const std::size_t n = std::size_t(width_) * std::size_t(height_);
    pixels_.assign(n, Accumulator());
    parts_.assign(n, Parts());
    hits_.assign(n, PixelHit());
    denoised_.clear();
}

std::uint32_t Film::sampleCount(int x, int y) const {
    return pixels_[index(x, y)].count;
}

void Film::add(int x, int y, const PixelSample& s) {
    const std::size_t i = index(x, y);
    Accumulator& a = pixels_[i];
    const Vec3d c(s.color);
    a.color += c;
    a.colorSquared += c * c;
    a.alpha += double(s.alpha);
    ++a.count;
    const auto none = [](const Rgb& v) { return v.x == 0 && v.y == 0 && v.z == 0; };
    if (none(s.single) && none(s.multiple) && none(s.core) && none(s.reflection)) {
        return; // no shell: most of many pictures
    }
    Parts& p = parts_[i];
    p.single += Vec3d(s.single);
    p.multiple += Vec3d(s.multiple);
    p.core += Vec3d(s.core);
    p.reflection += Vec3d(s.reflection);
}

std::vector<float> Film::read(Aov aov) const {
    const std::size_t channels = std::size_t(aovChannels(aov));
    std::vector<float> out(pixels_.size() * channels);
    for (std::size_t i = 0; i < pixels_.size(); ++i) {
        const Accumulator& a = pixels_[i];
        const PixelHit& h = hits_[i];
        const double inv = a.count ? 1.0 / a.count : 0.0, exposed = inv * exposure_;
        float* const p = out.data() + i * channels;
        const auto put = [&](const Vec3f& v) { p[0] = v.x, p[1] = v.y, p[2] = v.z; };
        switch (aov) {
        case Aov::Color:
            put(Rgb(a.color * exposed));
            p[3] = float(a.alpha * inv);
            break;
        case Aov::Denoised:
            put(denoised_.empty() ? Rgb(a.color * exposed)
                                  : Rgb(denoised_[3 * i], denoised_[3 * i + 1], denoised_[3 * i + 2]));
            p[3] = float(a.alpha * inv);
            break;
        case Aov::Alpha:
            p[0] = float(a.alpha * inv);
            break;
        case Aov::Depth:
            p[0] = h.depth;
            break;
        case Aov::CameraDepth:
            p[0] = h.cameraDepth;
            break;
        case Aov::Normal:
            put(h.normal);
            break;
        case Aov::Neye:
            put(h.neye);
            break;
        case Aov::Position:
            put(h.position);
            break;
        case Aov::Albedo:
            put(h.albedo);
            break;
        case Aov::SampleCount:
            p[0] = float(a.count);
            break;
        case Aov::Variance: {
            const Vec3d mean = a.color * inv, v = a.colorSquared * inv - mean * mean;
            const double scale = a.count > 1 ? exposure_ * exposure_ / (a.count - 1) : 0.0;
            put({float(std::max(0.0, v.x) * scale), float(std::max(0.0, v.y) * scale),
                 float(std::max(0.0, v.z) * scale)});
            break;
        }
        case Aov::StfSingle:
            put(Rgb(parts_[i].single * exposed));
            break;
        case Aov::StfMultiple:
            put(Rgb(parts_[i].multiple * exposed));
            break;
        case Aov::StfCore:
            put(Rgb(parts_[i].core * exposed));
            break;
        case Aov::StfReflection:
            put(Rgb(parts_[i].reflection * exposed));
            break;
        case Aov::PrimId:
        case Aov::InstanceId:
        case Aov::ElementId:
            break; // integers: readIds
        }
    }
    return out;
}

std::vector<std::int32_t> Film::readIds(Aov aov) const {
    std::vector<std::int32_t> out(hits_.size());
    for (std::size_t i = 0; i < hits_.size(); ++i) {
        out[i] = aov == Aov::PrimId       ? hits_[i].primId
                 : aov == Aov::InstanceId ? hits_[i].instanceId
                                          : hits_[i].elementId;
    }
    return out;
}

LuminanceEstimate Film::luminanceOf(const Accumulator& a) {
    if (a.count < 2) {
        return {0, std::numeric_limits<double>::infinity()};
    }
    const double inv = 1.0 / a.count;
    const Vec3d m = a.color * inv, v = (a.colorSquared * inv - m * m) * (1.0 / (a.count - 1));
    const Rgb deviation(float(std::sqrt(std::max(0.0, v.x))), float(std::sqrt(std::max(0.0, v.y))),
                        float(std::sqrt(std::max(0.0, v.z))));
    return {double(luminance(Rgb(m))), double(luminance(deviation))};
}

std::vector<LuminanceEstimate> Film::luminances() const {
    std::vector<LuminanceEstimate> out;
    out.reserve(pixels_.size());
    for (const Accumulator& a : pixels_) {
        out.push_back(luminanceOf(a));
    }
    return out;
}

double Film::relativeError() const {
    double mean = 0, error = 0;
    for (const Accumulator& a : pixels_) {
        const LuminanceEstimate e = luminanceOf(a);
        if (std::isfinite(e.error)) {
            error += e.error;
            mean += e.mean;
        }
    }
    return mean > 0 ? error / mean : 0;
}

} // namespace stf
